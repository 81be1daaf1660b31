"""The compiled parts of an exact step, one by one: find contacts, kick, assemble, give impulses, drift; and, where there are
joints, their rows and a last look at their gaps.

A contact has three rows of the one format of `constrain.joint_rows`, those of its normal and two tangents: J v is its relative
velocity, and J M^-1 J^T and J^T are taken as those of joints are.
"""

import math

import numpy as np

from plumbline.engine.compile.jit import entry
from plumbline.engine.constrain.coordinate import bounded_rows
from plumbline.engine.constrain.direct import assemble, rate
from plumbline.engine.constrain.joint_rows import equality_rows
from plumbline.engine.constrain.open_joints import open_joint
from plumbline.engine.integrate import all_bodies
from plumbline.engine.maths.rows import Floats, Ints, load3, load6, store3
from plumbline.engine.maths.vec import add, axpy, cross, dot, neg, scale, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DONE
from plumbline.engine.memory.tables import Rows, bodies_of, joints_of, present_contacts, rows_of, shapes_of
from plumbline.engine.respond.arms import refresh
from plumbline.engine.respond.softness import slow_approach
from plumbline.engine.respond.substep import approach, sum_impulses
from plumbline.engine.steps.count_step import count_step
from plumbline.engine.steps.stages import meet_jointed

BROUGHT, FRICTION, RESTITUTION, APART, COLUMNS = 0, 3, 4, 5, 6
"""Columns of what is said of a contact: the impulse (3) N s that it brings, along its rows, Coulomb's and Newton's coefficient,
and its gap [m]."""


@entry
def begin_step(floats: Floats, ints: Ints) -> int:
    """Find the contacts of a step and advance the bodies that neither they nor joints touch. Returns: as `find_contacts`."""
    status = meet_jointed(floats, ints)
    if status == DONE:
        bodies, setting, count = bodies_of(floats, ints), floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
        all_bodies.advance_untouched(bodies, setting, count, ints_of(ints, at.BODY_ORDER))
    return status


@entry
def kick_touched(floats: Floats, ints: Ints, h: float) -> float:
    """Gravity, loads and damping for h seconds on the bodies in contact, and note the points that will strike.

    Returns: the approach speed [m/s] below which nothing bounces.
    """
    bodies, setting = bodies_of(floats, ints), floats_of(floats, ints, at.SETTING)
    all_bodies.kick_all(bodies, all_bodies.touched_of(ints), setting, h)
    slow = slow_approach(setting, h)
    approach(bodies, present_contacts(floats, ints), setting, h, slow)
    return slow


@entry
def write_contacts(floats: Floats, ints: Ints, points: Ints, body: Ints, row: Floats, values: Floats) -> int:
    """Write points (k,), body (3k, 2), row (3k, 18) and values (k, COLUMNS), as of `ContactRows`, of all present contacts.

    Returns: k.
    """
    contacts, k = present_contacts(floats, ints), 0
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    for m in range(len(contacts.order)):
        axes = load3(manifold, m, at.NORMAL), load3(manifold, m, at.TANGENTS), load3(manifold, m, at.TANGENTS + 3)
        for p in range(4 * m, 4 * m + key[m, at.POINTS]):
            impulse = axpy(point[p, at.NORMAL_IMPULSE], axes[0], load3(point, p, at.TANGENT_IMPULSE))
            points[k] = p
            for c in range(3):
                r, axis = 3 * k + c, axes[c]
                body[r, 0], body[r, 1] = key[m, at.BODY_A], key[m, at.BODY_B]
                store3(row, r, at.JACOBIAN, neg(axis))
                store3(row, r, at.JACOBIAN + 3, cross(axis, load3(point, p, at.ARM_A)))
                store3(row, r, at.JACOBIAN + 6, axis)
                store3(row, r, at.JACOBIAN + 9, cross(load3(point, p, at.ARM_B), axis))
                values[k, BROUGHT + c] = dot(axis, impulse)
            values[k, FRICTION], values[k, RESTITUTION] = manifold[m, at.LAW + 1], manifold[m, at.LAW + 2]
            values[k, APART] = point[p, at.SEPARATION]
            k += 1
    return k


@entry
def write_problem(floats: Floats, ints: Ints, body: Ints, row: Floats, lift: Floats, w: Floats, q: Floats) -> float:
    """Write W = J M^-1 J^T (3k, 3k) and q (k, 3), J v with `lift` (k,) m/s added along the normals. Args: of `ContactRows`.

    Returns: the largest of the velocities J v and of the rebounds [m/s]; no number where one is none.
    """
    bodies, square, total = bodies_of(floats, ints), 0.0, 0.0
    rows = Rows(row, body, np.empty((len(row), 12)), w, w, w)
    assemble(rows, len(row), bodies)
    for i in range(len(lift)):
        size = 0.0
        for c in range(3):
            q[i, c] = rate(bodies.state, rows, 3 * i + c)
            size += q[i, c] * q[i, c]
        q[i, 0] += lift[i]
        square, total = max(square, size, min(lift[i], 0.0) ** 2), total + size
    return math.sqrt(square) if math.isfinite(total) else math.nan


@entry
def give_impulses(floats: Floats, ints: Ints, points: Ints, body: Ints, row: Floats, impulse: Floats, moving: int) -> None:
    """Keep impulses (k, 3) N s with the points of `ContactRows`. Args: moving: 1 to change the velocities as well."""
    bodies, point = bodies_of(floats, ints), floats_of(floats, ints, at.POINT)
    state = bodies.state
    for i in range(len(point)):
        for c in range(at.NORMAL_IMPULSE, at.TANGENT_IMPULSE + 3):
            point[i, c] = 0.0  # contacts left out of the problem give none
    for i in range(len(points)):
        one, two = load3(row, 3 * i + 1, at.JACOBIAN + 6), load3(row, 3 * i + 2, at.JACOBIAN + 6)
        point[points[i], at.NORMAL_IMPULSE] = impulse[i, 0]
        store3(point, points[i], at.TANGENT_IMPULSE, axpy(impulse[i, 1], one, scale(impulse[i, 2], two)))
        for side in range(2 * moving):
            b, push, turn = body[3 * i, side], (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
            for c in range(3):
                push = axpy(impulse[i, c], load3(row, 3 * i + c, at.JACOBIAN + 6 * side), push)
                turn = axpy(impulse[i, c], load3(row, 3 * i + c, at.JACOBIAN + 6 * side + 3), turn)
            store3(state, b, at.V, axpy(bodies.body[b, at.INV_MASS], push, load3(state, b, at.V)))
            store3(state, b, at.W, add(sym_vec(load6(bodies.turned, b, 0), turn), load3(state, b, at.W)))


@entry
def drift_touched(floats: Floats, ints: Ints, h: float, last: int) -> int:
    """Move the bodies in contact for h seconds. Args: last: 1 to end the step. Returns: DONE, or DIVERGED."""
    bodies, contacts, count = bodies_of(floats, ints), present_contacts(floats, ints), ints_of(ints, at.COUNT)
    all_bodies.drift_all(bodies, all_bodies.touched_of(ints), count, h)
    refresh(bodies.state, shapes_of(floats, ints), contacts)
    sum_impulses(contacts)
    return int(count_step(bodies.state, count)) if last == 1 else DONE


@entry
def write_joint_rows(floats: Floats, ints: Ints, h: float) -> tuple[int, int]:
    """Write the rows of all joints for the present pose, over h seconds. Returns: how many are equalities, and of all."""
    bodies, joints, rows = bodies_of(floats, ints), joints_of(floats, ints), rows_of(floats, ints)
    equalities = equality_rows(bodies.state, joints, rows)
    return equalities, bounded_rows(bodies.state, joints, rows, equalities, h, stiff_alone=False)


@entry
def look_at_joints(floats: Floats, ints: Ints) -> int:
    """Returns: as `open_joint`."""
    return open_joint(floats, ints, touching=True)
