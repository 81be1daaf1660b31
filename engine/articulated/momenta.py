"""The momenta of links, as semi-implicit Euler hands them on from one sub-step to the next.

A sub-step moves a body by the velocities v and w from its start to its end, which leave the momenta m v and L = I w, with the
inertia I of the start. Those of the next one obey, along every column S of the tangent there,

    S . ((m v, I w) - exp(-c h) ((m v, L)_last + h (f, tau))) = h (what acts along the column)

with the damping c of free bodies. Momenta are handed on as they are in W: so nothing is known of forces of turning bodies, and
where nothing acts they are kept to round-off.

Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, section VII.1.4 (SHAKE and RATTLE).
"""

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.forces import put_inertia
from plumbline.engine.articulated.motion import move_links
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.semi_implicit_euler import turn_inertia
from plumbline.engine.maths.elementary import exp
from plumbline.engine.maths.rows import Floats, Sym, Vec, load3, load6, load9, store3, store6
from plumbline.engine.maths.vec import add, axpy, cross, mat_vec, scale, sub, sym_rotate, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies


@kernel
def damp_over(tables: Tables, h: float) -> None:
    """Write what damping leaves of momenta over a sub-step h [s]."""
    link = tables.link
    for i in range(link.shape[0]):
        link[i, tree.SHARE] = exp(-link[i, tree.LINEAR_DAMPING] * h)
        link[i, tree.SPIN_SHARE] = exp(-link[i, tree.ANGULAR_DAMPING] * h)


@kernel
def centre_velocity(tables: Tables, i: int) -> Vec:
    """The velocity [m/s] of the centre of mass of link i along the tangent."""
    w, r = load3(tables.motion, i, tree.VELOCITY), load3(tables.motion, i, tree.PLACE)
    return add(load3(tables.motion, i, tree.VELOCITY + 3), cross(w, r))


@kernel
def put_force(tables: Tables, i: int, torque: Vec, f: Vec) -> None:
    """Write the force of link i, of a torque and a force at its centre of mass."""
    store3(tables.body, i, tree.FORCE, add(torque, cross(load3(tables.motion, i, tree.PLACE), f)))
    store3(tables.body, i, tree.FORCE + 3, f)


@kernel
def has_spin(tables: Tables, i: int, gyroscopic: int) -> bool:
    """Whether what is kept of link i is its angular momentum; its angular velocity else."""
    return bool(gyroscopic == 1 and tables.link[i, tree.MASS] > 0.0)


@kernel
def kept_spin(tables: Tables, i: int, inertia: Sym, gyroscopic: int) -> Vec:
    """The angular momentum [kg m2/s] that link i comes with; without the gyroscopic effect, or mass, it is w that stays."""
    kept = load3(tables.passage, i, tree.KEPT_SPIN)
    return kept if has_spin(tables, i, gyroscopic) else sym_vec(inertia, kept)


@kernel
def keep_momenta(tables: Tables, gyroscopic: int) -> None:
    """Keep the momenta of this sub-step, from velocities along the tangent and their bends."""
    passage = tables.passage
    for i in range(passage.shape[0]):
        w = add(load3(tables.motion, i, tree.VELOCITY), load3(passage, i, tree.BEND))
        spin = sym_vec(load6(passage, i, tree.TURNED_INERTIA), w) if has_spin(tables, i, gyroscopic) else w
        store3(passage, i, tree.KEPT_SPIN, spin)
        store3(passage, i, tree.KEPT_VELOCITY, add(centre_velocity(tables, i), load3(passage, i, tree.BEND + 3)))


@kernel
def write_kept_velocities(tables: Tables, bodies: Bodies, gyroscopic: int) -> None:
    """Write the velocities that the kept momenta mean to the bodies, whose poses are there already."""
    for i in range(tables.kind.shape[0]):
        b, spin = tables.kind[i, tree.ROW], load3(tables.passage, i, tree.KEPT_SPIN)
        if has_spin(tables, i, gyroscopic):
            turn_inertia(bodies.state, bodies.body, bodies.turned, b)
            spin = sym_vec(load6(bodies.turned, b, 0), spin)
        store3(bodies.state, b, at.V, load3(tables.passage, i, tree.KEPT_VELOCITY))
        store3(bodies.state, b, at.W, spin)


@kernel
def begin_momenta(tables: Tables, bodies: Bodies, gyroscopic: int) -> None:
    """Keep the momenta that the present rates mean."""
    move_links(tables, bodies.state)
    for i in range(tables.passage.shape[0]):
        for c in range(6):
            for bend in (tree.BEND, tree.LAST_BEND, tree.EARLIER_BEND):
                tables.passage[i, bend + c] = 0.0
        tables.passage[i, tree.CONTRACTION] = 1.0
        inertia = sym_rotate(load9(tables.motion, i, tree.MATRIX), load6(tables.link, i, tree.INERTIA))
        store6(tables.passage, i, tree.TURNED_INERTIA, inertia)
    keep_momenta(tables, gyroscopic)


@kernel
def go_on_bending(tables: Tables) -> None:
    """Expect of the bend of every link what a parabola through the last three says."""
    passage = tables.passage
    for i in range(passage.shape[0]):
        for c in range(6):
            bend, last = passage[i, tree.BEND + c], passage[i, tree.LAST_BEND + c]
            passage[i, tree.BEND + c] = 3.0 * (bend - last) + passage[i, tree.EARLIER_BEND + c]
            passage[i, tree.LAST_BEND + c], passage[i, tree.EARLIER_BEND + c] = bend, last


@kernel
def load_momenta(tables: Tables, bodies: Bodies, setting: Floats, h: float, gyroscopic: int) -> None:
    """Write inertia of every link, and the force that it needs to go on by the present rates and its bend."""
    link, passage, load, g = tables.link, tables.passage, bodies.load, load3(setting, 0, at.GRAVITY)
    for i in range(link.shape[0]):
        m, b, turn = link[i, tree.MASS], tables.kind[i, tree.ROW], load9(tables.motion, i, tree.MATRIX)
        inertia = sym_rotate(turn, load6(link, i, tree.INERTIA))
        store6(passage, i, tree.TURNED_INERTIA, inertia)
        store3(
            passage, i, tree.ANCHOR_W, add(load3(tables.motion, i, tree.PLACE), mat_vec(turn, load3(link, i, tree.ANCHOR_B)))
        )
        w = add(load3(tables.motion, i, tree.VELOCITY), load3(passage, i, tree.BEND))
        v = add(centre_velocity(tables, i), load3(passage, i, tree.BEND + 3))
        pushed = axpy(h, load3(load, b, 0), scale(m, axpy(h, g, load3(passage, i, tree.KEPT_VELOCITY))))
        turned = axpy(h, load3(load, b, 3), kept_spin(tables, i, inertia, gyroscopic))
        torque = axpy(-link[i, tree.SPIN_SHARE], turned, sym_vec(inertia, w))
        put_force(tables, i, scale(1.0 / h, torque), scale(1.0 / h, axpy(-link[i, tree.SHARE], pushed, scale(m, v))))
        put_inertia(tables.body, i, inertia, m, load3(tables.motion, i, tree.PLACE))


@kernel
def press_links(tables: Tables, h: float) -> None:
    """Take from the force that every link needs what contacts give it over h."""
    body = tables.body
    for i in range(body.shape[0]):
        f = scale(1.0 / h, load3(tables.stage, i, tree.PRESSURE))
        torque = axpy(1.0 / h, load3(tables.stage, i, tree.PRESSURE + 3), cross(load3(tables.motion, i, tree.PLACE), f))
        store3(body, i, tree.FORCE, sub(load3(body, i, tree.FORCE), torque))
        store3(body, i, tree.FORCE + 3, sub(load3(body, i, tree.FORCE + 3), f))
