"""Coordinates and rates as they move on, and as the state of the bodies that they mean.

Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, section IV.8 (Lie group methods).
"""

import math

from engine.articulated.articulated_body import transmitted
from engine.articulated.motion import move_links
from engine.articulated.tables import (
    ADDED,
    ANCHOR_A,
    ANCHOR_B,
    BREAK,
    CHANGE,
    FIRST,
    FREE,
    JOINT,
    MATRIX,
    ORIENTATION,
    ORIGIN,
    PARENT,
    PLACE,
    POSITION,
    RATE,
    ROOT,
    ROW,
    SEGMENT,
    TYPE,
    VELOCITY,
    Tables,
)
from engine.compile.jit import kernel
from engine.maths.vec import (
    Vec,
    add,
    axpy,
    cross,
    load3,
    load4,
    load9,
    mat_vec,
    neg,
    quat_turn,
    quat_unit,
    store3,
    store4,
    sub,
)  # fmt: skip
from engine.memory.arena import BALL, CHILD, COORDINATE, PRISMATIC, REACTION, REVOLUTE, P, Q, V, W
from engine.memory.tables import Bodies, Joints

__all__ = ["add_reactions", "change_rates", "drift_coordinates", "is_finite_forest", "rates_of", "write_state"]


@kernel
def rates_of(tables: Tables, k: int) -> Vec:
    """The rates of three columns from k on."""
    column = tables.column
    return column[k, RATE], column[k + 1, RATE], column[k + 2, RATE]


@kernel
def change_rates(tables: Tables, h: float) -> None:
    """q' <- q' + h q''; where a jump fixes the rate, it is that of the jump to the last bit."""
    column, law = tables.column, tables.law
    for k in range(column.shape[0]):
        if column[k, ADDED] == math.inf:
            column[k, RATE] = law[k, BREAK + int(law[k, SEGMENT]) // 2]
        else:
            column[k, RATE] += h * column[k, CHANGE]


@kernel
def drift_coordinates(tables: Tables, h: float) -> None:
    """Move all coordinates for h seconds with their rates."""
    coordinate, kind = tables.coordinate, tables.kind
    for i in range(kind.shape[0]):
        k = kind[i, FIRST]
        if kind[i, TYPE] == REVOLUTE or kind[i, TYPE] == PRISMATIC:
            coordinate[i, 0] += h * tables.column[k, RATE]
        elif kind[i, TYPE] == BALL or kind[i, TYPE] == FREE:
            store4(coordinate, i, 0, quat_turn(load4(coordinate, i, 0), rates_of(tables, k), h))
            if kind[i, TYPE] == FREE:
                store3(coordinate, i, POSITION, axpy(h, rates_of(tables, k + 3), load3(coordinate, i, POSITION)))


@kernel
def is_finite_forest(tables: Tables) -> bool:
    """Whether every coordinate and rate is finite."""
    total = 0.0
    for i in range(tables.coordinate.shape[0]):
        for c in range(7):
            total += 0.0 * tables.coordinate[i, c]
    for k in range(tables.column.shape[0]):
        total += 0.0 * tables.column[k, RATE]
    return math.isfinite(total)


@kernel
def write_state(tables: Tables, bodies: Bodies, joints: Joints) -> None:
    """Write pose and velocity of every link to its body, and coordinates to their joints."""
    state, motion, kind = bodies.state, tables.motion, tables.kind
    move_links(tables, state)
    for i in range(kind.shape[0]):
        b, r, w = kind[i, ROW], load3(motion, i, PLACE), load3(motion, i, VELOCITY)
        store3(state, b, P, add(load3(motion, kind[i, ROOT], ORIGIN), r))
        store4(state, b, Q, quat_unit(load4(motion, i, ORIENTATION)))
        store3(state, b, V, add(load3(motion, i, VELOCITY + 3), cross(w, r)))
        store3(state, b, W, w)
        if kind[i, TYPE] == REVOLUTE or kind[i, TYPE] == PRISMATIC:
            joints.joint[kind[i, JOINT], COORDINATE] = tables.coordinate[i, 0]


@kernel
def add_reactions(tables: Tables, joints: Joints, share: float) -> None:
    """Count what the joints carry now towards their reactions, as if for `share` seconds."""
    kind, joint, motion = tables.kind, joints.joint, tables.motion
    for i in range(kind.shape[0]):
        j = kind[i, JOINT]
        if j < 0:
            continue
        torque, force = transmitted(tables, i)
        if joints.kind[j, CHILD] == kind[i, ROW]:
            turn = load9(motion, i, MATRIX)
            about = add(load3(motion, i, PLACE), mat_vec(turn, load3(tables.link, i, ANCHOR_B)))
        else:
            # The joint's child is what this link hangs on, and takes the opposite, about its own anchor.
            torque, force, about = neg(torque), neg(force), (0.0, 0.0, 0.0)
            if kind[i, PARENT] >= 0:
                turn = load9(motion, kind[i, PARENT], MATRIX)
                about = add(load3(motion, kind[i, PARENT], PLACE), mat_vec(turn, load3(tables.link, i, ANCHOR_A)))
        store3(joint, j, REACTION, axpy(share, force, load3(joint, j, REACTION)))
        moment = sub(torque, cross(about, force))
        store3(joint, j, REACTION + 3, axpy(share, moment, load3(joint, j, REACTION + 3)))
