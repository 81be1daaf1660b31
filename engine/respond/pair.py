"""The two bodies of a contact in registers: their inverse masses, and their velocities while a sweep works on them."""

from typing import NamedTuple

from plumbline.engine.compile.jit import inlined
from plumbline.engine.maths.rows import Floats, Sym, Vec, load3, load6, store3
from plumbline.engine.maths.vec import sym_scale
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
