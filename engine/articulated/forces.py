"""The inertia of every link about its tree's origin, and the force that it needs to keep its velocity.

Of a body with its centre at r that moves by w and v_C there, under force f and torque tau,

    f = m (a_C - g) + m d v_C,    tau = I w' + w x I w + I e w

with a_C = a + w' x r + w x v_C of the spatial acceleration (w', a), with damping at the rates d and e.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 2.13 (inertia about a point) and 2.14 (equation of motion).
"""

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.motion import write_bias
from plumbline.engine.articulated.spatial import NOTHING, force_at, velocity_at
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Sym, Vec, load3, load6, load9, store6, store9
from plumbline.engine.maths.vec import add, axpy, cross, neg, sym_rotate, sym_vec
from plumbline.engine.memory import arena as at


@kernel
def centre_velocity(trees: Trees, i: int) -> Vec:
    """The velocity [m/s] of the centre of mass of link i along the tangent."""
    return velocity_at(load6(trees.motion, i, tree.VELOCITY), load3(trees.motion, i, tree.PLACE))


@kernel
def turned_inertia(trees: Trees, i: int) -> Sym:
    """The inertia [kg m2] of link i about its centre of mass, in W."""
    return sym_rotate(load9(trees.motion, i, tree.MATRIX), load6(trees.link, i, tree.INERTIA))


@kernel
def put_force(trees: Trees, i: int, torque: Vec, f: Vec) -> None:
    """Write the force of link i, of a torque and a force at its centre of mass."""
    store6(trees.answer, i, tree.FORCE, force_at(torque, f, load3(trees.motion, i, tree.PLACE)))


@kernel
def put_inertia(trees: Trees, i: int, inertia: Sym) -> None:
    """Write the spatial inertia of link i. Args: inertia: about its centre of mass, in W."""
    body, m, (x, y, z) = trees.body, trees.link[i, tree.MASS], load3(trees.motion, i, tree.PLACE)
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
def load_links(trees: Trees) -> None:
    """Write inertia, bias and force of every link under gravity, loads and damping."""
    link, load, g = trees.link, trees.bodies.load, load3(trees.setting, 0, at.GRAVITY)
    for i in range(link.shape[0]):
        m, b = link[i, tree.MASS], trees.kind[i, tree.ROW]
        w, v = load3(trees.motion, i, tree.VELOCITY), centre_velocity(trees, i)
        inertia = turned_inertia(trees, i)
        spin = sym_vec(inertia, w)
        torque = axpy(link[i, tree.ANGULAR_DAMPING], spin, neg(load3(load, b, 3)))
        if trees.gyroscopic == 1:
            torque = add(torque, cross(w, spin))
        f = axpy(m, cross(w, v), axpy(m * link[i, tree.LINEAR_DAMPING], v, axpy(-m, g, neg(load3(load, b, 0)))))
        put_force(trees, i, torque, f)
        put_inertia(trees, i, inertia)
        write_bias(trees, i)


@kernel
def weigh_links(trees: Trees) -> None:
    """Write inertia of every link, without damping, at rest and without forces: what an impulse meets."""
    for i in range(trees.link.shape[0]):
        put_inertia(trees, i, turned_inertia(trees, i))
        store6(trees.answer, i, tree.FORCE, NOTHING)
        store6(trees.motion, i, tree.BIAS, NOTHING)
