"""What a robot file does not say: the small `robot.plumb.toml` beside it, read as scene files are."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass

from plumbline.harness.intake.documents import InputError, document, named
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import Root, Start
from plumbline.harness.intake.typed_fields import FieldError, filled
from plumbline.harness.scene import Motion, Quaternion, Sensor, Surface, Vector3
from plumbline.harness.scene.sensor import Pixels
from plumbline.harness.scene.values import FROZEN, Finite, Name, NonNegative, Positive

ENDING = ".plumb.toml"
Seconds = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]
Step = Annotated[float, Field(ge=1e-9, le=1, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Base:
    """The root's pose and velocity at the start, in W. Terms: rpy [rad]: roll, pitch, yaw about fixed axes, in place of q."""

    position: Vector3 = (0.0, 0.0, 0.0)
    orientation: Quaternion | None = None
    rpy: Vector3 | None = None
    velocity: Vector3 = (0.0, 0.0, 0.0)
    angular_velocity: Vector3 = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if self.orientation is not None and self.rpy is not None:
            raise ValueError("base: orientation and rpy are both given, expected one of them")


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Ground:
    """A plane that the robot can stand on, solid below z = height [m]."""

    height: Finite = 0.0
    material: Name = "ground"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Drives:
    """Gains of the drives of all joints [N m/rad or N/m, and per second], but where a joint has its own."""

    stiffness: NonNegative = 0.0
    damping: NonNegative = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class JointWish:
    """One joint.

    Terms:
        position, velocity: at the start [rad or m, per second]. target, target_velocity, stiffness, damping, limit,
        feedforward [N m or N]: of its drive; feedforward alone is a motor of constant torque or force. motion: how the target
        moves. limits: the range in place of the file's; 'none' for an open one.
    """

    position: Finite | None = None
    velocity: Finite = 0.0
    target: Finite | None = None
    target_velocity: Finite = 0.0
    stiffness: NonNegative | None = None
    damping: NonNegative | None = None
    limit: Positive | None = None
    feedforward: Finite | None = None
    limits: tuple[Finite, Finite] | Literal["none"] | None = None
    motion: Motion | None = None


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Massless:
    """What a link between two joints weighs that the file gives no mass: a ball of this mass [kg] and radius [m]."""

    mass: Positive
    radius: Positive = 0.01


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Cameras:
    """Pictures by an MJCF file's cameras that ride on a body: rate [Hz]; width, height [pixels] of those that state none."""

    rate: Positive = 10.0
    width: Pixels = 160
    height: Pixels = 120


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Units:
    """What the file's unit of length is in metres and its unit of mass in kilograms."""

    length: Positive = 1.0
    mass: Positive = 1.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Companion:
    """All that the file beside a robot says.

    Terms:
        root: how the root is held. start: joints start at zero, in the middle of
        their range, or at zero but within it; None is zero, and within it in a scenario. keyframe: the name of a pose
        of the file. density [kg/m3]: of shapes, where the file gives no mass. self_collision: do its own links touch each
        other? ellipsoids: as they are, or as the hulls of points on them, for engines that have none. speed_limits: are the
        file's velocity limits laws of its joints? materials: by link, where it is not 'robot'. commands: a CSV file beside it
        with targets of joints over time. sensors: as a scene has them, with a link for their body and poses in it.
        duration [s], dt [s] (the coarsest time step), look_at (links or joints), seed: of the run.
    """

    root: Root | None = None
    start: Start | None = None
    keyframe: Name | None = None
    base: Base | None = None
    gravity: Vector3 | None = None
    ground: Ground | None = None
    surfaces: tuple[Surface, ...] = ()
    materials: dict[Name, Name] = Field(default_factory=dict)
    self_collision: bool = False
    drives: Drives | None = None
    joints: dict[Name, JointWish] = Field(default_factory=dict)
    density: Positive | None = None
    massless: Massless | None = None
    cameras: Cameras | None = None
    units: Units | None = None
    drop: tuple[Annotated[str, Field(min_length=1, max_length=1000)], ...] = ()
    packages: dict[Name, Annotated[str, Field(min_length=1, max_length=1000)]] = Field(default_factory=dict)
    one_friction: bool = False
    convex: Annotated[int, Field(ge=2, le=64)] | None = None
    ellipsoids: Literal["exact", "polyhedra"] = "exact"
    speed_limits: bool = False
    commands: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    sensors: tuple[Sensor, ...] = ()
    duration: Seconds | None = None
    dt: Step | None = None
    look_at: tuple[Name, ...] = ()
    seed: Annotated[int, Field(ge=0, lt=2**32)] | None = None


_ADAPTER: TypeAdapter[Companion] = TypeAdapter(Companion)


def beside(path: Path) -> Path:
    """Where the companion of a file lies, whether it is there or not: arm.urdf has arm.plumb.toml."""
    return path.with_name(path.name.removesuffix(path.suffix) + ENDING)


def load_companion(path: Path) -> Companion:
    """The companion file at a path; an empty one where there is no such file.

    Raises:
        RobotError: naming the file, the key with the valid ones, the value and what was expected.
    """
    if not path.exists() and not path.is_symlink():
        return Companion()
    where = named(path)
    try:
        table = document(path)
    except InputError as error:
        raise RobotError(str(error)) from None
    try:
        return filled(_ADAPTER, table, where)
    except FieldError as error:
        raise RobotError(str(error)) from None
