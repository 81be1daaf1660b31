"""Passage: which bodies went on where the truth stops them?

The way along which a body is stopped is the change of its velocity in the truth, from start to end, turned round: for a body
that falls on a plate while it slides along it, that is straight down. A body that spins about an axis against stops is judged
by its angle. It is stopped unless it ends beyond the truth by more than half of the thinnest body, so that one which is
left embedded counts as not stopped. Two bodies that may both move share that depth.
"""

import math

import numpy as np

from harness.kinematics import movable, rotate, rotate_back
from harness.metric import Metric, NotMeasurable
from harness.proportion import wilson_interval
from harness.reduction import matched
from harness.scene import Body, Scene, width
from harness.trajectory import Floats, Trajectory

__all__ = [
    "LATERAL_KICK",
    "METRIC",
    "PASSAGE_PROBABILITY",
    "PASSAGE_PROBABILITY_HIGH",
    "PASSAGE_PROBABILITY_LOW",
    "REST_SPEED",
]

SOURCE = "share of bodies that end beyond where the truth stops them by more than half of the thinnest body"


def _thickness(body: Body) -> float:
    """The thinnest of a body's shapes along an axis of its own, m; infinite for a half space."""
    return min((width(placed.shape) for placed in body.collision), default=math.inf)


def _allowance(scene: Scene) -> float:
    """How far beyond the truth a stopped body may end, m."""
    solid = [body for body in scene.bodies if body.collision]
    if not solid:
        raise NotMeasurable("no body can be stopped: none has a shape")
    share = 0.5 if all(body.movable for body in solid) else 1.0
    return share * min(_thickness(body) for body in solid) / 2


def _stopped_ways(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> tuple[Trajectory, list[tuple[int, Floats]]]:
    """The truth, and of each body that it stops the place and the unit way (3,) along which it does."""
    truth = matched(actual, expected)
    if len(actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    ways = []
    for place in movable(scene):
        lost = np.array(scene.bodies[place].v_WB) - truth.v_WB[-1, place]
        speed = float(np.linalg.norm(lost))
        if speed > 0.0:
            ways.append((int(place), lost / speed))
    return truth, ways


def _overshoot(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> Floats:
    """How far [m] each body that the truth stops ends beyond it, (n,); of a spin, the way of the stops about the axis."""
    truth, ways = _stopped_ways(scene, actual, expected)
    if ways:
        return np.array([float((actual.p_WB[-1, k] - truth.p_WB[-1, k]) @ way) for k, way in ways])
    stops = [np.array(body.p_WB) for body in scene.bodies if not body.movable and body.collision]
    beyond = []
    for place in movable(scene):
        spin = np.array(scene.bodies[place].w_WB)
        if not spin.any() or truth.w_WB[-1, place].any() or not stops:
            continue
        axis = spin / np.linalg.norm(spin)
        lever = min(float(np.linalg.norm(np.cross(axis, stop - np.array(scene.bodies[place].p_WB)))) for stop in stops)
        beyond.append(lever * (_turned(actual, place, axis) - _turned(truth, place, axis)))
    if not beyond:
        raise NotMeasurable("the truth stops no body")
    return np.array(beyond)


def _turned(trajectory: Trajectory, place: int, axis_W: Floats) -> float:
    """By how much [rad] a body turned about an axis in W from the first sample to the last; less than half a turn a sample."""
    q_WB = trajectory.q_WB[:, place]
    across = np.cross(axis_W, np.eye(3)[int(np.argmin(np.abs(axis_W)))])
    across /= np.linalg.norm(across)
    third = np.cross(axis_W, across)
    seen = rotate(q_WB, np.broadcast_to(rotate_back(q_WB[0], across), (len(q_WB), 3)))
    angle = np.unwrap(np.arctan2(seen @ third, seen @ across))
    return float(angle[-1] - angle[0])


def _count(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> tuple[int, int]:
    """How many went on, of how many."""
    beyond = _overshoot(scene, actual, expected)
    return int(np.sum(beyond > _allowance(scene))), len(beyond)


def _probability(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    passed, shot = _count(scene, actual, expected)
    return passed / shot if actual.finite else float("nan")


def _bounds(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> tuple[float, float]:
    bounds = wilson_interval(*_count(scene, actual, expected))
    return bounds if actual.finite else (float("nan"), float("nan"))


def _speeds(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> list[tuple[Floats, Floats]]:
    """Of each body that was stopped: the way (3,), and by how much its final velocity misses the truth's (3,) m/s."""
    truth, ways = _stopped_ways(scene, actual, expected)
    if not actual.finite:
        return [(np.full(3, np.nan), np.full(3, np.nan))]
    allowed = _allowance(scene)
    found = []
    for place, way in ways:
        if float((actual.p_WB[-1, place] - truth.p_WB[-1, place]) @ way) <= allowed:
            found.append((way, actual.v_WB[-1, place] - truth.v_WB[-1, place]))
    if not found:
        raise NotMeasurable("no body is stopped")
    return found


def _kick(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    return float(np.max([np.linalg.norm(miss - (miss @ way) * way) for way, miss in _speeds(scene, actual, expected)]))


def _rest(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    return float(np.max([abs(miss @ way) for way, miss in _speeds(scene, actual, expected)]))


PASSAGE_PROBABILITY = Metric(name="passage_probability", unit="1", source=SOURCE, measure=_probability)
PASSAGE_PROBABILITY_LOW = Metric(
    name="passage_probability_low",
    unit="1",
    source="lower 95 % bound of Wilson (1927) on passage_probability",
    measure=lambda s, a, e: _bounds(s, a, e)[0],
)
PASSAGE_PROBABILITY_HIGH = Metric(
    name="passage_probability_high",
    unit="1",
    source="upper 95 % bound of Wilson (1927) on passage_probability",
    measure=lambda s, a, e: _bounds(s, a, e)[1],
)
LATERAL_KICK = Metric(
    name="lateral_kick",
    unit="m/s",
    source="definition: by how much a stopped body's final velocity misses the truth's across the way on which it is stopped",
    measure=_kick,
)
REST_SPEED = Metric(
    name="rest_speed",
    unit="m/s",
    source="definition: by how much a stopped body's final velocity misses the truth's along the way on which it is stopped",
    measure=_rest,
)

METRIC = (PASSAGE_PROBABILITY, PASSAGE_PROBABILITY_LOW, PASSAGE_PROBABILITY_HIGH, LATERAL_KICK, REST_SPEED)
