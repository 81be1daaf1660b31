"""Stacks: does the tower keep its height, stay upright and come to rest?"""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene, rotation_matrix
from harness.trajectory import Floats, Trajectory


def _tops(scene: Scene, actual: Trajectory) -> tuple[list[int], float]:
    """The places of the movable bodies that start highest, of which there may be several alike, and their height [m]."""
    heights = {place: body.p_WB[2] for place, body in enumerate(scene.bodies) if body.movable}
    if not heights or len(actual) == 0:
        raise NotMeasurable("no movable body or no samples")
    top = max(heights.values())
    return [place for place, height in heights.items() if math.isclose(height, top, rel_tol=1e-9)], top


def _sag(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    tops, start = _tops(scene, actual)
    if not actual.finite:
        return math.nan
    return float(np.max(np.abs(actual.p_WB[:, tops, 2] - start))) / start


def _standing(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    tops, start = _tops(scene, actual)
    if not actual.finite:
        return math.nan
    return float(np.min(actual.p_WB[:, tops, 2])) / start


def _lean(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    _tops(scene, actual)
    if not actual.finite:
        return math.nan
    movable = [place for place, body in enumerate(scene.bodies) if body.movable]
    starts = np.array([scene.bodies[place].p_WB[:2] for place in movable])
    return float(np.max(np.linalg.norm(actual.p_WB[:, movable, :2] - starts, axis=2)))


def _turning(actual: Trajectory, place: int, inertia: Floats) -> Floats:
    """Rotational kinetic energy (t,) J."""
    energies = np.empty(len(actual))
    for k, (q, w) in enumerate(zip(actual.q_WB[:, place], actual.w_WB[:, place], strict=True)):
        w_B = np.array(rotation_matrix((q[0], q[1], q[2], q[3]))).T @ w
        energies[k] = 0.5 * w_B @ inertia @ w_B
    return energies


def _kinetic(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    _tops(scene, actual)
    if not actual.finite:
        return math.nan
    total, mass = np.zeros(len(actual)), 0.0
    for place, body in enumerate(scene.bodies):
        if body.movable:
            total += 0.5 * body.mass * np.sum(actual.v_WB[:, place] ** 2, axis=1)
            total += _turning(actual, place, np.array(body.inertia))
            mass += body.mass
    return float(total.mean()) / mass


STACK_HEIGHT_ERROR = Metric(
    name="stack_height_error",
    unit="1",
    source="impenetrability: greatest change of the height of the top bodies over the window, relative to its start over z = 0",
    measure=_sag,
)
STANDING_HEIGHT = Metric(
    name="standing_height",
    unit="1",
    source="least height of the top bodies over the window, relative to its start over z = 0; below 1/2 it has collapsed",
    measure=_standing,
    better="higher",
    verdict="one of the bodies that start highest sinks: below half of its height it has collapsed",
)
LEAN = Metric(name="lean", unit="m", source="greatest horizontal way of any movable body from its start", measure=_lean)
RESIDUAL_KINETIC_ENERGY = Metric(
    name="residual_kinetic_energy",
    unit="J/kg",
    source="mean kinetic energy of all movable bodies over the window, divided by their mass",
    measure=_kinetic,
)

METRIC = (STACK_HEIGHT_ERROR, STANDING_HEIGHT, LEAN, RESIDUAL_KINETIC_ENERGY)
