"""How a world is solved."""

import math
from dataclasses import dataclass

from engine.check import not_negative, positive

__all__ = ["BROAD_PHASES", "INTEGRATORS", "Options"]

INTEGRATORS = ("semi_implicit_euler", "rk4")
BROAD_PHASES = ("uniform_grid", "octree", "sweep_and_prune", "bvh", "brute_force")


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """The choices of a solver.

    Terms:
        dt [s]; substeps per dt of contacts and of semi-implicit Euler; iterations: sweeps with the position error; relaxations:
        sweeps without it; integrator: of bodies that no contact touches; broad_phase (None: by the number of shapes);
        contact_hertz [Hz] (None: as stiff as a sub-step allows, a quarter of its rate) and contact_damping_ratio of the soft
        contact; max_push [m/s]: fastest correction of penetration; bounce_speed [m/s]: slower approaches do not bounce (None:
        four times what gravity gives in a sub-step); margin [m]: contacts are made at least this far ahead; contacts,
        gyroscopic, continuous: whether these effects are simulated.
    """

    dt: float = 1 / 240
    substeps: int = 4
    iterations: int = 2
    relaxations: int = 1
    integrator: str = "semi_implicit_euler"
    broad_phase: str | None = None
    contact_hertz: float | None = None
    contact_damping_ratio: float = 10.0
    max_push: float = 3.0
    bounce_speed: float | None = None
    margin: float = 1e-3
    contacts: bool = True
    gyroscopic: bool = True
    continuous: bool = False

    def __post_init__(self) -> None:
        positive("options", "dt", self.dt, "s")
        for name in ("substeps", "iterations"):
            if getattr(self, name) < 1:
                raise ValueError(f"options: {name} {getattr(self, name)}, expected at least 1")
        if self.relaxations < 0:
            raise ValueError(f"options: relaxations {self.relaxations}, expected at least 0")
        if self.integrator not in INTEGRATORS:
            raise ValueError(f"options: integrator '{self.integrator}', expected one of {', '.join(INTEGRATORS)}")
        if self.broad_phase is not None and self.broad_phase not in BROAD_PHASES:
            raise ValueError(f"options: broad_phase '{self.broad_phase}', expected one of {', '.join(BROAD_PHASES)}")
        if self.contact_hertz is not None:
            positive("options", "contact_hertz", self.contact_hertz, "Hz")
        not_negative("options", "contact_damping_ratio", self.contact_damping_ratio, "")
        positive("options", "max_push", self.max_push, "m/s")
        not_negative("options", "margin", self.margin, "m")
        if self.bounce_speed is not None and not (math.isfinite(self.bounce_speed) and self.bounce_speed >= 0):
            raise ValueError(f"options: bounce_speed {self.bounce_speed} m/s, expected at least 0")

    @property
    def stiffest_hertz(self) -> float:
        """The highest frequency [Hz] of a contact that a sub-step resolves."""
        return 0.25 * self.substeps / self.dt
