"""A recorded run of commands laid over a scene: its joints follow a log in place of what the scene says.

A position is the moving target of the joint's drive. A velocity v is the law d (v - x') with the drive's damping d: the drive
keeps -d x', and d v is an effort. A torque is an effort alone, cut off at the drive's limit, and the drive is gone. Values are
held until the next sample, as a controller holds them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches

from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Drive, Prismatic, Revolute, Samples, Scene
from plumbline.harness.scene.importers.commands import Log, Quantity

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
