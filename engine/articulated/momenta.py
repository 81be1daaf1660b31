"""The momenta of links, as semi-implicit Euler hands them on from one sub-step to the next.

A sub-step moves a body by the velocities v and w from its start to its end, which leave the momenta m v and L = I w, with the
inertia I of the start. Those of the next one obey, along every column S of the tangent there,

    S . ((m v, I w) - exp(-c h) ((m v, L)_last + h (f, tau))) = h (what acts along the column)

with the damping c of free bodies. Momenta are handed on as they are in W: so nothing is known of forces of turning bodies, and
where nothing acts they are kept to round-off.

Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, section VII.1.4 (SHAKE and RATTLE).
"""

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.forces import centre_velocity, put_force, put_inertia, turned_inertia
from plumbline.engine.articulated.motion import move_links
from plumbline.engine.articulated.spatial import NOTHING, Spatial, add6, sliding, turning
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.semi_implicit_euler import turn_inertia
from plumbline.engine.maths.elementary import exp
from plumbline.engine.maths.rows import Sym, Vec, load3, load6, load9, store3, store6
from plumbline.engine.maths.vec import add, axpy, mat_vec, scale, sub, sym_vec
from plumbline.engine.memory import arena as at


@kernel
def damp_over(trees: Trees, h: float) -> None:
    """Write what damping leaves of momenta over a sub-step h [s]."""
    link = trees.link
    for i in range(link.shape[0]):
        link[i, tree.SHARE] = exp(-link[i, tree.LINEAR_DAMPING] * h)
        link[i, tree.SPIN_SHARE] = exp(-link[i, tree.ANGULAR_DAMPING] * h)


@kernel
def bent_velocities(trees: Trees, i: int) -> Spatial:
    """w, and v of the centre of mass, of link i from the start of a sub-step to its end: along the tangent, and the bend."""
    w = load3(trees.motion, i, tree.VELOCITY)
    return add6((*w, *centre_velocity(trees, i)), load6(trees.passage, i, tree.BEND))


@kernel
def has_spin(trees: Trees, i: int) -> bool:
    """Whether what is kept of link i is its angular momentum; its angular velocity else."""
    return bool(trees.gyroscopic == 1 and trees.link[i, tree.MASS] > 0.0)


@kernel
def kept_spin(trees: Trees, i: int, inertia: Sym) -> Vec:
    """The angular momentum [kg m2/s] that link i comes with; without the gyroscopic effect, or mass, it is w that stays."""
    kept = load3(trees.passage, i, tree.KEPT_SPIN)
    return kept if has_spin(trees, i) else sym_vec(inertia, kept)


@kernel
def keep_momenta(trees: Trees) -> None:
    """Keep the momenta of this sub-step, from velocities along the tangent and their bends."""
    passage = trees.passage
    for i in range(passage.shape[0]):
        moved = bent_velocities(trees, i)
        w = turning(moved)
        store3(passage, i, tree.KEPT_SPIN, sym_vec(load6(passage, i, tree.TURNED_INERTIA), w) if has_spin(trees, i) else w)
        store3(passage, i, tree.KEPT_VELOCITY, sliding(moved))


@kernel
def write_kept_velocities(trees: Trees) -> None:
    """Write the velocities that the kept momenta mean to the bodies, whose poses are there already."""
    bodies = trees.bodies
    for i in range(trees.kind.shape[0]):
        b, spin = trees.kind[i, tree.ROW], load3(trees.passage, i, tree.KEPT_SPIN)
        if has_spin(trees, i):
            turn_inertia(bodies.state, bodies.body, bodies.turned, b)
            spin = sym_vec(load6(bodies.turned, b, 0), spin)
        store3(bodies.state, b, at.V, load3(trees.passage, i, tree.KEPT_VELOCITY))
        store3(bodies.state, b, at.W, spin)


@kernel
def begin_momenta(trees: Trees) -> None:
    """Keep the momenta that the present rates mean."""
    move_links(trees)
    for i in range(trees.passage.shape[0]):
        for bend in (tree.BEND, tree.LAST_BEND, tree.EARLIER_BEND):
            store6(trees.passage, i, bend, NOTHING)
        trees.passage[i, tree.CONTRACTION] = 1.0
        store6(trees.passage, i, tree.TURNED_INERTIA, turned_inertia(trees, i))
    keep_momenta(trees)


@kernel
def go_on_bending(trees: Trees) -> None:
    """Expect of the bend of every link what a parabola through the last three says."""
    passage = trees.passage
    for i in range(passage.shape[0]):
        for c in range(6):
            bend, last = passage[i, tree.BEND + c], passage[i, tree.LAST_BEND + c]
            passage[i, tree.BEND + c] = 3.0 * (bend - last) + passage[i, tree.EARLIER_BEND + c]
            passage[i, tree.LAST_BEND + c], passage[i, tree.EARLIER_BEND + c] = bend, last


@kernel
def load_momenta(trees: Trees, h: float) -> None:
    """Write inertia of every link, and the force that it needs to go on by the present rates and its bend under loads, and what
    contacts press it by."""
    link, passage, load, g = trees.link, trees.passage, trees.bodies.load, load3(trees.setting, 0, at.GRAVITY)
    for i in range(link.shape[0]):
        m, b, inertia, moved = link[i, tree.MASS], trees.kind[i, tree.ROW], turned_inertia(trees, i), bent_velocities(trees, i)
        store6(passage, i, tree.TURNED_INERTIA, inertia)
        arm = mat_vec(load9(trees.motion, i, tree.MATRIX), load3(link, i, tree.ANCHOR_B))
        store3(passage, i, tree.ANCHOR_W, add(load3(trees.motion, i, tree.PLACE), arm))
        pushed = axpy(h, load3(load, b, 0), scale(m, axpy(h, g, load3(passage, i, tree.KEPT_VELOCITY))))
        turned = axpy(h, load3(load, b, 3), kept_spin(trees, i, inertia))
        torque = axpy(-link[i, tree.SPIN_SHARE], turned, sym_vec(inertia, turning(moved)))
        f = axpy(-link[i, tree.SHARE], pushed, scale(m, sliding(moved)))
        torque, f = sub(torque, load3(passage, i, tree.PRESSURE)), sub(f, load3(passage, i, tree.PRESSURE + 3))
        put_force(trees, i, scale(1.0 / h, torque), scale(1.0 / h, f))
        put_inertia(trees, i, inertia)
