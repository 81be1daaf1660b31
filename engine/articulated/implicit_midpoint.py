"""Implicit midpoint in joint coordinates and their momenta: of second order, symmetric and, for hinges and slides, symplectic.

    p_m = p + h/2 p'(q_m, q'_m),  q_m = q + h/2 q'_m,    p <- 2 p_m - p,  q <- q + h q'_m   (orientations turn by exp(h w))

with p = M(q) q'. What is linear in p or of second degree in p and q is kept to round-off where nothing acts on it, so momentum
and angular momentum about any point. The equation is solved by Newton's method with the mass matrix alone, whose rounds make
the error smaller by about h/2 times the angular velocities; where that is no share, its rounds are mixed (`mixing`). Springs
and drives are in it, limits act at the end of the step.

Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, sections II.1.1, V.1 and VI.4.2 (theorem 4.2).
"""

import math

import numpy as np

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions, carry_bases, change_rates, drift_coordinates, free_columns
from plumbline.engine.articulated.articulated_body import accelerations
from plumbline.engine.articulated.bounded import settle_laws, solve_laws
from plumbline.engine.articulated.column_momenta import begin_column_momenta, column_momenta, rates_of_momenta
from plumbline.engine.articulated.forces import load_links
from plumbline.engine.articulated.laws import SMOOTH, STIFF_ALONE, take_laws, write_laws
from plumbline.engine.articulated.mixing import DEPTH, mixed
from plumbline.engine.articulated.motion import move_links
from plumbline.engine.articulated.runge_kutta import push_columns
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.articulated.ties import follow_rates
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints

ROUND_OFF = 1e-11
"""The change of a rate, as a share of the largest one, that ends the rounds: what it leaves is smaller again by a round."""

PLAIN_ROUNDS = 20
"""Some eight are needed where h times the angular velocities is small; where one changes more than the last, none will do."""

MOST_ROUNDS = 100
"""Of those that are mixed; more are needed where the step is far too long."""


@kernel
def go_to_middle(tables: Tables, bodies: Bodies, h: float) -> None:
    """Write pose and velocity of links in the middle; coordinates stay at the start, which `stage` holds."""
    drift_coordinates(tables, 0.5 * h)
    move_links(tables, bodies.state)
    for i in range(tables.stage.shape[0]):
        for c in range(7):
            tables.coordinate[i, c] = tables.stage[i, c]


@kernel
def push_by_momenta(tables: Tables, joints: Joints, h: float) -> None:
    """Write into every column the force over h/2 that brings its momentum to that of the middle, and its law at these rates."""
    column = tables.column
    for k in range(column.shape[0]):
        column[k, tree.BESIDE] += (tables.stage_rate[k, tree.KEPT_MOMENTUM] - column[k, tree.MOMENTUM]) / (0.5 * h)
        column[k, tree.ADDED], column[k, tree.PUSH] = 0.0, column[k, tree.BESIDE]
    take_laws(tables, joints, 0.5 * h)


@kernel
def change_middle(tables: Tables, joints: Joints, h: float) -> tuple[float, float]:
    """Write rates and momenta that a round gives the middle. Returns: the largest change of a rate, and the largest rate."""
    column, kind, change, rate = tables.column, tables.kind, 0.0, 0.0
    for i in range(kind.shape[0]):
        # Of what is added to the inertia, the rotor is in the momentum; the rest is a law's force at the new rate.
        j, k = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            column[k, tree.PUSH] -= (column[k, tree.ADDED] - joints.joint[j, at.ARMATURE]) * column[k, tree.CHANGE]
    for t in range(tables.tie.shape[0]):
        follower, pull = tables.follower[t, 0], tables.tie[t, tree.PULLED]
        column[kind[follower, tree.FIRST], tree.PUSH] += pull
        column[kind[kind[follower, tree.LEADER], tree.FIRST], tree.PUSH] -= tables.link[follower, tree.RATIO] * pull
    for k in range(column.shape[0]):
        column[k, tree.MOMENTUM] += 0.5 * h * column[k, tree.PUSH]
        column[k, tree.RATE] += 0.5 * h * column[k, tree.CHANGE]
        change, rate = max(change, abs(0.5 * h * column[k, tree.CHANGE])), max(rate, abs(column[k, tree.RATE]))
    follow_rates(tables)
    return change, rate


@kernel
def guess_middle(tables: Tables) -> None:
    """Write the rates from which rounds begin: those of the start, changed as they were in the last step."""
    column, kept = tables.column, tables.stage_rate
    for k in range(column.shape[0]):
        column[k, tree.RATE] = kept[k, tree.KEPT_RATE] + kept[k, tree.KEPT_CHANGE]


@kernel
def refine_middle(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, breaks: int
) -> tuple[float, float]:
    """One round. Args: breaks: as `write_laws` returns. Returns: as `change_middle`; inf where the laws have no answer."""
    go_to_middle(tables, bodies, h)
    column_momenta(tables, bodies, joints, setting, gyroscopic)
    push_by_momenta(tables, joints, h)
    if not settle_laws(tables, bodies, joints, setting, 0.5 * h, gyroscopic, SMOOTH, breaks):
        return math.inf, 0.0
    return change_middle(tables, joints, h)


@kernel
def mix_rounds(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, breaks: int) -> bool:
    """Write the rates of the middle by rounds that are mixed. Returns: whether they were found."""
    column = tables.column
    past, answer = np.empty((4, DEPTH + 1, column.shape[0])), np.empty(column.shape[0])
    guess, step = past[0], past[1]
    guess_middle(tables)
    for done in range(MOST_ROUNDS):
        for row in range(DEPTH, 0, -1):
            guess[row, :], step[row, :] = guess[row - 1], step[row - 1]
        for k in range(column.shape[0]):
            guess[0, k] = column[k, tree.RATE]
        change, rate = refine_middle(tables, bodies, joints, setting, h, gyroscopic, breaks)
        if change <= ROUND_OFF * rate:
            return True
        if not math.isfinite(change):
            return False
        for k in range(column.shape[0]):
            step[0, k] = column[k, tree.RATE] - guess[0, k]
        mixed(guess, step, past[2], past[3], min(done, DEPTH) + 1, answer)
        for k in range(column.shape[0]):
            column[k, tree.RATE] = answer[k]
    return False


@kernel
def find_middle(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int) -> bool:
    """Write the rates of the middle, whose bases are there already. Returns: whether they were found."""
    stage = tables.stage
    breaks = write_laws(tables, joints, 0.5 * h, SMOOTH)
    for i in range(stage.shape[0]):
        for c in range(7):
            stage[i, c] = tables.coordinate[i, c]
    guess_middle(tables)
    last = math.inf
    for _ in range(PLAIN_ROUNDS):
        change, rate = refine_middle(tables, bodies, joints, setting, h, gyroscopic, breaks)
        if change <= ROUND_OFF * rate:
            return True
        if not change < last:
            break
        last = change
    return mix_rounds(tables, bodies, joints, setting, h, gyroscopic, breaks)


@kernel
def carry_reactions(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int) -> None:
    """Count what joints carry in the middle, for h, by the forces there."""
    go_to_middle(tables, bodies, h)
    free_columns(tables, joints)
    push_columns(tables, joints)
    load_links(tables, bodies, setting, gyroscopic)
    accelerations(tables, True)
    add_reactions(tables, joints, h)


@kernel
def implicit_midpoint(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, ends: bool, reactions: bool
) -> bool:
    """Advance all trees and bases by h.

    Args: ends: whether limits act at the end; reactions: whether to count what joints carry. Returns: whether the equation of
        the step and the laws had an answer.
    """
    column, kept = tables.column, tables.stage_rate
    carry_bases(tables, bodies, 0.5 * h)
    if not find_middle(tables, bodies, joints, setting, h, gyroscopic):
        return False
    for k in range(column.shape[0]):
        kept[k, tree.KEPT_CHANGE] = column[k, tree.RATE] - kept[k, tree.KEPT_RATE]
        kept[k, tree.KEPT_RATE] = column[k, tree.RATE]
        kept[k, tree.KEPT_MOMENTUM] = 2.0 * column[k, tree.MOMENTUM] - kept[k, tree.KEPT_MOMENTUM]
    if reactions:
        carry_reactions(tables, bodies, joints, setting, h, gyroscopic)
    drift_coordinates(tables, h)
    carry_bases(tables, bodies, 0.5 * h)
    if not ends:
        return True
    rates_of_momenta(tables, bodies, joints, setting, gyroscopic)
    if not solve_laws(tables, bodies, joints, setting, h, gyroscopic, STIFF_ALONE):
        return False
    if reactions:
        add_reactions(tables, joints, h)
    change_rates(tables, h)
    begin_column_momenta(tables, bodies, joints, setting, gyroscopic)
    return True
