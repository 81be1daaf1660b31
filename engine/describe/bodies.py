"""Bodies and the surface law between two materials."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, get_args

import numpy as np

from plumbline.engine.describe.check import Described, finite, not_negative, one_of, positive, spd_inertia, unit_quaternion
from plumbline.engine.describe.optics import Optics
from plumbline.engine.describe.shapes import Placed
from plumbline.engine.maths.types import Floats

Numbers = Sequence[float] | Floats
"""A few numbers: a tuple, a list or an array."""


Motion = Literal["dynamic", "static", "kinematic"]

PLAIN = Optics()
"""Light grey that only scatters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Body(Described):
    """A rigid body.

    Terms:
        mass [kg]; inertia (3, 3) kg m2 in B about the centre of mass, both zero of a body between two joints of a tree; shapes:
        what touches; visual: what is drawn and seen by rays that ask for it, the same if None; optics: what light does at its
        surface; p_WB [m], q_WB (w, x, y, z), v_WB [m/s] of the centre of mass, w_WB [rad/s] in W; linear_damping and
        angular_damping: rates c [1/s] in v' = -c v and w' = -c w; motion: 'static' never moves, 'kinematic' keeps its
        velocities whatever touches it.
    """

    ELEMENT: ClassVar[str] = "body '{0.name}'"
    name: str = "body"
    mass: float = 1.0
    inertia: Any = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    shapes: Sequence[Placed] = ()
    visual: Sequence[Placed] | None = None
    material: str = "default"
    optics: Optics = PLAIN
    p_WB: Annotated[Numbers, finite, (3,), "m"] = (0.0, 0.0, 0.0)
    q_WB: Annotated[Numbers, unit_quaternion] = (1.0, 0.0, 0.0, 0.0)
    v_WB: Annotated[Numbers, finite, (3,), "m/s"] = (0.0, 0.0, 0.0)
    w_WB: Annotated[Numbers, finite, (3,), "rad/s"] = (0.0, 0.0, 0.0)
    motion: Annotated[Motion, one_of, get_args(Motion)] = "dynamic"
    linear_damping: Annotated[float, not_negative, "1/s"] = 0.0
    angular_damping: Annotated[float, not_negative, "1/s"] = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise ValueError(f"body: name {self.name!r}, expected words")
        self.check_fields()
        label = self.label
        for part, placed in enumerate(self.shapes):
            if not isinstance(placed, Placed):
                raise ValueError(f"{label}: shape {part} is {placed!r}, expected a Placed")
        if not isinstance(self.optics, Optics):
            raise ValueError(f"{label}: optics {self.optics!r}, expected Optics")
        if self.motion == "dynamic":
            if self.massless:
                if self.shapes or self.linear_damping or self.angular_damping:
                    raise ValueError(f"{label}: mass 0 kg and shapes or damping, expected neither")
            else:
                positive(label, "mass", self.mass, "kg")
                spd_inertia(label, self.inertia)
        if self.motion == "static" and (np.any(np.asarray(self.v_WB, float)) or np.any(np.asarray(self.w_WB, float))):
            raise ValueError(f"{label}: static, but v_WB {tuple(self.v_WB)} m/s or w_WB {tuple(self.w_WB)} rad/s is not zero")

    @property
    def looks(self) -> Sequence[Placed]:
        """What it is drawn with."""
        return self.shapes if self.visual is None else self.visual

    @property
    def massless(self) -> bool:
        """Has it neither mass nor inertia, so that it stands between two joints alone?"""
        return self.motion == "dynamic" and self.mass == 0 and not np.any(np.asarray(self.inertia, float))


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface(Described):
    """The law between a pair of materials.

    Terms:
        static_friction, kinetic_friction [1]: tangential over normal force at rest and while sliding; restitution [1]:
        separation over approach speed; rolling_friction, torsional_friction [m]: moment over normal force.
    """

    static_friction: Annotated[float, not_negative, ""] = 0.0
    kinetic_friction: Annotated[float, not_negative, ""] = 0.0
    restitution: Annotated[float, not_negative, ""] = 0.0
    rolling_friction: Annotated[float, not_negative, ""] = 0.0
    torsional_friction: Annotated[float, not_negative, ""] = 0.0

    def __post_init__(self) -> None:
        self.check_fields()
        if self.static_friction < self.kinetic_friction:
            raise ValueError(
                f"surface: static_friction {self.static_friction} lies below kinetic_friction {self.kinetic_friction}"
            )
        if self.restitution > 1:
            raise ValueError(f"surface: restitution {self.restitution}, expected 0..1")
