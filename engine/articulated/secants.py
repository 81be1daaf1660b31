"""Where a sub-step takes the links, and by how much their way there leaves the tangent of its start.

    X_i(q + h q') from X_i(q):  v = (p(q + h q') - p(q)) / h,  exp(h w) R(q) = R(q + h q');   bend = (w, v) - T(q) q'
"""

import math

from engine.articulated.advance import rates_of
from engine.articulated.momenta import centre_velocity, put_force
from engine.articulated.motion import hinge_turn, turn_of
from engine.articulated.tables import (
    ANCHOR_A,
    ANCHOR_B,
    AXIS,
    BASE,
    BEND,
    END_MATRIX,
    END_ORIENTATION,
    END_PLACE,
    FIRST,
    FREE,
    HEAVIER,
    MASS,
    ORIENTATION,
    PARENT,
    PLACE,
    RATE,
    START_X,
    STIFFER,
    TURN,
    TURNED_INERTIA,
    TYPE,
    VELOCITY,
    Tables,
)
from engine.compile.jit import kernel
from engine.maths.vec import (
    Mat,
    Quat,
    Vec,
    add,
    axpy,
    dot,
    load3,
    load4,
    load6,
    load9,
    mat_vec,
    quat_conj,
    quat_mul,
    quat_turn,
    scale,
    store3,
    store4,
    store9,
    sub,
    sym_vec,
)  # fmt: skip
from engine.memory.arena import BALL, PRISMATIC, REVOLUTE, Q, V, W
from engine.memory.tables import Bodies

__all__ = ["bend_links", "go_to_ends"]

SMALL = 4e-4
"""The square of half an angle up to which its series is as good as round-off: the next term is below 1e-18 of the first."""

FAR = 2.0
"""An angle [rad] from which on a turn may be meant as one by more than half a round, or the other way."""


@kernel
def angular_velocity(start: Quat, end: Quat, h: float, near: Vec) -> Vec:
    """w with exp(h w) start = end; of all those, that nearest to `near`."""
    d = quat_mul(end, quat_conj(start))
    sign = 1.0 if d[0] >= 0.0 else -1.0
    x = (sign * d[1], sign * d[2], sign * d[3])
    square = dot(x, x)
    far = h * h * dot(near, near) > FAR * FAR
    if square < SMALL and not far:
        ratio = 2.0 + square * (1.0 / 3.0 + square * (3.0 / 20.0 + square * (5.0 / 56.0 + square * 35.0 / 576.0)))
        return scale(ratio / h, x)
    sine = math.sqrt(square)
    if sine == 0.0:
        return near if far else x
    angle = 2.0 * math.atan2(sine, sign * d[0])
    if far:
        angle += 2.0 * math.pi * math.floor((h * dot(near, x) / sine - angle) / (2.0 * math.pi) + 0.5)
    return scale(angle / (h * sine), x)


@kernel
def base_end(tables: Tables, bodies: Bodies, i: int, h: float) -> tuple[Quat, Mat, Vec]:
    """Of the base of root i after h seconds: orientation, its matrix, and the way of the tree's origin on it."""
    state, b = bodies.state, tables.kind[i, BASE]
    start, arm = load4(state, b, Q), load3(tables.link, i, ANCHOR_A)
    end = quat_turn(start, load3(state, b, W), h)
    turn = turn_of(end)
    return end, turn, axpy(h, load3(state, b, V), sub(mat_vec(turn, arm), mat_vec(turn_of(start), arm)))


@kernel
def go_to_ends(tables: Tables, bodies: Bodies, h: float) -> None:
    """Write the pose of every link after h seconds by the present rates."""
    link, passage, coordinate, column = tables.link, tables.passage, tables.coordinate, tables.column
    for i in range(tables.kind.shape[0]):
        kind, parent, first = tables.kind[i, TYPE], tables.kind[i, PARENT], tables.kind[i, FIRST]
        if kind == FREE:
            q = quat_turn(load4(coordinate, i, 0), rates_of(tables, first), h)
            store4(passage, i, END_ORIENTATION, q)
            store9(passage, i, END_MATRIX, turn_of(q))
            store3(passage, i, END_PLACE, scale(h, rates_of(tables, first + 3)))
            continue
        if parent >= 0:
            q, turn = load4(passage, parent, END_ORIENTATION), load9(passage, parent, END_MATRIX)
            anchor = add(load3(passage, parent, END_PLACE), mat_vec(turn, load3(link, i, ANCHOR_A)))
        else:
            q, turn, anchor = base_end(tables, bodies, i, h)
        turn_ab = load4(link, i, TURN)
        if kind == REVOLUTE:
            turn_ab = hinge_turn(tables, i, coordinate[i, 0] + h * column[first, RATE])
        elif kind == PRISMATIC:
            way = coordinate[i, 0] + h * column[first, RATE] - link[i, START_X]
            anchor = axpy(way, mat_vec(turn, load3(link, i, AXIS)), anchor)
        elif kind == BALL:
            turn_ab = quat_turn(load4(coordinate, i, 0), rates_of(tables, first), h)
        q = quat_mul(q, turn_ab)
        turn = turn_of(q)
        store4(passage, i, END_ORIENTATION, q)
        store9(passage, i, END_MATRIX, turn)
        store3(passage, i, END_PLACE, sub(anchor, mat_vec(turn, load3(link, i, ANCHOR_B))))


@kernel
def bend_links(tables: Tables, h: float) -> None:
    """Write the bend of every link anew, and the force that it needs for what is new of it."""
    link, motion, passage = tables.link, tables.motion, tables.passage
    for i in range(link.shape[0]):
        tangent = load3(motion, i, VELOCITY)
        w = angular_velocity(load4(motion, i, ORIENTATION), load4(passage, i, END_ORIENTATION), h, tangent)
        v = scale(1.0 / h, sub(load3(passage, i, END_PLACE), load3(motion, i, PLACE)))
        turning, sliding = sub(w, tangent), sub(v, centre_velocity(tables, i))
        more_w, more_v = sub(turning, load3(passage, i, BEND)), sub(sliding, load3(passage, i, BEND + 3))
        store3(passage, i, BEND, turning)
        store3(passage, i, BEND + 3, sliding)
        torque = sym_vec(load6(passage, i, TURNED_INERTIA), more_w)
        put_force(
            tables, i, scale(link[i, STIFFER] / h, torque), scale(link[i, HEAVIER] * link[i, MASS] / h, more_v)
        )  # fmt: skip
