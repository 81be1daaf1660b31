"""Stacks: does the tower keep its height, stay upright and come to rest?"""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import rotation_matrix
from plumbline.harness.trajectory import Floats, Trajectory


def _tops(run: Run) -> tuple[list[int], float]:
    """The places of the movable bodies that start highest, of which there may be several alike, and their height [m]."""
    heights = {place: run.bodies[place].p_WB[2] for place in run.movable.tolist()}
    if not heights:
        raise NotMeasurable("no body can move")
    top = max(heights.values())
    return [place for place, height in heights.items() if math.isclose(height, top, rel_tol=1e-9)], top


@metric("1")
def stack_height_error(run: Run) -> float:
    """impenetrability: greatest change of the height of the top bodies over the window, relative to its start over z = 0"""
    tops, start = _tops(run)
    return float(np.max(np.abs(run.actual.p_WB[:, tops, 2] - start))) / start


@metric("1", better="higher", verdict="one of the bodies that start highest sinks: below half of its height it has collapsed")
def standing_height(run: Run) -> float:
    """least height of the top bodies over the window, relative to its start over z = 0; below 1/2 it has collapsed"""
    tops, start = _tops(run)
    return float(np.min(run.actual.p_WB[:, tops, 2])) / start


@metric("m", empty="no body can move")
def lean(run: Run) -> Floats:
    """greatest horizontal way of any movable body from its start"""
    starts = np.array([body.p_WB[:2] for body in run.bodies])
    ways: Floats = np.linalg.norm((run.actual.p_WB[..., :2] - starts)[:, run.movable], axis=2)
    return ways


def _turning(actual: Trajectory, place: int, inertia: Floats) -> Floats:
    """Rotational kinetic energy (t,) J."""
    energies = np.empty(len(actual))
    for k, (q, w) in enumerate(zip(actual.q_WB[:, place], actual.w_WB[:, place], strict=True)):
        w_B = np.array(rotation_matrix((q[0], q[1], q[2], q[3]))).T @ w
        energies[k] = 0.5 * w_B @ inertia @ w_B
    return energies


@metric("J/kg")
def residual_kinetic_energy(run: Run) -> float:
    """mean kinetic energy of all movable bodies over the window, divided by their mass"""
    _tops(run)
    total, mass = np.zeros(len(run.actual)), 0.0
    for place in run.movable.tolist():
        body = run.bodies[place]
        total += 0.5 * body.mass * np.sum(run.actual.v_WB[:, place] ** 2, axis=1)
        total += _turning(run.actual, place, np.array(body.inertia))
        mass += body.mass
    return float(total.mean()) / mass
