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
from typing import Final

import numpy as np

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.runge_kutta import (
    POSE,
    Trial,
    act_at_end,
    bases_at,
    find_accelerations,
    gather,
    go_through_stages,
    keep_beside,
    scatter,
)
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.dormand_prince import MOST_TRIALS, STAGES, A, E, next_stride
from plumbline.engine.maths.rows import Floats
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints

METHOD: Final = np.column_stack((A, [0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1]))
"""As `RK4`."""

SLOWEST = 1e-3
"""Rates [rad/s or m/s] are taken as at least this large: at a tolerance of 1e-12, what is less of their error is round-off."""


@kernel
def reactions_back(joints: Joints, trial: Trial) -> None:
    """Forget what a trial that failed has counted."""
    for j in range(trial.carried.shape[0]):
        for c in range(6):
            joints.joint[j, at.REACTION + c] = trial.carried[j, c]


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
def dormand_prince(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, end: float, gyroscopic: int, ends: bool, trial: Trial
) -> bool:
    """Advance all trees and bases by `end` seconds in as many steps as the tolerance asks for, counting what joints carry.

    Args: ends: as `ends_with_laws`. Returns: whether they sufficed, and the laws had an answer.
    """
    stride = tables.passage[0, tree.KEPT_STRIDE] if tables.passage[0, tree.KEPT_STRIDE] > 0.0 else end
    done, rejected = 0.0, False
    find_accelerations(tables, bodies, joints, setting, gyroscopic)
    gather(tables, trial.y, 0)
    keep_beside(tables, bodies, joints, trial)
    for _ in range(MOST_TRIALS):
        left = end - done
        cut = stride >= left
        h = left if cut else min(stride, 0.5 * left)
        go_through_stages(tables, bodies, joints, setting, h, gyroscopic, METHOD, trial)
        error = largest_error(tables, trial, h)
        accepted, stride = next_stride(error, setting[0, at.STEP_TOLERANCE], h, stride, cut, rejected)
        rejected = not accepted
        if accepted:
            done += h
            if ends:
                if not act_at_end(tables, bodies, joints, setting, h, gyroscopic):
                    return False
                find_accelerations(tables, bodies, joints, setting, gyroscopic)
            if cut:
                tables.passage[0, tree.KEPT_STRIDE] = stride
                return True
            gather(tables, trial.y, 0)
            keep_beside(tables, bodies, joints, trial)
        else:
            scatter(tables, trial.y, 0)
            bases_at(tables, bodies, trial, 0.0)
            reactions_back(joints, trial)
            find_accelerations(tables, bodies, joints, setting, gyroscopic)
    return False
