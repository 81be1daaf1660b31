"""A robot whose file counts in centimetres or grams, in SI units."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene.importers.companion import Units
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.robot import Closure, Coordinate, Robot, Tie
from plumbline.harness.scene.shape import LENGTHS

SUSPECT = 50.0
"""Gravity [m/s2] above which a file's unit of length is probably not the metre: twice that of Jupiter."""
Part = TypeVar("Part")
_FIELDS: Mapping[str, tuple[str, ...]] = {
    "length": (
        *("p", "anchor", "anchor_A", "anchor_B", "centre", "v_start", "scale", "rolling_friction", "torsional_friction"),
        *LENGTHS,
    ),
    "mass": ("mass",),
    "inertia": ("inertia",),
    "own": ("reference", "lower", "upper", "rest", "position", "velocity", "speed", "target", "target_velocity", "offset"),
    "force": ("friction_loss", "effort", "limit", "feedforward", "push"),
    "force/own": ("stiffness", "damping", "armature"),
}
"""The unit of each number of a robot, its shapes and laws among them; `own` is that of a coordinate."""
_UNITS = {name: unit for unit, names in _FIELDS.items() for name in names}


def suspected(robot: Robot, units: Units | None) -> list[Fidelity]:
    """A row where gravity is that of no planet in metres, and no unit is told."""
    strength = 0.0 if robot.gravity is None else float(np.linalg.norm(robot.gravity))
    if units is not None or strength <= SUSPECT:
        return []
    return Fidelity.told("gravity", "", strength)


@dataclass(frozen=True, slots=True)
class _Scale:
    """Terms: length [m], mass [kg]: of the file's units. own: of a coordinate's, a length or 1. slides: by name."""

    length: float
    mass: float
    own: float
    slides: frozenset[str]

    def value(self, unit: str, value: Any) -> Any:
        """A number, or an array or tuple of them, in SI units."""
        if value is None:
            return None
        if isinstance(value, tuple):
            return tuple((np.array(value) * self.length).tolist())
        force = self.mass * self.length * self.length / self.own
        times: Mapping[str, Callable[[Any], Any]] = {
            "length": lambda x: x * self.length,
            "mass": lambda x: x * self.mass,
            "inertia": lambda x: x * (self.mass * self.length * self.length),
            "own": lambda x: x * self.own,
            "force": lambda x: x * force,
            "force/own": lambda x: x * force / self.own,
        }
        return times[unit](value)

    def whole(self, owner: Part) -> Part:
        """A part of a robot, with all that it is made of: a stiffness is a force over its coordinate's unit, and so on."""
        scale = self
        if isinstance(owner, Coordinate | Closure):
            slides = isinstance(owner, Closure) or owner.kind == "prismatic"
            scale = replace(self, own=self.length if slides else 1.0)
        changed: dict[str, Any] = {}
        for field in fields(owner):  # type: ignore[arg-type]
            value = getattr(owner, field.name)
            if field.name in _UNITS:
                changed[field.name] = scale.value(_UNITS[field.name], value)
            elif is_dataclass(value):
                changed[field.name] = scale.whole(value)
            elif isinstance(value, tuple) and value and is_dataclass(value[0]):
                changed[field.name] = tuple(map(scale.whole, value))
        if isinstance(owner, Tie):
            changed["ratio"] = owner.ratio * self.own / (self.length if owner.joint in self.slides else 1.0)
        return replace(owner, **changed)  # type: ignore[type-var]


def scaled(robot: Robot, units: Units) -> Robot:
    """All lengths, masses and what is made of them, seconds and radians left as they are. Raises: RobotError."""
    if robot.tendons:
        raise RobotError(
            f"{robot.source}: tendon {quoted(robot.tendons[0].name, 80)}: its length has a unit of its own, expected no "
            "[units] in the companion file; --drop tendon leaves tendons out"
        )
    slides = frozenset(c.name for link in robot.links for c in link.coordinates if c.kind == "prismatic")
    scale = _Scale(units.length, units.mass, 1.0, slides)
    return replace(
        robot,
        links=tuple(map(scale.whole, robot.links)),
        closures=tuple(map(scale.whole, robot.closures)),
        gravity=scale.value("length", robot.gravity),
        contacts=robot.contacts and scale.whole(robot.contacts),
    )
