"""Passage: which bodies got through what the truth stops them at, and how deep do those that did not stand in it?

The way along which a body is stopped is the change of its velocity in the truth, from start to end, turned round: for a body
that falls on a plate while it slides along it, that is straight down. A body has passed

* what stands still, if its centre ends beyond the middle of that along the way (beyond the surface of a half space);
* another that comes towards it, if the two centres have changed sides;
* stops that it turns against, if it ends with its middle beyond theirs, by the angle that it has turned.

One that is left deep in what stopped it has not passed. How far it sank is a number of its own, in half widths of the body.
"""

import math
from dataclasses import dataclass

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.series import matched
from harness.scene import Body, Scene, width
from harness.statistics.proportion import wilson_interval
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import movable, rotate, rotate_back
from harness.trajectory.touching import reach

SOURCE = "share of bodies whose centre ends beyond the middle of what the truth stops them at"


@dataclass(frozen=True, slots=True)
class _Shot:
    """A body that the truth stops.

    Terms: passed: did it get through? sunk: by how much it ends beyond the truth, in half its width [1].
    """

    passed: bool
    sunk: float


def _half_width(body: Body) -> float:
    """Half of the thinnest of a body's shapes along an axis of its own, m; infinite for a half space."""
    return min((width(placed.shape) for placed in body.collision), default=math.inf) / 2


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


def _beyond(scene: Scene, actual: Trajectory, truth: Trajectory, place: int, ways: list[tuple[int, Floats]]) -> bool:
    """Does a body end beyond what stops it on its way?"""
    body, way = scene.bodies[place], dict(ways)[place]
    coming = [k for k, other in ways if other @ way < 0 and scene.collides(body, scene.bodies[k])]
    if coming:
        met = min(coming, key=lambda k: float(np.linalg.norm(truth.p_WB[-1, k] - truth.p_WB[-1, place])))
        return bool((actual.p_WB[-1, place] - actual.p_WB[-1, met]) @ way > 0)
    still = [other for other in scene.bodies if not other.movable and other.collision and scene.collides(body, other)]
    if not still:
        raise NotMeasurable(f"body '{body.name}' meets nothing that could stop it")
    front = float(truth.p_WB[-1, place] @ way) + _half_width(body)
    stop = min(still, key=lambda other: abs(-reach(other, -way) - front))
    near, far = -reach(stop, -way), reach(stop, way)
    return bool(actual.p_WB[-1, place] @ way > ((near + far) / 2 if math.isfinite(far) else near))


def _shots(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> list[_Shot]:
    """Each body that the truth stops; of a spin, on the way that its stops are off its axis."""
    truth, ways = _stopped_ways(scene, actual, expected)
    shots = []
    for k, way in ways:
        sunk = float((actual.p_WB[-1, k] - truth.p_WB[-1, k]) @ way) / _half_width(scene.bodies[k])
        shots.append(_Shot(_beyond(scene, actual, truth, k, ways), sunk))
    stops = [] if shots else [body for body in scene.bodies if not body.movable and body.collision]
    for place in movable(scene) if stops else ():
        body = scene.bodies[place]
        spin = np.array(body.w_WB)
        if not spin.any() or truth.w_WB[-1, place].any():
            continue
        axis = spin / np.linalg.norm(spin)
        levers = [float(np.linalg.norm(np.cross(axis, np.array(stop.p_WB) - np.array(body.p_WB)))) for stop in stops]
        lever, stop = min(zip(levers, stops, strict=True), key=lambda pair: pair[0])
        turned = _turned(actual, place, axis) - _turned(truth, place, axis)
        # Where the truth leaves it, its middle is off the stop's by both half widths.
        between = math.asin(min(1.0, (_half_width(body) + _half_width(stop)) / lever))
        shots.append(_Shot(turned > between, lever * turned / _half_width(body)))
    if not shots:
        raise NotMeasurable("the truth stops no body")
    return shots


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
    """How many got through, of how many."""
    shots = _shots(scene, actual, expected)
    return sum(shot.passed for shot in shots), len(shots)


def _sink(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    sunk = [shot.sunk for shot in _shots(scene, actual, expected) if not shot.passed]
    if not actual.finite:
        return math.nan
    if not sunk:
        raise NotMeasurable("no body is stopped")
    return max(0.0, *sunk)


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
    errors = []
    for place, way in ways:
        if not _beyond(scene, actual, truth, place, ways):
            errors.append((way, actual.v_WB[-1, place] - truth.v_WB[-1, place]))
    if not errors:
        raise NotMeasurable("no body is stopped")
    return errors


def _kick(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    return float(np.max([np.linalg.norm(miss - (miss @ way) * way) for way, miss in _speeds(scene, actual, expected)]))


def _rest(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    return float(np.max([abs(miss @ way) for way, miss in _speeds(scene, actual, expected)]))


VERDICT = "a centre ends beyond the middle of what should stop it"
PASSAGE_PROBABILITY = Metric(name="passage_probability", unit="1", source=SOURCE, measure=_probability, verdict=VERDICT)
PASSAGE_PROBABILITY_LOW = Metric(
    name="passage_probability_low",
    unit="1",
    source="lower 95 % bound of Wilson (1927) on passage_probability",
    measure=lambda s, a, e: _bounds(s, a, e)[0],
    verdict=VERDICT,
)
PASSAGE_PROBABILITY_HIGH = Metric(
    name="passage_probability_high",
    unit="1",
    source="upper 95 % bound of Wilson (1927) on passage_probability",
    measure=lambda s, a, e: _bounds(s, a, e)[1],
    verdict=VERDICT,
)
SINK_DEPTH = Metric(
    name="sink_depth",
    unit="1",
    source="definition: greatest way by which a stopped body ends beyond where the truth stops it, in half its thinnest width",
    measure=_sink,
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

METRIC = (PASSAGE_PROBABILITY, PASSAGE_PROBABILITY_LOW, PASSAGE_PROBABILITY_HIGH, SINK_DEPTH, LATERAL_KICK, REST_SPEED)
