"""A recorded run of commands laid over a scene: its joints follow a log in place of what the scene says.

A position is the moving target of the joint's drive. A velocity v is the law d (v - x') with the drive's damping d: the drive
keeps -d x', and d v is an effort. A torque is an effort alone, cut off at the drive's limit, and the drive is gone. Values are
held until the next sample, as a controller holds them.
"""

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Literal, TypeAlias, get_args

from plumbline.harness.intake.allowance import allowance, beyond
from plumbline.harness.intake.documents import InputError, named, read, regular
from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import wrong_size
from plumbline.harness.scene import Drive, Prismatic, Revolute, Samples, Scene
from plumbline.harness.scene.motion import MOST_SAMPLES

TIME = "time"
"""The name of the first column."""
Quantity: TypeAlias = Literal["position", "velocity", "torque"]
"""What a column holds: rad or m, the same a second, N m or N."""
QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)


@dataclass(frozen=True, slots=True, kw_only=True)
class Log:
    """What was commanded, or measured. Terms: source: the file, in words. time [s], rising; columns: by joint and quantity, as
    many values."""

    source: str
    time: tuple[float, ...]
    columns: Mapping[tuple[str, Quantity], tuple[float, ...]]


def load_commands(path: Path) -> dict[str, Samples]:
    """The motions of targets by the names of their joints, joined by straight lines. Raises: RobotError, as `read_log`."""
    log = read_log(path)
    for joint, quantity in log.columns:
        if quantity != "position":
            column = quoted(f"{joint}:{quantity}", 80)
            raise RobotError(f"{log.source}: column {column}: expected a position; --commands takes others")
    return {joint: Samples(time=log.time, target=values) for (joint, _), values in log.columns.items()}


def read_log(path: Path) -> Log:
    """A log of joints. A column is called like its joint, with ':velocity' or ':torque' behind it where it holds one.

    Raises:
        RobotError: naming file, line, column, value and expectation; for what is larger than allowed too.
    """
    where = named(path)
    names, columns, line = _of_arrays(path, where) if path.suffix == ".npz" else _of_text(path, where)
    if not 1 <= len(columns[0]) <= MOST_SAMPLES:
        raise RobotError(f"{where}: {len(columns[0])} lines of numbers, expected 1 to {MOST_SAMPLES}")
    for name, column in zip(names, columns, strict=True):
        for k, value in enumerate(column):
            if expected := wrong_size(value):
                raise RobotError(f"{where}: {line(k)}: column {quoted(name, 80)}: {value:g}, {expected}")
    times = columns[0]
    for k in range(1, len(times)):
        if times[k] <= times[k - 1]:
            raise RobotError(
                f"{where}: {line(k)}: column {quoted(TIME)}: {times[k]:g} after {times[k - 1]:g}, expected a later time"
            )
    by_joint: dict[tuple[str, Quantity], tuple[float, ...]] = {}
    for name, column in zip(names[1:], columns[1:], strict=True):
        joint, colon, quantity = name.rpartition(":")
        key: tuple[str, Quantity] = (name, "position")
        if colon and quantity in QUANTITIES:
            key = (joint, next(each for each in QUANTITIES if each == quantity))
        if key in by_joint:
            raise RobotError(f"{where}: column {quoted(name, 80)} is twice there, expected each once")
        by_joint[key] = tuple(column)
    return Log(source=where, time=tuple(times), columns=by_joint)


class _Lines:
    """Where in a file the k-th row of numbers stands, in words."""

    def __init__(self, numbers: list[int]) -> None:
        self._numbers = numbers

    def __call__(self, k: int) -> str:
        return f"line {self._numbers[k]}" if self._numbers else f"sample {k}"


_Columns: TypeAlias = tuple[list[str], list[list[float]], _Lines]


def _of_arrays(path: Path, where: str) -> _Columns:
    """Of an npz: 'time' (n,) and one array (n,) a joint."""
    import numpy as np

    try:
        regular(path)
        if path.stat().st_size > allowance().bytes:
            most = allowance().bytes
            raise RobotError(f"{where}: {path.stat().st_size} bytes, expected at most {most}; --limit bytes=N takes more")
        with np.load(path, allow_pickle=False) as file:
            if excess := beyond("parts", sum(info.file_size for info in file.zip.infolist()) // 8, "numbers"):
                raise RobotError(f"{where}: {excess}")
            arrays = {name: np.asarray(file[name]) for name in file.files}
    except RobotError:
        raise
    except InputError as error:
        raise RobotError(str(error)) from None
    except Exception as error:  # whatever zip files and heads of arrays can be made to raise, want of memory among it
        raise RobotError(f"{where}: no npz of plain arrays: {error}") from None
    names = _header([TIME, *(name for name in arrays if name != TIME)] if TIME in arrays else list(arrays) or [""], where)
    for name in names:
        array = arrays[name]
        if array.ndim != 1 or array.dtype.kind not in "fiu" or len(array) != len(arrays[TIME]):
            raise RobotError(
                f"{where}: array {quoted(name, 80)}: {array.dtype} of shape {array.shape}, expected numbers of shape "
                f"({arrays[TIME].size},)"
            )
    return names, [arrays[name].astype(float).tolist() for name in names], _Lines([])


def _of_text(path: Path, where: str) -> _Columns:
    try:
        lines = read(path).removeprefix("\ufeff").splitlines()
    except InputError as error:
        raise RobotError(str(error)) from None
    rows = [(number, cells) for number, cells in enumerate(_rows(lines, where), 1) if any(cell.strip() for cell in cells)]
    if not rows:
        raise RobotError(f"{where}: is empty, expected a first line like {TIME},JOINT,JOINT")
    names = _header(rows[0][1], f"{where}: line {rows[0][0]}")
    if excess := beyond("parts", (len(rows) - 1) * len(names), "numbers"):
        raise RobotError(f"{where}: {excess}")
    columns: list[list[float]] = [[] for _ in names]
    for number, cells in rows[1:]:
        if len(cells) != len(names):
            raise RobotError(f"{where}: line {number}: {len(cells)} values, expected {len(names)}: {listed(names, 8)}")
        for name, cell, column in zip(names, cells, columns, strict=True):
            column.append(_number(cell, f"{where}: line {number}: column {quoted(name, 80)}"))
    return names, columns, _Lines([number for number, _ in rows[1:]])


def _rows(lines: list[str], where: str) -> list[list[str]]:
    try:
        return list(csv.reader(lines, strict=True))
    except csv.Error as error:
        raise RobotError(f"{where}: no CSV: {error}; expected values with commas between them") from None


def _header(cells: list[str], where: str) -> list[str]:
    names = [cell.strip() for cell in cells]
    if names[0] != TIME or len(names) < 2:
        raise RobotError(f"{where}: {listed(names, 4)}, expected {TIME} and then the names of joints")
    for name in names:
        if not name or names.count(name) > 1:
            raise RobotError(
                f"{where}: column {quoted(name, 80)} {'is twice there' if name else 'has no name'}, expected names, each once"
            )
    return names


def _number(cell: str, where: str) -> float:
    try:
        value = float(cell) if len(cell) < 60 else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RobotError(f"{where}: {quoted(cell, 60)}, expected a finite number")
    return value


Driven = Revolute | Prismatic


@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """Of drives that have none. Terms: stiffness [N m/rad, N/m], damping [N m s/rad, N s/m]."""

    stiffness: float
    damping: float


def replayed(
    scene: Scene, log: Log, *, duration: float, gains: Gains | None, joined: bool, tell: Callable[[str], object]
) -> Scene:
    """The scene under a log. Args: duration [s] of the run. joined: by straight lines. tell: is told what is assumed.

    Raises: RobotError, for an unknown or missing joint and for a joint without the gains that its column needs.
    """
    joints = {joint.name: joint for joint in scene.joints if isinstance(joint, Revolute | Prismatic)}
    columns: dict[str, Quantity] = {}
    for name, quantity in log.columns:
        if name not in joints:
            raise RobotError(f"{log.source}: column {quoted(name, 80)} is no joint of the file{near_miss(name, list(joints))}")
        if name in columns:
            both = ", ".join(sorted({columns[name], quantity}))
            raise RobotError(f"{log.source}: joint {quoted(name, 80)} has two columns, expected one of {both}")
        columns[name] = quantity
    for name, joint in joints.items():
        if joint.drive is not None and name not in columns:
            raise RobotError(
                f"{log.source}: joint {quoted(name, 80)} has a drive and no column{near_miss(name, list(columns))}"
            )
    time = timed(log, duration, joined=joined, tell=tell)
    if free := [name for name in joints if name not in columns]:
        tell(f"{log.source}: without a column, and without a drive: {', '.join(free)}")

    def led(values: Sequence[float]) -> Samples:
        return Samples(time=time, target=tuple(values), held=None if joined else True)

    def under(joint: Driven) -> Driven:
        quantity = columns.get(joint.name)
        if quantity is None:
            return joint
        values, drive = log.columns[joint.name, quantity], joint.drive
        if quantity == "torque":
            limit = None if drive is None else drive.limit
            # A constant effort beside a drive is the middle of bounds that are not alike both ways.
            middle = 0.0 if joint.effort is None else joint.effort.at(0.0, 0.0)
            cut = values if limit is None else [min(max(value, middle - limit), middle + limit) for value in values]
            return replace(joint, drive=None, effort=led(cut))
        drive = _with_gains(joint, quantity, gains, log.source)
        if quantity == "position":
            return replace(joint, drive=replace(drive, target_velocity=0.0, motion=led(values)))
        if drive.limit is not None:
            tell(f"{log.source}: joint {quoted(joint.name, 80)}: its limit of {drive.limit:g} is left out under a velocity")
        pushed = [drive.damping * value for value in values]
        return replace(joint, drive=Drive(damping=drive.damping), effort=led(pushed))

    return replace(
        scene, joints=tuple(under(joint) if isinstance(joint, Revolute | Prismatic) else joint for joint in scene.joints)
    )


def timed(log: Log, duration: float, *, joined: bool, tell: Callable[[str], object]) -> tuple[float, ...]:
    """The times [s] of a log from its first on; tells what of them is assumed, and what is taken."""
    start = log.time[0]
    if start:
        tell(f"{log.source}: its first time, {start:.6g} s, is taken as the start")
    last = log.time[-1] - start
    if last < duration * (1 - 1e-9):
        tell(f"{log.source}: ends at {last:.3g} s of {duration:.3g} s; its last values are held from there on")
    held = "joined by straight lines" if joined else "held between samples"
    tell(f"{log.source}: {', '.join(f'{name} ({quantity})' for name, quantity in log.columns)}; {held}")
    return tuple(t - start for t in log.time)


def _with_gains(joint: Driven, quantity: Quantity, gains: Gains | None, source: str) -> Drive:
    """The drive of a joint, with the gains that are given where it lacks the one that its column needs. Raises: RobotError."""
    drive = joint.drive or Drive()
    needed = "stiffness" if quantity == "position" else "damping"
    if getattr(drive, needed) == 0.0 and gains is not None:
        drive = replace(drive, stiffness=gains.stiffness, damping=gains.damping)
    if getattr(drive, needed) == 0.0:
        raise RobotError(
            f"{source}: joint {quoted(joint.name, 80)}: its drive has no {needed}, which a {quantity} needs; --gains "
            "STIFFNESS,DAMPING gives it"
        )
    return drive


def near_miss(name: str, names: Sequence[str]) -> str:
    """What may have been meant by a name that is none of these, as the end of a sentence."""
    near = get_close_matches(name, names, 1, 0.5)
    return f"; did you mean {quoted(near[0], 80)}?" if near else f", expected one of {listed(list(names), 12) or 'none'}"


def recorded(scene: Scene, log: Log) -> Mapping[str, Sequence[float]]:
    """The measured positions by joint. Raises: RobotError, for a column that is no position of a joint of the scene."""
    joints = [joint.name for joint in scene.joints if isinstance(joint, Revolute | Prismatic)]
    for name, quantity in log.columns:
        if name not in joints:
            raise RobotError(f"{log.source}: column {quoted(name, 80)} is no joint of the file{near_miss(name, joints)}")
        if quantity != "position":
            column = quoted(f"{name}:{quantity}", 80)
            raise RobotError(f"{log.source}: column {column}: expected a position, as joints are compared")
    return {name: values for (name, _), values in log.columns.items()}
