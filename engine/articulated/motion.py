"""Forward kinematics of trees: poses, axes, velocities and bias accelerations of links, from coordinates and rates.

    X_i = X_parent X_joint(q),  v_i = v_parent + sum S_k q'_k,  c_i = v_parent x sum S_k q'_k

All spatial vectors are in W about the tree's origin, a point at rest in W that lies at the root's anchor now, so that nothing
is transformed from link to link and a tree a thousand kilometres away loses no digits. A ball's rates are those of its turning
in the axes of its parent; a free root's are w_WB and v_WB.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 2.2 (spatial vectors), 3.5 (acceleration) and 4.4 (joints).
"""

import math

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import cos_sin
from plumbline.engine.maths.floats import fma
from plumbline.engine.maths.rows import Floats, Mat, Quat, Vec, load3, load4, load9, store3, store4, store9
from plumbline.engine.maths.vec import add, axpy, cross, dot, mat_vec, neg, quat_mul, sub
from plumbline.engine.memory import arena as at

STILL: Vec = (0.0, 0.0, 0.0)
EYE: Mat = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@kernel
def turn_of(q: Quat) -> Mat:
    """The rotation matrix of a unit quaternion."""
    w, x, y, z = q
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


@kernel
def hinge_turn(tables: Tables, i: int, x: float) -> Quat:
    """The orientation of link i on its parent, where its hinge stands at x [rad]."""
    half = 0.5 * (x - tables.link[i, tree.START_X])
    c, s = cos_sin(half)
    start, about = load4(tables.link, i, tree.TURN), load4(tables.link, i, tree.TURNED_AXIS)
    return (
        fma(c, start[0], s * about[0]),
        fma(c, start[1], s * about[1]),
        fma(c, start[2], s * about[2]),
        fma(c, start[3], s * about[3]),
    )


@kernel
def rates_of(tables: Tables, k: int) -> Vec:
    """The rates of three columns from k on."""
    column = tables.column
    return column[k, tree.RATE], column[k + 1, tree.RATE], column[k + 2, tree.RATE]


@kernel
def change_along(column: Floats, k: int, left: float, change: float, a_w: Vec, a_v: Vec) -> tuple[float, Vec, Vec]:
    """What column k changes of its rate by the force that is left along it, on a link with this acceleration but for that, and
    the acceleration with it. Args: change: what is taken where it is prescribed.
    """
    if column[k, tree.ADDED] != math.inf:
        taken = dot(load3(column, k, tree.PULL), a_w) + dot(load3(column, k, tree.PULL + 3), a_v)
        change = column[k, tree.INVERSE] * (left - taken)
    a_w = axpy(change, load3(column, k, tree.AXIS_W), a_w)
    return change, a_w, axpy(change, load3(column, k, tree.AXIS_W + 3), a_v)


@kernel
def put_axis(column: Floats, k: int, angular: Vec, linear: Vec) -> None:
    """Write the motion along column k."""
    store3(column, k, tree.AXIS_W, angular)
    store3(column, k, tree.AXIS_W + 3, linear)


@kernel
def base_of(tables: Tables, state: Floats, i: int) -> tuple[Quat, Vec, Vec, Vec]:
    """Of the base of root i: orientation, angular velocity, velocity at the tree's origin, and acceleration there.

    The base keeps its velocities. What is at a point at rest changes as the base goes by: by -w x v of its centre.
    """
    b = tables.kind[i, tree.BASE]
    q, w, v = load4(state, b, at.Q), load3(state, b, at.W), load3(state, b, at.V)
    arm = mat_vec(turn_of(q), load3(tables.link, i, tree.ANCHOR_A))
    store3(tables.motion, i, tree.ORIGIN, add(load3(state, b, at.P), arm))
    return q, w, add(v, cross(w, arm)), neg(cross(w, v))


@kernel
def move_links(tables: Tables, state: Floats) -> None:
    """Write pose and velocity of every link and the axes of its columns, from coordinates, rates and the bases."""
    link, motion, column, coordinate = tables.link, tables.motion, tables.column, tables.coordinate
    for i in range(tables.kind.shape[0]):
        kind, parent, first = tables.kind[i, tree.TYPE], tables.kind[i, tree.PARENT], tables.kind[i, tree.FIRST]
        if kind == tree.FREE:
            q = load4(coordinate, i, 0)
            w, v = rates_of(tables, first), rates_of(tables, first + 3)
            for k in range(3):
                e = (EYE[3 * k], EYE[3 * k + 1], EYE[3 * k + 2])
                put_axis(column, first + k, e, STILL)
                put_axis(column, first + 3 + k, STILL, e)
            store3(motion, i, tree.ORIGIN, load3(coordinate, i, tree.POSITION))
            store4(motion, i, tree.ORIENTATION, q)
            store9(motion, i, tree.MATRIX, turn_of(q))
            store3(motion, i, tree.PLACE, STILL)
            store3(motion, i, tree.VELOCITY, w)
            store3(motion, i, tree.VELOCITY + 3, v)
            continue
        if parent >= 0:
            q_a, anchor = load4(motion, parent, tree.ORIENTATION), load3(motion, parent, tree.PLACE)
            w_a, v_a = load3(motion, parent, tree.VELOCITY), load3(motion, parent, tree.VELOCITY + 3)
            turn_a = load9(motion, parent, tree.MATRIX)
            anchor = add(anchor, mat_vec(turn_a, load3(link, i, tree.ANCHOR_A)))
        else:
            q_a, w_a, v_a, _a = base_of(tables, state, i)
            turn_a, anchor = turn_of(q_a), STILL
        turn_ab = load4(link, i, tree.TURN)
        w, v = w_a, v_a
        if kind == at.REVOLUTE:
            turn_ab = hinge_turn(tables, i, coordinate[i, 0])
            n = mat_vec(turn_a, load3(link, i, tree.AXIS))
            lever, rate = cross(anchor, n), column[first, tree.RATE]
            put_axis(column, first, n, lever)
            w, v = axpy(rate, n, w), axpy(rate, lever, v)
        elif kind == at.PRISMATIC:
            n = mat_vec(turn_a, load3(link, i, tree.AXIS))
            put_axis(column, first, STILL, n)
            v = axpy(column[first, tree.RATE], n, v)
            anchor = axpy(coordinate[i, 0] - link[i, tree.START_X], n, anchor)
        elif kind == at.BALL:
            turn_ab = load4(coordinate, i, 0)
            for k in range(3):
                n = (turn_a[k], turn_a[3 + k], turn_a[6 + k])
                lever, rate = cross(anchor, n), column[first + k, tree.RATE]
                put_axis(column, first + k, n, lever)
                w, v = axpy(rate, n, w), axpy(rate, lever, v)
        q_b = quat_mul(q_a, turn_ab)
        turn_b = turn_of(q_b)
        store9(motion, i, tree.MATRIX, turn_b)
        store4(motion, i, tree.ORIENTATION, q_b)
        store3(motion, i, tree.PLACE, sub(anchor, mat_vec(turn_b, load3(link, i, tree.ANCHOR_B))))
        store3(motion, i, tree.VELOCITY, w)
        store3(motion, i, tree.VELOCITY + 3, v)


@kernel
def carrier(tables: Tables, state: Floats, i: int) -> tuple[Vec, Vec, Vec]:
    """The spatial velocity of what carries the axes of link i, and the acceleration of its base at the tree's origin."""
    parent, first = tables.kind[i, tree.PARENT], tables.kind[i, tree.FIRST]
    if tables.kind[i, tree.TYPE] == tree.FREE:
        # The axes of its turning go with its centre of mass.
        return STILL, rates_of(tables, first + 3), STILL
    if parent >= 0:
        return load3(tables.motion, parent, tree.VELOCITY), load3(tables.motion, parent, tree.VELOCITY + 3), STILL
    _q, w, v, a = base_of(tables, state, i)
    return w, v, a


@kernel
def write_bias(tables: Tables, state: Floats, i: int) -> None:
    """Write the acceleration that velocities alone give link i against its parent."""
    motion, (w_a, v_a, a) = tables.motion, carrier(tables, state, i)
    turning = sub(load3(motion, i, tree.VELOCITY), w_a)
    sliding = sub(load3(motion, i, tree.VELOCITY + 3), v_a)
    store3(motion, i, tree.BIAS, cross(w_a, turning))
    store3(motion, i, tree.BIAS + 3, add(a, add(cross(w_a, sliding), cross(v_a, turning))))
