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

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import proportion
from plumbline.harness.scene import Body, Scene, width
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate, rotate_back
from plumbline.harness.trajectory.touching import reach

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


def _stopped_ways(run: Run) -> tuple[Trajectory, list[tuple[int, Floats]]]:
    """The truth, and of each body that it stops the place and the unit way (3,) along which it does."""
    truth = run.truth
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    ways = []
    for place in run.movable:
        lost = np.array(run.scene.bodies[place].v_WB) - truth.v_WB[-1, place]
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


def _shots(run: Run) -> list[_Shot]:
    """Each body that the truth stops; of a spin, on the way that its stops are off its axis."""
    truth, ways = _stopped_ways(run)
    shots = []
    for k, way in ways:
        sunk = float((run.actual.p_WB[-1, k] - truth.p_WB[-1, k]) @ way) / _half_width(run.scene.bodies[k])
        shots.append(_Shot(_beyond(run.scene, run.actual, truth, k, ways), sunk))
    stops = [] if shots else [body for body in run.scene.bodies if not body.movable and body.collision]
    for place in run.movable if stops else ():
        body = run.scene.bodies[place]
        spin = np.array(body.w_WB)
        if not spin.any() or truth.w_WB[-1, place].any():
            continue
        axis = spin / np.linalg.norm(spin)
        levers = [float(np.linalg.norm(np.cross(axis, np.array(stop.p_WB) - np.array(body.p_WB)))) for stop in stops]
        lever, stop = min(zip(levers, stops, strict=True), key=lambda pair: pair[0])
        turned = _turned(run.actual, place, axis) - _turned(truth, place, axis)
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


def _count(run: Run) -> tuple[int, int]:
    """How many got through, of how many."""
    shots = _shots(run)
    return sum(shot.passed for shot in shots), len(shots)


@metric("1", empty="no body is stopped")
def sink_depth(run: Run) -> list[float]:
    """definition: greatest way by which a stopped body ends beyond where the truth stops it, in half its thinnest width"""
    return [max(0.0, shot.sunk) for shot in _shots(run) if not shot.passed]


def _speeds(run: Run) -> list[tuple[Floats, Floats]]:
    """Of each body that was stopped: the way (3,), and by how much its final velocity misses the truth's (3,) m/s."""
    truth, ways = _stopped_ways(run)
    errors = []
    for place, way in ways:
        if not _beyond(run.scene, run.actual, truth, place, ways):
            errors.append((way, run.actual.v_WB[-1, place] - truth.v_WB[-1, place]))
    if not errors:
        raise NotMeasurable("no body is stopped")
    return errors


@metric("m/s")
def lateral_kick(run: Run) -> float:
    """definition: by how much a stopped body's final velocity misses the truth's across the way on which it is stopped"""
    return float(np.max([np.linalg.norm(miss - (miss @ way) * way) for way, miss in _speeds(run)]))


@metric("m/s")
def rest_speed(run: Run) -> float:
    """definition: by how much a stopped body's final velocity misses the truth's along the way on which it is stopped"""
    return float(np.max([abs(miss @ way) for way, miss in _speeds(run)]))


passage_probability, passage_probability_low, passage_probability_high = proportion(
    "passage_probability", SOURCE, "a centre ends beyond the middle of what should stop it", _count
)
