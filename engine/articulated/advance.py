"""Coordinates and rates as they move on, as the state of the bodies that they mean, and the bases that trees hang on.

Bases are kinematic bodies, which go their own way. One that is told another velocity takes its trees along by what the joints
transmit and no more: what slides on it, or turns, is left behind. That is an impulse, which meets the inertia of the links
alone:

    M(q) dq' = -(what the jump of the base gives along each column),   by the articulated-body algorithm with c_root = the jump

Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, section IV.8 (Lie group methods); Featherstone, Rigid Body
Dynamics Algorithms, 2008, sections 7.3 and 11.7 (impulsive dynamics).
"""

import math

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.articulated_body import accelerations, transmitted
from plumbline.engine.articulated.forces import weigh_links
from plumbline.engine.articulated.motion import move_links, rates_of
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.articulated.ties import follow_coordinates, follow_rates
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, load3, load4, load9, store3, store4
from plumbline.engine.maths.vec import add, axpy, cross, mat_vec, neg, quat_mat, quat_turn, quat_unit, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints


@kernel
def carry_bases(tables: Tables, bodies: Bodies, h: float) -> None:
    """Move the kinematic bodies for h seconds."""
    state = bodies.state
    for n in range(tables.other.shape[0]):
        b = tables.other[n, 0]
        if bodies.kind[b, at.MOTION] == at.KINEMATIC:
            store3(state, b, at.P, axpy(h, load3(state, b, at.V), load3(state, b, at.P)))
            store4(state, b, at.Q, quat_turn(load4(state, b, at.Q), load3(state, b, at.W), h))


@kernel
def free_columns(tables: Tables, joints: Joints) -> None:
    """Let no force act along any column, and rotors turn with those that have one."""
    column, kind = tables.column, tables.kind
    for k in range(column.shape[0]):
        column[k, tree.ADDED] = column[k, tree.PUSH] = 0.0
    for i in range(kind.shape[0]):
        j = kind[i, tree.JOINT]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            column[kind[i, tree.FIRST], tree.ADDED] = joints.joint[j, at.ARMATURE]


@kernel
def jumped(tables: Tables, bodies: Bodies) -> bool:
    """Whether a base has another velocity than it was last seen with."""
    state, motion, kind = bodies.state, tables.motion, tables.kind
    for i in range(kind.shape[0]):
        b = kind[i, tree.BASE]
        if b >= 0 and bodies.kind[b, at.MOTION] == at.KINEMATIC:
            for c in range(3):
                if (
                    motion[i, tree.BASE_VELOCITY + c] != state[b, at.W + c]
                    or motion[i, tree.BASE_VELOCITY + 3 + c] != state[b, at.V + c]
                ):
                    return True
    return False


@kernel
def take_jumps(tables: Tables, bodies: Bodies, joints: Joints) -> bool:
    """Change all rates by what jumps of the bases' velocities do since they were last seen. Returns: whether there were any."""
    if not jumped(tables, bodies):
        return False
    state, motion, kind, column = bodies.state, tables.motion, tables.kind, tables.column
    move_links(tables, state)
    weigh_links(tables)
    free_columns(tables, joints)
    for i in range(kind.shape[0]):
        b = kind[i, tree.BASE]
        if kind[i, tree.PARENT] >= 0 or b < 0 or bodies.kind[b, at.MOTION] != at.KINEMATIC:
            continue
        w, v = load3(state, b, at.W), load3(state, b, at.V)
        turning, sliding = sub(w, load3(motion, i, tree.BASE_VELOCITY)), sub(v, load3(motion, i, tree.BASE_VELOCITY + 3))
        arm = mat_vec(quat_mat(load4(state, b, at.Q)), load3(tables.link, i, tree.ANCHOR_A))
        store3(motion, i, tree.BIAS, turning)
        store3(motion, i, tree.BIAS + 3, add(sliding, cross(turning, arm)))
        store3(motion, i, tree.BASE_VELOCITY, w)
        store3(motion, i, tree.BASE_VELOCITY + 3, v)
    accelerations(tables, True)
    for k in range(column.shape[0]):
        column[k, tree.RATE] += column[k, tree.CHANGE]
    weigh_links(tables)
    return True


@kernel
def change_rates(tables: Tables, h: float) -> None:
    """q' <- q' + h q''; where a jump fixes the rate, it is that of the jump to the last bit."""
    column, law = tables.column, tables.law
    for k in range(column.shape[0]):
        if column[k, tree.ADDED] == math.inf:
            column[k, tree.RATE] = law[k, tree.HELD]
        else:
            column[k, tree.RATE] += h * column[k, tree.CHANGE]
    follow_rates(tables)


@kernel
def drift_coordinates(tables: Tables, h: float) -> None:
    """Move all coordinates for h seconds with their rates."""
    coordinate, kind = tables.coordinate, tables.kind
    for i in range(kind.shape[0]):
        k = kind[i, tree.FIRST]
        if kind[i, tree.TYPE] == at.REVOLUTE or kind[i, tree.TYPE] == at.PRISMATIC:
            coordinate[i, 0] += h * tables.column[k, tree.RATE]
        elif kind[i, tree.TYPE] == at.BALL or kind[i, tree.TYPE] == tree.FREE:
            store4(coordinate, i, 0, quat_turn(load4(coordinate, i, 0), rates_of(tables, k), h))
            if kind[i, tree.TYPE] == tree.FREE:
                store3(coordinate, i, tree.POSITION, axpy(h, rates_of(tables, k + 3), load3(coordinate, i, tree.POSITION)))
    follow_coordinates(tables)


@kernel
def is_finite_forest(tables: Tables, state: Floats) -> bool:
    """Whether every coordinate and rate is finite, and every number of the state of a body that no tree has."""
    # Sums of a row do not wait for each other.
    total = 0.0
    for i in range(tables.coordinate.shape[0]):
        row = 0.0
        for c in range(7):
            row += 0.0 * tables.coordinate[i, c]
        total += row
    for n in range(tables.other.shape[0]):
        row = 0.0
        for c in range(13):
            row += 0.0 * state[tables.other[n, 0], c]
        total += row
    for k in range(tables.column.shape[0]):
        total += 0.0 * tables.column[k, tree.RATE]
    return math.isfinite(total)


@kernel
def write_state(tables: Tables, bodies: Bodies, joints: Joints) -> None:
    """Write pose and velocity of every link to its body, and coordinates to their joints."""
    state, motion, kind = bodies.state, tables.motion, tables.kind
    move_links(tables, state)
    for i in range(kind.shape[0]):
        b, r, w = kind[i, tree.ROW], load3(motion, i, tree.PLACE), load3(motion, i, tree.VELOCITY)
        store3(state, b, at.P, add(load3(motion, kind[i, tree.ROOT], tree.ORIGIN), r))
        store4(state, b, at.Q, quat_unit(load4(motion, i, tree.ORIENTATION)))
        store3(state, b, at.V, add(load3(motion, i, tree.VELOCITY + 3), cross(w, r)))
        store3(state, b, at.W, w)
        if kind[i, tree.TYPE] == at.REVOLUTE or kind[i, tree.TYPE] == at.PRISMATIC:
            joints.joint[kind[i, tree.JOINT], at.COORDINATE] = tables.coordinate[i, 0]


@kernel
def add_reactions(tables: Tables, joints: Joints, share: float) -> None:
    """Count what the joints carry now towards their reactions, as if for `share` seconds."""
    kind, joint, motion = tables.kind, joints.joint, tables.motion
    for i in range(kind.shape[0]):
        j = kind[i, tree.JOINT]
        if j < 0:
            continue
        torque, force = transmitted(tables, i)
        if joints.kind[j, at.CHILD] == kind[i, tree.ROW]:
            turn = load9(motion, i, tree.MATRIX)
            about = add(load3(motion, i, tree.PLACE), mat_vec(turn, load3(tables.link, i, tree.ANCHOR_B)))
        else:
            # The joint's child is what this link hangs on, and takes the opposite, about its own anchor.
            torque, force, about = neg(torque), neg(force), (0.0, 0.0, 0.0)
            if kind[i, tree.PARENT] >= 0:
                turn = load9(motion, kind[i, tree.PARENT], tree.MATRIX)
                about = add(
                    load3(motion, kind[i, tree.PARENT], tree.PLACE), mat_vec(turn, load3(tables.link, i, tree.ANCHOR_A))
                )
        store3(joint, j, at.REACTION, axpy(share, force, load3(joint, j, at.REACTION)))
        moment = sub(torque, cross(about, force))
        store3(joint, j, at.REACTION + 3, axpy(share, moment, load3(joint, j, at.REACTION + 3)))
