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
from plumbline.engine.articulated.bounded import SMOOTH, STIFF_ALONE, settle_laws, solve_laws, take_laws, write_laws
from plumbline.engine.articulated.column_momenta import begin_column_momenta, column_momenta, rates_of_momenta
from plumbline.engine.articulated.forces import load_links
from plumbline.engine.articulated.mixing import DEPTH, mix
from plumbline.engine.articulated.motion import move_links
from plumbline.engine.articulated.runge_kutta import ends_with_laws, push_columns
from plumbline.engine.articulated.tables import POSE, Trees
from plumbline.engine.articulated.ties import follow_rates
from plumbline.engine.compile.jit import kernel
from plumbline.engine.memory import arena as at

ROUND_OFF = 1e-11
"""The change of a rate, as a share of the largest one, that ends the rounds: what it leaves is smaller again by a round."""

PLAIN_ROUNDS = 20
"""Some eight are needed where h times the angular velocities is small; where one changes more than the last, none will do."""

MOST_ROUNDS = 100
"""Of those that are mixed; more are needed where the step is far too long."""


@kernel
def go_to_middle(trees: Trees, h: float) -> None:
    """Write pose and velocity of links in the middle; coordinates stay at the start."""
    drift_coordinates(trees, 0.5 * h)
    move_links(trees)
    for i in range(trees.coordinate.shape[0]):
        for c in range(POSE):
            trees.coordinate[i, c] = trees.coordinate[i, POSE + c]


@kernel
def change_middle(trees: Trees, h: float) -> tuple[float, float]:
    """Write rates and momenta that a round gives the middle. Returns: the largest change of a rate, and the largest rate."""
    column, along, kind, joints, change, rate = trees.column, trees.along, trees.kind, trees.joints, 0.0, 0.0
    for i in range(kind.shape[0]):
        # Of what is added to the inertia, the rotor is in the momentum; the rest is a law's force at the new rate.
        j, k = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            column[k, tree.PUSH] -= (column[k, tree.ADDED] - joints.joint[j, at.ARMATURE]) * along[k, tree.CHANGE]
    for t in range(trees.tie.shape[0]):
        follower, pull = trees.follower[t, 0], trees.tie[t, tree.PULLED]
        column[kind[follower, tree.FIRST], tree.PUSH] += pull
        column[kind[kind[follower, tree.LEADER], tree.FIRST], tree.PUSH] -= trees.link[follower, tree.RATIO] * pull
    for k in range(column.shape[0]):
        column[k, tree.MOMENTUM] += 0.5 * h * column[k, tree.PUSH]
        column[k, tree.RATE] += 0.5 * h * along[k, tree.CHANGE]
        change, rate = max(change, abs(0.5 * h * along[k, tree.CHANGE])), max(rate, abs(column[k, tree.RATE]))
    follow_rates(trees)
    return change, rate


@kernel
def refine_middle(trees: Trees, h: float, breaks: int) -> tuple[float, float]:
    """One round: into every column goes the force over h/2 that brings its momentum to that of the middle, and its law.

    Args: breaks: as `write_laws` returns. Returns: as `change_middle`; inf where the laws have no answer.
    """
    column = trees.column
    go_to_middle(trees, h)
    column_momenta(trees)
    for k in range(column.shape[0]):
        column[k, tree.BESIDE] += (column[k, tree.KEPT_MOMENTUM] - column[k, tree.MOMENTUM]) / (0.5 * h)
        column[k, tree.ADDED], column[k, tree.PUSH] = 0.0, column[k, tree.BESIDE]
    take_laws(trees, 0.5 * h)
    if not settle_laws(trees, 0.5 * h, SMOOTH, breaks):
        return math.inf, 0.0
    return change_middle(trees, h)


@kernel
def guess_middle(trees: Trees) -> None:
    """Write the rates from which rounds begin: those of the start, changed as they were in the last step."""
    column = trees.column
    for k in range(column.shape[0]):
        column[k, tree.RATE] = column[k, tree.KEPT_RATE] + column[k, tree.KEPT_CHANGE]


@kernel
def mix_rounds(trees: Trees, h: float, breaks: int) -> bool:
    """Write the rates of the middle by rounds that are mixed. Returns: whether they were found."""
    column = trees.column
    past = np.empty((4, DEPTH + 1, column.shape[0]))
    guess, step, dx, df = past[0], past[1], past[2], past[3]
    guess_middle(trees)
    for done in range(MOST_ROUNDS):
        for row in range(DEPTH, 0, -1):
            guess[row, :], step[row, :] = guess[row - 1], step[row - 1]
        for k in range(column.shape[0]):
            guess[0, k] = column[k, tree.RATE]
        change, rate = refine_middle(trees, h, breaks)
        if change <= ROUND_OFF * rate or not math.isfinite(change):
            return math.isfinite(change)
        for k in range(column.shape[0]):
            step[0, k] = column[k, tree.RATE] - guess[0, k]
        mix(guess, step, dx, df, min(done, DEPTH) + 1)
        for k in range(column.shape[0]):
            column[k, tree.RATE] = dx[DEPTH, k]
    return False


@kernel
def find_middle(trees: Trees, h: float) -> bool:
    """Write the rates of the middle, whose bases are there already. Returns: whether they were found."""
    coordinate, last = trees.coordinate, math.inf
    breaks = write_laws(trees, 0.5 * h, SMOOTH)
    for i in range(coordinate.shape[0]):
        for c in range(POSE):
            coordinate[i, POSE + c] = coordinate[i, c]
    guess_middle(trees)
    for _ in range(PLAIN_ROUNDS):
        change, rate = refine_middle(trees, h, breaks)
        if change <= ROUND_OFF * rate:
            return True
        if not change < last:
            break
        last = change
    return mix_rounds(trees, h, breaks)


@kernel
def carry_reactions(trees: Trees, h: float) -> None:
    """Count what joints carry in the middle, for h, by the forces there."""
    go_to_middle(trees, h)
    free_columns(trees)
    push_columns(trees)
    load_links(trees)
    accelerations(trees, True)
    add_reactions(trees, h)


@kernel
def implicit_midpoint(trees: Trees, h: float, reactions: bool) -> bool:
    """Advance all trees and bases by h.

    Args: reactions: whether to count what joints carry. Returns: whether the equation of the step and the laws had an answer.
    """
    column = trees.column
    carry_bases(trees, 0.5 * h)
    if not find_middle(trees, h):
        return False
    for k in range(column.shape[0]):
        column[k, tree.KEPT_CHANGE] = column[k, tree.RATE] - column[k, tree.KEPT_RATE]
        column[k, tree.KEPT_RATE] = column[k, tree.RATE]
        column[k, tree.KEPT_MOMENTUM] = 2.0 * column[k, tree.MOMENTUM] - column[k, tree.KEPT_MOMENTUM]
    if reactions:
        carry_reactions(trees, h)
    drift_coordinates(trees, h)
    carry_bases(trees, 0.5 * h)
    if not ends_with_laws(trees):
        return True
    rates_of_momenta(trees)
    if not solve_laws(trees, h, STIFF_ALONE):
        return False
    if reactions:
        add_reactions(trees, h)
    change_rates(trees, h)
    begin_column_momenta(trees)
    return True
