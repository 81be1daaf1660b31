"""Two bodies of a contact in registers, their relative motion at their manifold's centre, and impulses given to them there.

V of B against A at the centre and W = w_B - w_A, in the manifold's frame (t1, t2, n); force and moment in the same frame.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, section 2.4 (motion and force as six-vectors).
"""

from typing import NamedTuple

from plumbline.engine.compile.jit import inlined, kernel
from plumbline.engine.maths.rows import Floats, Mat, Sym, Vec, load3, load6, store3
from plumbline.engine.maths.vec import add, axpy, cross, mat_vec, sub, sym_scale, sym_vec, tmat_vec
from plumbline.engine.memory import arena as at


class Pair(NamedTuple):
    """Bodies A and B: their rows, inverse masses [1/kg], and inverse inertias in W [1/(kg m2)]."""

    a: int
    b: int
    mass_a: float
    inertia_a: Sym
    mass_b: float
    inertia_b: Sym


class Motion(NamedTuple):
    """Velocities [m/s] and angular velocities [rad/s] of A and B, in W."""

    va: Vec
    wa: Vec
    vb: Vec
    wb: Vec


@inlined
def pair_of(body: Floats, turned: Floats, a: int, b: int) -> Pair:
    """Two bodies as they weigh now."""
    mass_a, mass_b = body[a, at.INV_MASS], body[b, at.INV_MASS]
    return Pair(a, b, mass_a, load6(turned, a, 0), mass_b, load6(turned, b, 0))


@inlined
def lighter(pair: Pair, by_a: float, by_b: float) -> Pair:
    """The pair with A `by_a` times lighter, and B `by_b` times, in mass and inertia."""
    light_a, light_b = sym_scale(by_a, pair.inertia_a), sym_scale(by_b, pair.inertia_b)
    return Pair(pair.a, pair.b, by_a * pair.mass_a, light_a, by_b * pair.mass_b, light_b)


@inlined
def motion_of(state: Floats, a: int, b: int) -> Motion:
    """The velocities of two bodies."""
    return Motion(load3(state, a, at.V), load3(state, a, at.W), load3(state, b, at.V), load3(state, b, at.W))


@inlined
def store_motion(state: Floats, a: int, b: int, motion: Motion) -> None:
    """Put the velocities back into the state."""
    store3(state, a, at.V, motion.va)
    store3(state, a, at.W, motion.wa)
    store3(state, b, at.V, motion.vb)
    store3(state, b, at.W, motion.wb)


class Centre(NamedTuple):
    """The rotation from W to a manifold's frame, and the arms [m] to its centre from the centres of mass of A and B, in W."""

    frame: Mat
    arm_a: Vec
    arm_b: Vec


@kernel
def frame_of(manifold: Floats, m: int) -> Mat:
    """The rotation from W to the frame of manifold m, rows t1, t2, n."""
    t1, t2, n = load3(manifold, m, at.TANGENTS), load3(manifold, m, at.TANGENTS + 3), load3(manifold, m, at.NORMAL)
    return t1[0], t1[1], t1[2], t2[0], t2[1], t2[2], n[0], n[1], n[2]


@inlined
def centre_of(manifold: Floats, m: int) -> Centre:
    """The centre of manifold m."""
    return Centre(frame_of(manifold, m), load3(manifold, m, at.CENTRE_A), load3(manifold, m, at.CENTRE_B))


@kernel
def relative_motion(centre: Centre, motion: Motion) -> tuple[Vec, Vec]:
    """(V, W) of B against A at the centre, in the frame."""
    va, wa, vb, wb = motion
    return (
        mat_vec(centre.frame, sub(add(vb, cross(wb, centre.arm_b)), add(va, cross(wa, centre.arm_a)))),
        mat_vec(centre.frame, sub(wb, wa)),
    )


@kernel
def give_impulse(state: Floats, pair: Pair, centre: Centre, motion: Motion, force: Vec, moment: Vec) -> None:
    """Give the impulses of force [N s] and moment [N m s] at the centre, in the frame, to B, and their reaction to A."""
    f, t = tmat_vec(centre.frame, force), tmat_vec(centre.frame, moment)
    store3(state, pair.a, at.V, axpy(-pair.mass_a, f, motion.va))
    store3(state, pair.a, at.W, sub(motion.wa, sym_vec(pair.inertia_a, add(cross(centre.arm_a, f), t))))
    store3(state, pair.b, at.V, axpy(pair.mass_b, f, motion.vb))
    store3(state, pair.b, at.W, add(motion.wb, sym_vec(pair.inertia_b, add(cross(centre.arm_b, f), t))))
