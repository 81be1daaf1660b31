"""Isotropy of friction: does the direction of a push change where the body stops?"""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.trajectory import Floats

SOURCE = "Coulomb's cone is round: |f| <= mu N in every direction of the plane"


def _ways(run: Run) -> tuple[Floats, Floats]:
    """Horizontal displacements (n, 2) m at the end and the directions (n, 2) of the pushes."""
    pushed = [i for i, body in enumerate(run.scene.bodies) if body.movable and math.hypot(*body.v_WB[:2]) > 0]
    if len(pushed) < 2:
        raise NotMeasurable(f"{len(pushed)} bodies are pushed, expected at least two")
    starts = np.array([run.scene.bodies[i].p_WB[:2] for i in pushed])
    pushes = np.array([run.scene.bodies[i].v_WB[:2] for i in pushed])
    ways: Floats = run.actual.p_WB[-1, pushed, :2] - starts
    return ways, pushes / np.linalg.norm(pushes, axis=1, keepdims=True)


@metric("1", SOURCE)
def polar_spread(run: Run) -> float:
    """(greatest - least) / mean stopping distance over all azimuths"""
    ways, _ = _ways(run)
    distance = np.linalg.norm(ways, axis=1)
    return float((distance.max() - distance.min()) / distance.mean()) if distance.mean() > 0 else math.nan


@metric("rad", SOURCE)
def heading_error(run: Run) -> float:
    """greatest angle between push and displacement"""
    ways, pushes = _ways(run)
    if not np.linalg.norm(ways, axis=1).all():
        return math.nan
    across = ways[:, 0] * pushes[:, 1] - ways[:, 1] * pushes[:, 0]
    return float(np.max(np.abs(np.arctan2(across, np.sum(ways * pushes, axis=1)))))
