"""Tunnelling: which of the spheres shot at a wall got through it, their centre beyond its middle?"""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Body, Box, Scene, Sphere, rotate
from harness.statistics.proportion import wilson_interval
from harness.trajectory import Trajectory

SOURCE = "share of spheres whose centre ends beyond the middle of the wall"


def _wall(scene: Scene) -> tuple[Body, Box]:
    for body in scene.bodies:
        if not body.movable and len(body.collision) == 1 and isinstance(body.collision[0].shape, Box):
            return body, body.collision[0].shape
    raise NotMeasurable("no wall: a fixed body of one box")


def _ends(scene: Scene, actual: Trajectory) -> list[tuple[float, float]]:
    """Of each sphere that is shot: how far [m] its centre ends past the wall's middle, and where it is if it touches the face.

    The wall's extent along the shot is that of its box, which lies across the shot.
    """
    wall, box = _wall(scene)
    ends = []
    if len(actual) == 0:
        raise NotMeasurable("no samples")
    axes = [np.array(rotate(wall.q_WB, axis)) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    for place, body in enumerate(scene.bodies):
        shapes = [placed.shape for placed in body.collision]
        if body.movable and any(body.v_WB) and len(shapes) == 1 and isinstance(shapes[0], Sphere):
            way = np.array(body.v_WB) / np.linalg.norm(body.v_WB)
            half = float(sum(abs(way @ axis) * extent for axis, extent in zip(axes, box.half_extents, strict=True)))
            ends.append((float((actual.p_WB[-1, place] - np.array(wall.p_WB)) @ way), -half - shapes[0].radius))
    if not ends:
        raise NotMeasurable("no sphere is shot")
    return ends


def _count(scene: Scene, actual: Trajectory) -> tuple[int, int]:
    """How many passed, of how many."""
    ends = _ends(scene, actual)
    return sum(distance > 0 for distance, _ in ends), len(ends)


def _probability(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    passed, shot = _count(scene, actual)
    return passed / shot if actual.finite else math.nan


def _low(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    interval = wilson_interval(*_count(scene, actual))
    return interval[0] if actual.finite else math.nan


def _high(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    interval = wilson_interval(*_count(scene, actual))
    return interval[1] if actual.finite else math.nan


def _stop_gap(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    ends = _ends(scene, actual)
    if not actual.finite:
        return math.nan
    stopped = [max(0.0, face - distance) for distance, face in ends if distance <= 0]
    if not stopped:
        raise NotMeasurable("no sphere is stopped")
    return max(stopped)


VERDICT = "a centre ends beyond the middle of the wall"
TUNNEL_PROBABILITY = Metric(name="tunnel_probability", unit="1", source=SOURCE, measure=_probability, verdict=VERDICT)
TUNNEL_PROBABILITY_LOW = Metric(
    name="tunnel_probability_low",
    unit="1",
    source="lower 95 % bound of Wilson (1927) on tunnel_probability",
    measure=_low,
    verdict=VERDICT,
)
TUNNEL_PROBABILITY_HIGH = Metric(
    name="tunnel_probability_high",
    unit="1",
    source="upper 95 % bound of Wilson (1927) on tunnel_probability",
    measure=_high,
    verdict=VERDICT,
)
STOP_GAP = Metric(
    name="stop_gap",
    unit="m",
    source="greatest distance from the wall's face at which a stopped sphere ends; 0 without restitution, more after a rebound",
    measure=_stop_gap,
)

METRIC = (TUNNEL_PROBABILITY, TUNNEL_PROBABILITY_LOW, TUNNEL_PROBABILITY_HIGH, STOP_GAP)
