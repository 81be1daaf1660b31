"""Two robots under the same torques: the commands, and the first instant and joint at which the two part."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.replay import Log, near_miss, read_log, timed
from plumbline.harness.scene.parity.canonical import SCALAR, Canonical
from plumbline.harness.scene.parity.motion import Configuration, dynamics, first_rates

DT = 2.5e-4
"""Time step [s] of the motion; both robots err alike with it."""
PARTED = 1e-3
"""Distance of a joint [rad or m] at which two robots have parted: what sensors of joints resolve."""
MOVES = ("drop", "sines")
"""Commands by name: no torque at all; a sinusoid at every joint."""
_SLOWEST, _GOLDEN = 0.5, (5**0.5 - 1) / 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """What a robot is to do.

    Terms: gravity [m/s2]. start (n): of each joint [rad or m], 0 for balls and free ones; all are at rest. torques (steps, n)
    [N m or N]: of each joint over each step of DT; 0 for balls and free ones.
    """

    gravity: Array
    start: Array
    torques: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Parting:
    """When and where two robots part.

    Terms: time [s], joint, unit: of the first joint that is PARTED from its partner; None and '' where none is. duration [s]:
    of the motion. farthest, distance, farthest_unit: the joint that was the farthest from its partner at any time.
    """

    duration: float
    time: float | None = None
    joint: str = ""
    unit: str = ""
    farthest: str = ""
    distance: float = 0.0
    farthest_unit: str = ""


def motion_of(
    name: str,
    robot: Canonical,
    at: Configuration,
    gravity: Array,
    duration: float,
    *,
    replay: bool = False,
    held: bool = False,
    tell: Callable[[str], object] = str,
) -> Motion:
    """The motion by one of MOVES, or by a log with a column `time` [s] and one a joint [N m or N].

    Args: replay: the log says ':torque' of its columns, as in a run; else all are. held: between samples; else joined by lines.
    tell: is told what is taken of a log and what is assumed.

    A sinusoid is as large as gravity's torque on the joint in the given configuration, no less than a hundredth of the weight
    at a metre and no more than half of the joint's effort; frequencies lie between 0.5 and 1 Hz, no two in the same ratio.

    Raises: RobotError, naming file, line and column.
    """
    times: Array = np.arange(round(duration / DT), dtype=np.float64) * DT
    torques = np.zeros((len(times), len(robot.joints)))
    if name == "sines" and not replay:
        weights = np.abs(dynamics(robot, Configuration(at.q, at.turned, np.zeros_like(at.rates)), gravity).bias)
        least = 0.01 * robot.weight * float(np.linalg.norm(gravity))
        for k, (joint, first) in enumerate(zip(robot.joints, first_rates(robot), strict=False)):
            if joint.kind in SCALAR:
                bound = np.inf if joint.effort is None else joint.effort / 2
                frequency = _SLOWEST * (1 + (k * _GOLDEN) % 1)
                size = min(max(float(weights[first]), least), bound)
                torques[:, k] = size * np.sin(2 * np.pi * frequency * times)
    elif replay or name != "drop":
        log, moving = read_log(Path(name)), ("torque",) if replay else ("position", "torque")
        stamps = timed(log, duration, joined=not held, tell=tell)
        _fill(torques, times, log, np.array(stamps), robot, moving=moving, held=held)
        if still := [joint.name for joint in robot.joints if not any(joint.name == name for name, _ in log.columns)]:
            tell(f"{log.source}: without a column, and without a torque: {listed(still, 12)}")
    return Motion(gravity=gravity, start=at.q, torques=torques)


def _fill(
    torques: Array, times: Array, log: Log, stamps: Array, robot: Canonical, *, moving: tuple[str, ...], held: bool
) -> None:
    places = {joint.name: k for k, joint in enumerate(robot.joints) if joint.kind in SCALAR}
    for (name, quantity), values in log.columns.items():
        if name not in places:
            raise RobotError(f"{log.source}: column {quoted(name, 80)} is no joint of the file{near_miss(name, list(places))}")
        if quantity not in moving:
            column = quoted(name, 80)
            raise RobotError(f"{log.source}: column {column} is a {quantity}; torques move both, expected '{name}:torque'")
        if held:
            torques[:, places[name]] = np.array(values)[np.clip(np.searchsorted(stamps, times, "right") - 1, 0, None)]
        else:
            torques[:, places[name]] = np.interp(times, stamps, values)


def parting(robot: Canonical, a: Array, b: Array) -> Parting:
    """When two motions part. Args: a, b (samples, joints, 4): as `Adapter.move_robot` gives them, DT apart."""
    apart = np.empty(a.shape[:2])
    for k, joint in enumerate(robot.joints):
        if joint.kind in SCALAR:
            apart[:, k] = np.abs(a[:, k, 0] - b[:, k, 0])
        else:
            sine = np.minimum(np.linalg.norm(a[:, k] - b[:, k], axis=-1), np.linalg.norm(a[:, k] + b[:, k], axis=-1)) / 2
            apart[:, k] = 4 * np.arcsin(np.minimum(1.0, sine))
    units = _units(robot)
    far = int(np.argmax(np.nanmax(apart, axis=0)))
    whole = Parting(
        duration=(len(a) - 1) * DT,
        farthest=robot.joints[far].name,
        distance=float(np.nanmax(apart[:, far])),
        farthest_unit=units[robot.joints[far].name],
    )
    beyond = np.argwhere(~(apart <= PARTED))
    if not len(beyond):
        return whole
    sample = int(beyond[0, 0])
    first = robot.joints[int(np.argmax(np.where(np.isnan(apart[sample]), np.inf, apart[sample])))].name
    return Parting(
        duration=whole.duration, time=sample * DT, joint=first, unit=units[first], farthest=whole.farthest,
        distance=whole.distance, farthest_unit=whole.farthest_unit,
    )  # fmt: skip


def _units(robot: Canonical) -> Mapping[str, str]:
    return {joint.name: "m" if joint.kind == "prismatic" else "rad" for joint in robot.joints}
