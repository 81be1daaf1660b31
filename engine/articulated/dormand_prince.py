"""Dormand and Prince's embedded pair of orders 5 and 4 with adaptive steps, in joint coordinates.

    k_i = f(y + h sum_j a_ij k_j),  y <- y + h sum_i a_7i k_i,  e = h sum_i e_i k_i
    accept if |e| <= tolerance,  h <- h clip(0.9 (tolerance / |e|)^(1/5), 0.2, 5)

y = (q, q') of all trees of a world, which share a step; orientations are quaternions that are made unit ones when a step is
accepted. The error is that of rates relative to all of them, and that of orientations and of hinges [rad]; that of a way [m] is
the integral of that of its rate. It lands on the end of a sub-step exactly, where limits act as in Runge-Kutta's method.

Source: Dormand, Prince, J. Comput. Appl. Math. 6 (1980) 19; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I,
table II.5.2 and equation (II.4.13).
"""

import math
from typing import Final, NamedTuple

import numpy as np

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions, change_rates
from plumbline.engine.articulated.articulated_body import accelerations
from plumbline.engine.articulated.bases import carry_bases
from plumbline.engine.articulated.bounded import solve_laws
from plumbline.engine.articulated.forces import load_links
from plumbline.engine.articulated.laws import STIFF_ALONE
from plumbline.engine.articulated.motion import move_links, rates_of
from plumbline.engine.articulated.runge_kutta import push_columns
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.dormand_prince import MOST_TRIALS, STAGES, A, E
from plumbline.engine.integrate.runge_kutta import quat_rate
from plumbline.engine.maths.elementary import fifth_root
from plumbline.engine.maths.rows import Floats, load4, store4
from plumbline.engine.maths.vec import quat_unit
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints

POSE: Final = 7
"""Numbers of a link's pose in y."""

AHEAD: Final = np.array([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1])
"""Where in a step each stage is."""

SLOWEST = 1e-3
"""Rates [rad/s or m/s] are taken as at least this large: at a tolerance of 1e-12, what is less of their error is round-off."""


class Trial(NamedTuple):
    """What a trial step works on: y (2 rows: at its start, and where it comes to), the slopes k (STAGES rows), and what the
    bases' poses and the joints' reactions were at its start, a row each."""

    y: Floats
    k: Floats
    base: Floats
    carried: Floats


@kernel
def room_for_trials(tables: Tables, joints: Joints) -> Trial:
    """Room for a trial step of all trees."""
    length = POSE * tables.kind.shape[0] + tables.column.shape[0]
    base, carried = np.zeros((tables.other.shape[0], POSE)), np.zeros((joints.joint.shape[0], 6))
    return Trial(np.zeros((2, length)), np.zeros((STAGES, length)), base, carried)


@kernel
def gather(tables: Tables, y: Floats, row: int) -> None:
    """Write the present coordinates and rates into a row of y."""
    n = tables.kind.shape[0]
    for i in range(n):
        for c in range(POSE):
            y[row, POSE * i + c] = tables.coordinate[i, c]
    for k in range(tables.column.shape[0]):
        y[row, POSE * n + k] = tables.column[k, tree.RATE]


@kernel
def scatter(tables: Tables, y: Floats, row: int) -> None:
    """Take coordinates and rates from a row of y."""
    n = tables.kind.shape[0]
    for i in range(n):
        for c in range(POSE):
            tables.coordinate[i, c] = y[row, POSE * i + c]
    for k in range(tables.column.shape[0]):
        tables.column[k, tree.RATE] = y[row, POSE * n + k]


@kernel
def keep_beside(tables: Tables, bodies: Bodies, joints: Joints, trial: Trial) -> None:
    """Note poses of bases, and reactions, as they are."""
    for n in range(tables.other.shape[0]):
        for c in range(POSE):
            trial.base[n, c] = bodies.state[tables.other[n, 0], c]
    for j in range(trial.carried.shape[0]):
        for c in range(6):
            trial.carried[j, c] = joints.joint[j, at.REACTION + c]


@kernel
def bases_at(tables: Tables, bodies: Bodies, trial: Trial, h: float) -> None:
    """Put the bases where they are h seconds after the trial's start."""
    for n in range(tables.other.shape[0]):
        for c in range(POSE):
            bodies.state[tables.other[n, 0], c] = trial.base[n, c]
    carry_bases(tables, bodies, h)


@kernel
def reactions_back(joints: Joints, trial: Trial) -> None:
    """Forget what a trial that failed has counted."""
    for j in range(trial.carried.shape[0]):
        for c in range(6):
            joints.joint[j, at.REACTION + c] = trial.carried[j, c]


@kernel
def find_accelerations(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, gyroscopic: int) -> None:
    """Write the accelerations at the present coordinates and rates."""
    move_links(tables, bodies.state)
    push_columns(tables, joints)
    load_links(tables, bodies, setting, gyroscopic)
    accelerations(tables, True)


@kernel
def write_slope(tables: Tables, k: Floats, stage: int) -> None:
    """Write the rates of coordinates and rates into row `stage` of k."""
    coordinate, column, kind = tables.coordinate, tables.column, tables.kind
    n = kind.shape[0]
    for i in range(n):
        first, offset = kind[i, tree.FIRST], POSE * i
        if kind[i, tree.TYPE] == at.REVOLUTE or kind[i, tree.TYPE] == at.PRISMATIC:
            k[stage, offset] = column[first, tree.RATE]
        elif kind[i, tree.TYPE] == at.BALL or kind[i, tree.TYPE] == tree.FREE:
            store4(k, stage, offset, quat_rate(load4(coordinate, i, 0), rates_of(tables, first)))
        if kind[i, tree.TYPE] == tree.FREE:
            for c in range(3):
                k[stage, offset + tree.POSITION + c] = column[first + 3 + c, tree.RATE]
    for c in range(column.shape[0]):
        k[stage, POSE * n + c] = column[c, tree.CHANGE]


@kernel
def largest_error(tables: Tables, trial: Trial, h: float) -> float:
    """|h sum e_i k_i|, the larger of that of rates, relative to all of them, and of any orientation or hinge [rad]."""
    y, k, n = trial.y, trial.k, tables.kind.shape[0]
    largest = before = after = error = 0.0
    for j in range(POSE * n, k.shape[1]):
        e = 0.0
        for i in range(STAGES):
            e += E[i] * k[i, j]
        error += e * e
        before += y[0, j] * y[0, j]
        after += y[1, j] * y[1, j]
    largest = abs(h) * math.sqrt(error) / max(math.sqrt(max(before, after)), SLOWEST)
    for i in range(n):
        if tables.kind[i, tree.TYPE] == at.PRISMATIC:
            continue
        error = 0.0
        for c in range(4):
            e = 0.0
            for stage in range(STAGES):
                e += E[stage] * k[stage, POSE * i + c]
            error += e * e
        # A sum is not finite if any part is not, while a maximum may pass it over.
        turn = abs(h) * math.sqrt(error)
        largest = turn if not turn <= largest else largest
    return largest


@kernel
def try_step(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, trial: Trial) -> float:
    """Go on by h from y, where accelerations are known, counting what joints carry. Returns: the error."""
    y, k = trial.y, trial.k
    write_slope(tables, k, 0)
    add_reactions(tables, joints, h * A[STAGES - 1, 0])
    for i in range(1, STAGES):
        for j in range(k.shape[1]):
            total = 0.0
            for s in range(i):
                total += A[i, s] * k[s, j]
            y[1, j] = y[0, j] + h * total
        scatter(tables, y, 1)
        bases_at(tables, bodies, trial, AHEAD[i] * h)
        find_accelerations(tables, bodies, joints, setting, gyroscopic)
        if i < STAGES - 1:
            add_reactions(tables, joints, h * A[STAGES - 1, i])
        write_slope(tables, k, i)
    return largest_error(tables, trial, h)


@kernel
def accept(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, ends: bool) -> bool:
    """Make orientations unit ones, and let limits act, after a step h. Returns: whether the laws had an answer."""
    for i in range(tables.kind.shape[0]):
        if tables.kind[i, tree.TYPE] == at.BALL or tables.kind[i, tree.TYPE] == tree.FREE:
            store4(tables.coordinate, i, 0, quat_unit(load4(tables.coordinate, i, 0)))
    if ends:
        move_links(tables, bodies.state)
        if not solve_laws(tables, bodies, joints, setting, h, gyroscopic, STIFF_ALONE):
            return False
        add_reactions(tables, joints, h)
        change_rates(tables, h)
        find_accelerations(tables, bodies, joints, setting, gyroscopic)
    return True


@kernel
def dormand_prince(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, end: float, gyroscopic: int, ends: bool, trial: Trial
) -> bool:
    """Advance all trees and bases by `end` seconds in as many steps as the tolerance asks for, counting what joints carry.

    Args: ends: as `ends_with_laws`. Returns: whether they sufficed, and the laws had an answer.
    """
    tolerance = setting[0, at.STEP_TOLERANCE]
    stride = tables.passage[0, tree.KEPT_STRIDE] if tables.passage[0, tree.KEPT_STRIDE] > 0.0 else end
    done, rejected = 0.0, False
    find_accelerations(tables, bodies, joints, setting, gyroscopic)
    gather(tables, trial.y, 0)
    keep_beside(tables, bodies, joints, trial)
    for _ in range(MOST_TRIALS):
        left = end - done
        cut = stride >= left
        h = left if cut else min(stride, 0.5 * left)
        error = try_step(tables, bodies, joints, setting, h, gyroscopic, trial)
        overflow = not math.isfinite(error)
        factor = 0.2 if overflow else (min(5.0, 0.9 * fifth_root(tolerance / error)) if error > 0.0 else 5.0)
        if error <= tolerance and not overflow:
            # A step cut short by the end says nothing against the longer one that was meant.
            stride = max(stride, h * factor) if cut else h * (min(factor, 1.0) if rejected else factor)
            rejected = False
            done += h
            if not accept(tables, bodies, joints, setting, h, gyroscopic, ends):
                return False
            if cut:
                tables.passage[0, tree.KEPT_STRIDE] = stride
                return True
            gather(tables, trial.y, 0)
            keep_beside(tables, bodies, joints, trial)
        else:
            stride, rejected = h * max(0.2, factor), True
            scatter(tables, trial.y, 0)
            bases_at(tables, bodies, trial, 0.0)
            reactions_back(joints, trial)
            find_accelerations(tables, bodies, joints, setting, gyroscopic)
    return False
