"""Forward kinematics of trees: poses, axes, velocities and bias accelerations of links, from coordinates and rates.

    X_i = X_parent X_joint(q),  v_i = v_parent + sum S_k q'_k,  c_i = v_parent x sum S_k q'_k

All spatial vectors are in W about the tree's origin, a point at rest in W that lies at the root's anchor now, so that nothing
is transformed from link to link and a tree a thousand kilometres away loses no digits. A ball's rates are those of its turning
in the axes of its parent; a free root's are w_WB and v_WB, those of a ball and of three slides.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 2.2 (spatial vectors), 3.5 (acceleration) and 4.4 (joints).
"""

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.spatial import NOTHING, STILL, Spatial, across, add6, axpy6, sub6
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import cos_sin
from plumbline.engine.maths.floats import fma
from plumbline.engine.maths.rows import Mat, Quat, Vec, load3, load4, load6, load9, store3, store4, store6, store9
from plumbline.engine.maths.vec import add, axpy, cross, mat_vec, neg, quat_mul, sub
from plumbline.engine.memory import arena as at

UPRIGHT: Quat = (1.0, 0.0, 0.0, 0.0)


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
def hinge_turn(trees: Trees, i: int, x: float) -> Quat:
    """The orientation of link i on its parent, where its hinge stands at x [rad]."""
    half = 0.5 * (x - trees.link[i, tree.START_X])
    c, s = cos_sin(half)
    start, about = load4(trees.link, i, tree.TURN), load4(trees.link, i, tree.TURNED_AXIS)
    return (
        fma(c, start[0], s * about[0]),
        fma(c, start[1], s * about[1]),
        fma(c, start[2], s * about[2]),
        fma(c, start[3], s * about[3]),
    )


@kernel
def rates_of(trees: Trees, k: int) -> Vec:
    """The rates of three columns from k on."""
    column = trees.column
    return column[k, tree.RATE], column[k + 1, tree.RATE], column[k + 2, tree.RATE]


@kernel
def base_of(trees: Trees, i: int) -> tuple[Quat, Spatial, Vec]:
    """Of the base of root i: orientation, velocity, and acceleration at the tree's origin.

    The base keeps its velocities. What is at a point at rest changes as the base goes by: by -w x v of its centre.
    """
    state, b = trees.bodies.state, trees.kind[i, tree.BASE]
    q, w, v = load4(state, b, at.Q), load3(state, b, at.W), load3(state, b, at.V)
    arm = mat_vec(turn_of(q), load3(trees.link, i, tree.ANCHOR_A))
    store3(trees.motion, i, tree.ORIGIN, add(load3(state, b, at.P), arm))
    return q, (*w, *add(v, cross(w, arm))), neg(cross(w, v))


@kernel
def put_axes(trees: Trees, i: int, turn: Mat, anchor: Vec) -> None:
    """Write the motions along the columns of link i, whose joint is at an anchor of what it hangs on, turned so."""
    column, kind, first = trees.column, trees.kind[i, tree.TYPE], trees.kind[i, tree.FIRST]
    if kind == at.REVOLUTE or kind == at.PRISMATIC:
        n = mat_vec(turn, load3(trees.link, i, tree.AXIS))
        if kind == at.REVOLUTE:
            store6(column, first, tree.AXIS_W, (*n, *cross(anchor, n)))
        else:
            store6(column, first, tree.AXIS_W, (*STILL, *n))
    elif kind != at.FIXED:
        for k in range(3):
            n = (turn[k], turn[3 + k], turn[6 + k])
            store6(column, first + k, tree.AXIS_W, (*n, *cross(anchor, n)))
            if kind == tree.FREE:
                store6(column, first + 3 + k, tree.AXIS_W, (*STILL, *n))


@kernel
def move_links(trees: Trees) -> None:
    """Write pose and velocity of every link and the axes of its columns, from coordinates, rates and the bases."""
    link, motion, column, coordinate = trees.link, trees.motion, trees.column, trees.coordinate
    for i in range(trees.kind.shape[0]):
        kind, parent, first = trees.kind[i, tree.TYPE], trees.kind[i, tree.PARENT], trees.kind[i, tree.FIRST]
        if parent >= 0:
            q, turn = load4(motion, parent, tree.ORIENTATION), load9(motion, parent, tree.MATRIX)
            velocity = load6(motion, parent, tree.VELOCITY)
            anchor = add(load3(motion, parent, tree.PLACE), mat_vec(turn, load3(link, i, tree.ANCHOR_A)))
        elif kind == tree.FREE:
            q, velocity, anchor = UPRIGHT, NOTHING, STILL
            turn = turn_of(q)
            store3(motion, i, tree.ORIGIN, load3(coordinate, i, tree.POSITION))
        else:
            q, velocity, _a = base_of(trees, i)
            turn, anchor = turn_of(q), STILL
        put_axes(trees, i, turn, anchor)
        for k in range(first, first + trees.kind[i, tree.COLUMNS]):
            velocity = axpy6(column[k, tree.RATE], load6(column, k, tree.AXIS_W), velocity)
        turn_ab = load4(link, i, tree.TURN)
        if kind == at.REVOLUTE:
            turn_ab = hinge_turn(trees, i, coordinate[i, 0])
        elif kind == at.PRISMATIC:
            anchor = axpy(coordinate[i, 0] - link[i, tree.START_X], load3(column, first, tree.AXIS_W + 3), anchor)
        elif kind != at.FIXED:
            turn_ab = load4(coordinate, i, 0)
        q = quat_mul(q, turn_ab)
        turn = turn_of(q)
        store9(motion, i, tree.MATRIX, turn)
        store4(motion, i, tree.ORIENTATION, q)
        store3(motion, i, tree.PLACE, sub(anchor, mat_vec(turn, load3(link, i, tree.ANCHOR_B))))
        store6(motion, i, tree.VELOCITY, velocity)


@kernel
def carrier(trees: Trees, i: int) -> tuple[Spatial, Vec]:
    """The velocity of what carries the axes of link i, and the acceleration of its base at the tree's origin."""
    parent, first = trees.kind[i, tree.PARENT], trees.kind[i, tree.FIRST]
    if trees.kind[i, tree.TYPE] == tree.FREE:
        # The axes of its turning go with its centre of mass.
        return (*STILL, *rates_of(trees, first + 3)), STILL
    if parent >= 0:
        return load6(trees.motion, parent, tree.VELOCITY), STILL
    _q, velocity, a = base_of(trees, i)
    return velocity, a


@kernel
def write_bias(trees: Trees, i: int) -> None:
    """Write the acceleration that velocities alone give link i against its parent."""
    carried, a = carrier(trees, i)
    bias = across(carried, sub6(load6(trees.motion, i, tree.VELOCITY), carried))
    store6(trees.motion, i, tree.BIAS, add6((*STILL, *a), bias))
