"""Bodies that slide to a stop: how far, how long, and how level.

Creep: the speed of bodies that friction should hold.

Foot slip: how far the points that bear a machine wander over the ground.

Isotropy of friction: does the direction of a push change where the body stops?
"""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate, rotate_back

SOURCE = "Coulomb friction: d = v0^2/(2 mu g), t = v0/(mu g)"
LEVEL = 0.1
"""The share of its first speed at which a body counts as stopping: high enough that the end of a linear ramp is read between
two samples, where engines regularise friction near zero speed."""


def _movable(scene: Scene) -> list[int]:
    return [place for place, body in enumerate(scene.bodies) if body.movable]


def _truth(expected: Trajectory | None) -> Trajectory:
    if expected is None or len(expected) == 0:
        raise NotMeasurable("no truth to compare with")
    return expected


@metric("1", SOURCE, empty="the truth moves no body")
def stop_distance_error(run: Run) -> list[float]:
    """horizontal way at the end against the truth's, relative, worst body"""
    truth = _truth(run.expected)
    errors = []
    for i in _movable(run.scene):
        start = np.array(run.scene.bodies[i].p_WB)
        true_way = float(np.linalg.norm((truth.p_WB[-1, i] - start)[:2]))
        way = float(np.linalg.norm((run.actual.p_WB[-1, i] - start)[:2]))
        if true_way > 0:
            errors.append(abs(way - true_way) / true_way)
    return errors


def _stopping(time: Floats, speed: Floats) -> float:
    """When a speed (t,) first falls to LEVEL of its first value [s]; infinite where it never does."""
    level = LEVEL * speed[0]
    below = np.flatnonzero(speed <= level)
    if len(below) == 0:
        return math.inf
    k = int(below[0])
    share = (speed[k - 1] - level) / (speed[k - 1] - speed[k])
    return float(time[k - 1] + share * (time[k] - time[k - 1]))


@metric("1", SOURCE, empty="the truth stops no body within the run")
def stop_time_error(run: Run) -> list[float]:
    """time to fall to a tenth of the first speed, relative to the truth's, worst body"""
    truth = _truth(run.expected)
    errors = []
    for i in _movable(run.scene):
        true_speed = np.linalg.norm(truth.v_WB[:, i, :2], axis=1)
        if true_speed[0] > 0 and np.isfinite(stop := _stopping(truth.time, true_speed)):
            errors.append(abs(_stopping(run.actual.time, np.linalg.norm(run.actual.v_WB[:, i, :2], axis=1)) - stop) / stop)
    return errors


@metric("m")
def centre_rise(run: Run) -> float:
    """unilateral contact on a level plane: the greatest rise of a centre of mass over its start, worst body"""
    starts = np.array([run.scene.bodies[i].p_WB[2] for i in _movable(run.scene)])
    return float(np.max(run.actual.p_WB[:, _movable(run.scene), 2] - starts))


@metric("m/s")
def creep_speed(run: Run) -> float:
    """static friction holds: mean speed over the window of the bodies that the truth keeps in place, worst body"""
    if run.expected is None:
        raise NotMeasurable("no truth to say which bodies stay")
    if len(run.actual) < 2:
        raise NotMeasurable("fewer than two samples")
    still = [
        i for i, b in enumerate(run.scene.bodies) if b.movable and not np.any(run.expected.p_WB[:, i] - run.expected.p_WB[0, i])
    ]
    if not still:
        raise NotMeasurable("the truth holds no body")
    way = np.linalg.norm(run.actual.p_WB[-1, still] - run.actual.p_WB[0, still], axis=1)
    return float(way.max() / (run.actual.time[-1] - run.actual.time[0]))


def _carried(actual: Trajectory, place: int, point_W: Floats) -> Floats:
    """Where a point of a body that is at point_W (3,) in the first sample is at each time, (t, 3) m."""
    arm_B = rotate_back(actual.q_WB[:1, place], (point_W - actual.p_WB[0, place])[None])
    carried: Floats = actual.p_WB[:, place] + rotate(actual.q_WB[:, place], np.broadcast_to(arm_B, (len(actual), 3)))
    return carried


@metric("m")
def foot_slip(run: Run) -> float:
    """static friction holds: greatest way along the ground of the material points that bear on it when the window begins"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    movable = [body.movable for body in run.scene.bodies]
    ways = []
    first = run.actual.contacts[0]
    for a, b, point, normal, force in zip(
        first.body_A, first.body_B, first.point_W, first.normal_W, first.force_W, strict=True
    ):
        # A near miss that an engine lists bears nothing.
        if movable[a] != movable[b] and force.any():
            way = _carried(run.actual, a if movable[a] else b, point) - point
            ways.append(np.linalg.norm(way - np.outer(way @ normal, normal), axis=1).max())
    # A machine that hangs in the air has no foot on the ground that could hold.
    return float(np.max(ways)) if ways else math.inf


ISOTROPY_SOURCE = "Coulomb's cone is round: |f| <= mu N in every direction of the plane"


def _ways(run: Run) -> tuple[Floats, Floats]:
    """Horizontal displacements (n, 2) m at the end and the directions (n, 2) of the pushes."""
    pushed = [i for i, body in enumerate(run.scene.bodies) if body.movable and math.hypot(*body.v_WB[:2]) > 0]
    if len(pushed) < 2:
        raise NotMeasurable(f"{len(pushed)} bodies are pushed, expected at least two")
    starts = np.array([run.scene.bodies[i].p_WB[:2] for i in pushed])
    pushes = np.array([run.scene.bodies[i].v_WB[:2] for i in pushed])
    ways: Floats = run.actual.p_WB[-1, pushed, :2] - starts
    return ways, pushes / np.linalg.norm(pushes, axis=1, keepdims=True)


@metric("1", ISOTROPY_SOURCE)
def polar_spread(run: Run) -> float:
    """(greatest - least) / mean stopping distance over all azimuths"""
    ways, _ = _ways(run)
    distance = np.linalg.norm(ways, axis=1)
    return float((distance.max() - distance.min()) / distance.mean()) if distance.mean() > 0 else math.nan


@metric("rad", ISOTROPY_SOURCE)
def heading_error(run: Run) -> float:
    """greatest angle between push and displacement"""
    ways, pushes = _ways(run)
    if not np.linalg.norm(ways, axis=1).all():
        return math.nan
    across = ways[:, 0] * pushes[:, 1] - ways[:, 1] * pushes[:, 0]
    return float(np.max(np.abs(np.arctan2(across, np.sum(ways * pushes, axis=1)))))
