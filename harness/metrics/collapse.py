"""Collapse: when a scene that should stand first breaks, by any of the signs of a broken run that a trajectory can show.

The signs, each with its name:

    energy        kinetic energy above a thousand times what is available: that of the start, with that of its springs, and the
                  fall of every body to the lowest place of the scene, or as far as its joints may let it
    penetration   two bodies in one another by more than half of the thinner movable one of the two, from poses and shapes; by
                  the engine's own points of contact where such shapes' depth is not known exactly
    height        a body of those that start highest below half of its height over z = 0
    drive         a drive more than half a radian off its target

A state that is not finite is no time at all but NaN, as for every metric.
"""

import math
from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Body, Drive, Revolute, Scene, width
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.depths import pair_depths
from plumbline.harness.trajectory.kinematics import joint_coordinate, kinetic_energy, movable

SIGNS = ("energy", "penetration", "height", "drive")
ENERGY_FACTOR = 1e3
OFF_TARGET = 0.5
"""Of a drive [rad]."""


def _reach(scene: Scene) -> float:
    """How far joints may let a body fall [m]: twice the extent of their anchors and of the centres of their bodies."""
    names = {name for joint in scene.joints for name in (joint.parent, joint.child)}
    points = [body.p_WB for body in scene.bodies if body.name in names]
    points += [joint.anchor_W for joint in scene.joints if hasattr(joint, "anchor_W")]
    spread = np.array(points).reshape(-1, 3)
    return 2 * float(np.linalg.norm(np.ptp(spread, axis=0))) if len(spread) else 0.0


def _sprung(scene: Scene, start: Trajectory) -> float:
    """What the springs of a scene hold at its start [J]."""
    held = 0.0
    for joint in scene.joints:
        spring = getattr(joint, "spring", None)
        if spring is not None:
            held += 0.5 * spring.stiffness * float(joint_coordinate(scene, joint, start)[0] - spring.rest) ** 2
    return held


def _thickness(body: Body) -> float:
    """Least width [m] of a body that can move; infinite for another, which holds however deep one stands in it."""
    return min((width(placed.shape) for placed in body.collision), default=math.inf) if body.movable else math.inf


def _sunk(scene: Scene, actual: Trajectory) -> NDArray[np.bool_]:
    """Where two bodies stand in one another by more than half of the thinner, (t,)."""
    thin = np.array([_thickness(body) for body in scene.bodies])
    sunk = np.zeros(len(actual), dtype=np.bool_)
    for a, b, deep in pair_depths(scene, actual):
        allowed = min(thin[a], thin[b]) / 2
        sunk |= _listed(actual, {a, b}, allowed) if deep is None else deep > allowed
    return sunk


def _listed(actual: Trajectory, pair: set[int], allowed: float) -> NDArray[np.bool_]:
    """Where the engine lists a point between two bodies that is deeper than allowed [m], or no number, (t,)."""
    if actual.contacts is None:
        return np.zeros(len(actual), dtype=np.bool_)
    own = [c.gap[np.isin(c.body_A, list(pair)) & np.isin(c.body_B, list(pair))] for c in actual.contacts]
    return np.array([bool(np.any(~(gap >= -allowed))) for gap in own])


def _signs(scene: Scene, actual: Trajectory) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Each sign's name and where it shows, (t,) of bool."""
    bodies = [body for body in scene.bodies if body.movable]
    pull = np.array(scene.gravity)
    lowest = max(float(np.array(body.p_WB) @ pull) for body in scene.bodies)
    start = Trajectory.at(State.initial(scene))
    falls = sum(body.mass * (lowest - float(np.array(body.p_WB) @ pull)) for body in bodies)
    swings = float(np.linalg.norm(pull)) * _reach(scene) * sum(body.mass for body in bodies)
    available = float(kinetic_energy(scene, start)[0]) + falls + swings + _sprung(scene, start)
    if available > 0:
        yield "energy", kinetic_energy(scene, actual) > ENERGY_FACTOR * available
    yield "penetration", _sunk(scene, actual)
    top = max(body.p_WB[2] for body in bodies)
    highest = [place for place in movable(scene).tolist() if math.isclose(scene.bodies[place].p_WB[2], top, rel_tol=1e-9)]
    if top > 0 and any(pull):
        yield "height", np.any(actual.p_WB[:, highest, 2] < top / 2, axis=1)
    for joint in scene.joints:
        if isinstance(joint, Revolute) and joint.drive is not None:
            yield "drive", np.abs(joint_coordinate(scene, joint, actual) - _targets(joint.drive, actual)) > OFF_TARGET


def _targets(drive: Drive, actual: Trajectory) -> Floats:
    """Where a drive wants its joint at each sample [rad], (t,)."""
    motion = drive.motion
    if motion is None:
        return np.full(len(actual), drive.target)
    return np.array([motion.at(float(time), drive.target) for time in actual.time])


def first_break(scene: Scene, actual: Trajectory, signs: Collection[str] = SIGNS) -> tuple[float, str]:
    """When [s] the first of these signs shows, and its name; the end of the run and '' where none does.

    Raises: NotMeasurable.
    """
    if len(actual) == 0 or len(movable(scene)) == 0:
        raise NotMeasurable("no movable body or no samples")
    shown = ((name, shows) for name, shows in _signs(scene, actual) if name in signs)
    breaks = [(float(actual.time[np.argmax(shows)]), name) for name, shows in shown if shows.any()]
    return min(breaks, default=(float(actual.time[-1]), ""))


@metric(
    "s",
    better="higher",
    verdict="where bodies should stand, a highest sinks below half its height, a drive is half a radian off, one is in another "
    "by half of the thinner, or energy is a thousandfold",
)
def collapse_time(run: Run) -> float:
    """definition: the first time at which a sign of a broken run shows (energy, penetration, height, drive); the end of the run
    where none does"""
    time, _ = first_break(run.scene, run.actual)
    return time
