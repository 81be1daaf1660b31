"""Isotropy of friction: does the direction of a push change where the body stops?"""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory

SOURCE = "Coulomb's cone is round: |f| <= mu N in every direction of the plane"


def _ways(scene: Scene, actual: Trajectory) -> tuple[Floats, Floats]:
    """Horizontal displacements (n, 2) m at the end and the directions (n, 2) of the pushes."""
    pushed = [i for i, body in enumerate(scene.bodies) if body.movable and math.hypot(*body.v_WB[:2]) > 0]
    if len(pushed) < 2:
        raise NotMeasurable(f"{len(pushed)} bodies are pushed, expected at least two")
    starts = np.array([scene.bodies[i].p_WB[:2] for i in pushed])
    pushes = np.array([scene.bodies[i].v_WB[:2] for i in pushed])
    ways: Floats = actual.p_WB[-1, pushed, :2] - starts
    return ways, pushes / np.linalg.norm(pushes, axis=1, keepdims=True)


def _spread(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    ways, _ = _ways(scene, actual)
    if not actual.finite:
        return math.nan
    distance = np.linalg.norm(ways, axis=1)
    return float((distance.max() - distance.min()) / distance.mean()) if distance.mean() > 0 else math.nan


def _turn(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    ways, pushes = _ways(scene, actual)
    if not actual.finite or not np.linalg.norm(ways, axis=1).all():
        return math.nan
    across = ways[:, 0] * pushes[:, 1] - ways[:, 1] * pushes[:, 0]
    return float(np.max(np.abs(np.arctan2(across, np.sum(ways * pushes, axis=1)))))


POLAR_SPREAD = Metric(
    name="polar_spread",
    unit="1",
    source=f"{SOURCE}; (greatest - least) / mean stopping distance over all azimuths",
    measure=_spread,
)
HEADING_ERROR = Metric(
    name="heading_error",
    unit="rad",
    source=f"{SOURCE}; greatest angle between push and displacement",
    measure=_turn,
)

METRIC = (POLAR_SPREAD, HEADING_ERROR)
