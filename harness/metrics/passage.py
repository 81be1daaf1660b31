"""Passage: which bodies got through what the truth stops them at, and how deep do those that did not stand in it?

The way along which a body is stopped is the change of its velocity in the truth, from start to end, turned round: for a body
that falls on a plate while it slides along it, that is straight down. A body has passed

* what stands still, if its centre ends beyond the middle of that along the way (beyond the surface of a half space);
* another that comes towards it, if the two centres have changed sides;
* stops that it turns against, if it ends with its middle beyond theirs, by the angle that it has turned.

One that is left deep in what stopped it has not passed. How far it sank is a number of its own, in half widths of the body.
Spheres that are shot at a wall need no truth: they tunnel if their centre ends beyond its middle.
"""

import math
from dataclasses import dataclass

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import proportion
from plumbline.harness.scene import Body, Box, Scene, Sphere, rotation_matrix, width
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
    ways = []
    for place in run.movable:
        lost = np.array(run.bodies[place].v_WB) - truth.v_WB[-1, place]
        speed = float(np.linalg.norm(lost))
        if speed > 0.0:
            ways.append((int(place), lost / speed))
    return truth, ways


def _beyond(run: Run, truth: Trajectory, place: int, ways: list[tuple[int, Floats]]) -> bool:
    """Does a body end beyond what stops it on its way?"""
    scene, actual, body, way = run.scene, run.actual, run.bodies[place], dict(ways)[place]
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
        sunk = float((run.actual.p_WB[-1, k] - truth.p_WB[-1, k]) @ way) / _half_width(run.bodies[k])
        shots.append(_Shot(_beyond(run, truth, k, ways), sunk))
    stops = [] if shots else [body for body in run.bodies if not body.movable and body.collision]
    for place in run.movable if stops else ():
        body = run.bodies[place]
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
    return [
        (way, run.actual.v_WB[-1, place] - truth.v_WB[-1, place]) for place, way in ways if not _beyond(run, truth, place, ways)
    ]


@metric("m/s", empty="no body is stopped")
def lateral_kick(run: Run) -> list[float]:
    """definition: by how much a stopped body's final velocity misses the truth's across the way on which it is stopped"""
    return [float(np.linalg.norm(miss - (miss @ way) * way)) for way, miss in _speeds(run)]


@metric("m/s", empty="no body is stopped")
def rest_speed(run: Run) -> list[float]:
    """definition: by how much a stopped body's final velocity misses the truth's along the way on which it is stopped"""
    return [float(abs(miss @ way)) for way, miss in _speeds(run)]


passage_probability, passage_probability_low, passage_probability_high = proportion(
    "passage_probability", SOURCE, "a centre ends beyond the middle of what should stop it", _count
)


WALL_SOURCE = "share of spheres whose centre ends beyond the middle of the wall"


def _wall(scene: Scene) -> tuple[Body, Box]:
    for body in scene.bodies:
        if not body.movable and isinstance(body.only_shape, Box):
            return body, body.only_shape
    raise NotMeasurable("no wall: a fixed body of one box")


def _ends(run: Run) -> list[tuple[float, float]]:
    """Of each sphere that is shot: how far [m] its centre ends past the wall's middle, and where it is if it touches the face.

    The wall's extent along the shot is that of its box, which lies across the shot.
    """
    wall, box = _wall(run.scene)
    ends = []
    axes = np.array(rotation_matrix(wall.q_WB)).T
    for place, body in enumerate(run.bodies):
        if body.movable and any(body.v_WB) and isinstance(body.only_shape, Sphere):
            way = np.array(body.v_WB) / np.linalg.norm(body.v_WB)
            half = float(sum(abs(way @ axis) * extent for axis, extent in zip(axes, box.half_extents, strict=True)))
            ends.append((float((run.actual.p_WB[-1, place] - np.array(wall.p_WB)) @ way), -half - body.only_shape.radius))
    if not ends:
        raise NotMeasurable("no sphere is shot")
    return ends


def _through_wall(run: Run) -> tuple[int, int]:
    """How many passed, of how many."""
    ends = _ends(run)
    return sum(distance > 0 for distance, _ in ends), len(ends)


@metric("m", empty="no sphere is stopped")
def stop_gap(run: Run) -> list[float]:
    """greatest distance from the wall's face at which a stopped sphere ends; 0 without restitution, more after a rebound"""
    return [max(0.0, face - distance) for distance, face in _ends(run) if distance <= 0]


tunnel_probability, tunnel_probability_low, tunnel_probability_high = proportion(
    "tunnel_probability", WALL_SOURCE, "a centre ends beyond the middle of the wall", _through_wall
)
