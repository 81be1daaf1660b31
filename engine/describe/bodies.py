"""Bodies and the surface law between two materials."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from plumbline.engine.describe.check import finite, not_negative, positive, spd_inertia, unit_quaternion
from plumbline.engine.describe.optics import Optics
from plumbline.engine.describe.shapes import Placed
from plumbline.engine.maths.types import Floats

Numbers = Sequence[float] | Floats
"""A few numbers: a tuple, a list or an array."""


PLAIN = Optics()
"""Light grey that only scatters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A rigid body.

    Terms:
        mass [kg]; inertia (3, 3) kg m2 in B about the centre of mass, both zero of a body between two joints of a tree; shapes:
        what touches; visual: what is drawn and seen by rays that ask for it, the same if None; optics: what light does at its
        surface; p_WB [m], q_WB (w, x, y, z), v_WB [m/s] of the centre of mass, w_WB [rad/s] in W; linear_damping and
        angular_damping: rates c [1/s] in v' = -c v and w' = -c w; motion: 'static' never moves, 'kinematic' keeps its
        velocities whatever touches it.
    """

    name: str = "body"
    mass: float = 1.0
    inertia: Any = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    shapes: Sequence[Placed] = ()
    visual: Sequence[Placed] | None = None
    material: str = "default"
    optics: Optics = PLAIN
    p_WB: Numbers = (0.0, 0.0, 0.0)
    q_WB: Numbers = (1.0, 0.0, 0.0, 0.0)
    v_WB: Numbers = (0.0, 0.0, 0.0)
    w_WB: Numbers = (0.0, 0.0, 0.0)
    motion: Literal["dynamic", "static", "kinematic"] = "dynamic"
    linear_damping: float = 0.0
    angular_damping: float = 0.0

    def __post_init__(self) -> None:
        label = f"body '{self.name}'"
        if not isinstance(self.name, str) or not self.name:
            raise ValueError(f"body: name {self.name!r}, expected words")
        for part, placed in enumerate(self.shapes):
            if not isinstance(placed, Placed):
                raise ValueError(f"{label}: shape {part} is {placed!r}, expected a Placed")
        if not isinstance(self.optics, Optics):
            raise ValueError(f"{label}: optics {self.optics!r}, expected Optics")
        if self.motion not in ("dynamic", "static", "kinematic"):
            raise ValueError(f"{label}: motion '{self.motion}', expected dynamic, static or kinematic")
        if self.motion == "dynamic":
            if self.massless:
                if self.shapes or self.linear_damping or self.angular_damping:
                    raise ValueError(f"{label}: mass 0 kg and shapes or damping, expected neither")
            else:
                positive(label, "mass", self.mass, "kg")
                spd_inertia(label, self.inertia)
        finite(label, "p_WB", self.p_WB, (3,), "m")
        unit_quaternion(label, "q_WB", self.q_WB)
        finite(label, "v_WB", self.v_WB, (3,), "m/s")
        finite(label, "w_WB", self.w_WB, (3,), "rad/s")
        if self.motion == "static" and (np.any(np.asarray(self.v_WB, float)) or np.any(np.asarray(self.w_WB, float))):
            raise ValueError(f"{label}: static, but v_WB {tuple(self.v_WB)} m/s or w_WB {tuple(self.w_WB)} rad/s is not zero")
        not_negative(label, "linear_damping", self.linear_damping, "1/s")
        not_negative(label, "angular_damping", self.angular_damping, "1/s")

    @property
    def massless(self) -> bool:
        """Has it neither mass nor inertia, so that it stands between two joints alone?"""
        return self.motion == "dynamic" and self.mass == 0 and not np.any(np.asarray(self.inertia, float))


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """The law between a pair of materials.

    Terms:
        static_friction, kinetic_friction [1]: tangential over normal force at rest and while sliding; restitution [1]:
        separation over approach speed; rolling_friction, torsional_friction [m]: moment over normal force.
    """

    static_friction: float = 0.0
    kinetic_friction: float = 0.0
    restitution: float = 0.0
    rolling_friction: float = 0.0
    torsional_friction: float = 0.0

    def __post_init__(self) -> None:
        for name in ("static_friction", "kinetic_friction", "restitution", "rolling_friction", "torsional_friction"):
            not_negative("surface", name, getattr(self, name), "")
        if self.static_friction < self.kinetic_friction:
            raise ValueError(
                f"surface: static_friction {self.static_friction} lies below kinetic_friction {self.kinetic_friction}"
            )
        if self.restitution > 1:
            raise ValueError(f"surface: restitution {self.restitution}, expected 0..1")
