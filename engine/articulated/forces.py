"""The inertia of every link about its tree's origin, and the force that it needs to keep its velocity.

Of a body with its centre at r that moves by w and v_C there, under force f and torque tau,

    f = m (a_C - g) + m d v_C,    tau = I w' + w x I w + I e w

with a_C = a + w' x r + w x v_C of the spatial acceleration (w', a), with damping at the rates d and e.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 2.13 (inertia about a point) and 2.14 (equation of motion).
"""

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.motion import write_bias
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Sym, Vec, load3, load6, load9, store3, store6, store9
from plumbline.engine.maths.vec import add, axpy, cross, neg, sym_rotate, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies


@kernel
def put_inertia(body: Floats, i: int, inertia: Sym, m: float, r: Vec) -> None:
    """Write the spatial inertia of link i: of mass m at r, and `inertia` about it."""
    x, y, z = r
    xx, yy, zz = m * x * x, m * y * y, m * z * z
    store6(
        body, i, tree.ROTATION,
        (
            inertia[0] + yy + zz, inertia[1] + xx + zz, inertia[2] + xx + yy,
            inertia[3] - m * x * y, inertia[4] - m * x * z, inertia[5] - m * y * z,
        ),
    )  # fmt: skip
    store6(body, i, tree.TRANSLATION, (m, m, m, 0.0, 0.0, 0.0))
    store9(body, i, tree.COUPLING, (0.0, -m * z, m * y, m * z, 0.0, -m * x, -m * y, m * x, 0.0))


@kernel
def load_links(tables: Tables, bodies: Bodies, setting: Floats, gyroscopic: int) -> None:
    """Write inertia, bias and force of every link under gravity, loads and damping."""
    link, motion, body = tables.link, tables.motion, tables.body
    g = load3(setting, 0, at.GRAVITY)
    for i in range(link.shape[0]):
        m, r = link[i, tree.MASS], load3(motion, i, tree.PLACE)
        w = load3(motion, i, tree.VELOCITY)
        v = add(load3(motion, i, tree.VELOCITY + 3), cross(w, r))
        inertia = sym_rotate(load9(motion, i, tree.MATRIX), load6(link, i, tree.INERTIA))
        spin = sym_vec(inertia, w)
        b = tables.kind[i, tree.ROW]
        torque = axpy(link[i, tree.ANGULAR_DAMPING], spin, neg(load3(bodies.load, b, 3)))
        if gyroscopic == 1:
            torque = add(torque, cross(w, spin))
        f = axpy(m, cross(w, v), axpy(m * link[i, tree.LINEAR_DAMPING], v, axpy(-m, g, neg(load3(bodies.load, b, 0)))))
        store3(body, i, tree.FORCE, add(torque, cross(r, f)))
        store3(body, i, tree.FORCE + 3, f)
        put_inertia(body, i, inertia, m, r)
        write_bias(tables, bodies.state, i)


@kernel
def weigh_links(tables: Tables) -> None:
    """Write inertia of every link, without damping, at rest and without forces: what an impulse meets."""
    link, motion, body = tables.link, tables.motion, tables.body
    for i in range(link.shape[0]):
        inertia = sym_rotate(load9(motion, i, tree.MATRIX), load6(link, i, tree.INERTIA))
        put_inertia(body, i, inertia, link[i, tree.MASS], load3(motion, i, tree.PLACE))
        for c in range(6):
            body[i, tree.FORCE + c] = 0.0
            motion[i, tree.BIAS + c] = 0.0
