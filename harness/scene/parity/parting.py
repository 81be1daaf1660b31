"""Two robots under the same torques: the commands, and the first instant and joint at which the two part."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plumbline.harness.intake.documents import named
from plumbline.harness.intake.refusal import RobotError, listed
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene.importers.files import text_of
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.parity.facts import RobotFacts
from plumbline.harness.scene.parity.motion import Configuration, dynamics, first_rates

DT = 2.5e-4
"""Time step [s] of the motion; both robots err alike with it."""
PARTED = 1e-3
"""Distance of a joint [rad or m] at which two robots have parted: what sensors of joints resolve."""
MOVES = ("drop", "sines")
"""Commands by name: no torque at all; a sinusoid at every joint."""
_SCALAR = ("revolute", "prismatic")
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


def motion_of(name: str, robot: RobotFacts, at: Configuration, gravity: Array, duration: float) -> Motion:
    """The motion by one of MOVES, or by a CSV file with a column `time` [s] and one a joint [N m or N], joined by lines.

    A sinusoid is as large as gravity's torque on the joint in the given configuration, no less than a hundredth of the weight
    at a metre and no more than half of the joint's effort; frequencies lie between 0.5 and 1 Hz, no two in the same ratio.

    Raises: RobotError, naming file, line and column.
    """
    times: Array = np.arange(round(duration / DT), dtype=np.float64) * DT
    torques = np.zeros((len(times), len(robot.joints)))
    if name == "sines":
        weights = np.abs(dynamics(robot, Configuration(at.q, at.turned, np.zeros_like(at.rates)), gravity).bias)
        least = 0.01 * sum(solid.mass for solid in robot.masses.values()) * float(np.linalg.norm(gravity))
        for k, (joint, first) in enumerate(zip(robot.joints, first_rates(robot), strict=False)):
            if joint.kind in _SCALAR:
                bound = np.inf if joint.effort is None else joint.effort / 2
                frequency = _SLOWEST * (1 + (k * _GOLDEN) % 1)
                size = min(max(float(weights[first]), least), bound)
                torques[:, k] = size * np.sin(2 * np.pi * frequency * times)
    elif name != "drop":
        _fill(torques, times, Path(name), robot)
    return Motion(gravity=gravity, start=at.q, torques=torques)


def _fill(torques: Array, times: Array, path: Path, robot: RobotFacts) -> None:
    where = named(path)
    rows = list(csv.reader(text_of(path, where).splitlines()))
    known = [joint.name for joint in robot.joints if joint.kind in _SCALAR]
    head = [cell.strip() for cell in rows[0]] if rows else []
    if len(rows) < 2 or head[:1] != ["time"]:
        raise RobotError(
            f"{where}: line 1: expected a column 'time' and one for each joint that is driven, and lines of numbers"
        )
    for name in head[1:]:
        if name not in known or head.count(name) > 1:
            raise RobotError(f"{where}: line 1: {quoted(name, 80)}, expected each of {listed(known, 12)} at most once")
    try:
        numbers = np.array([[float(cell) for cell in row] for row in rows[1:]])
    except ValueError:
        raise RobotError(f"{where}: expected {len(head)} numbers in each line after the first") from None
    if numbers.shape[1:] != (len(head),) or not np.isfinite(numbers).all() or (np.diff(numbers[:, 0]) <= 0).any():
        raise RobotError(f"{where}: expected {len(head)} finite numbers in each line, with times that grow")
    places = {joint.name: k for k, joint in enumerate(robot.joints)}
    for column, name in enumerate(head[1:], 1):
        torques[:, places[name]] = np.interp(times, numbers[:, 0], numbers[:, column])


def parting(robot: RobotFacts, a: Array, b: Array) -> Parting:
    """When two motions part. Args: a, b (samples, joints, 4): as `Adapter.move_robot` gives them, DT apart."""
    apart = np.empty(a.shape[:2])
    for k, joint in enumerate(robot.joints):
        if joint.kind in _SCALAR:
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


def _units(robot: RobotFacts) -> Mapping[str, str]:
    return {joint.name: "m" if joint.kind == "prismatic" else "rad" for joint in robot.joints}
