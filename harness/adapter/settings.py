"""How to solve a scene: what engines are asked for, and what they say that they used."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.trajectory.pace import PACES


class SettingsError(PlumblineError, ValueError):
    """A setting that the adapter does not know, or a value outside its range; names field, value and expectation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How to solve a scene. None leaves a field to the engine.

    Terms:
        dt [s]; substeps per dt; iterations of the contact or constraint solver; integrator, solver: the engine's own names in
        lower case; tolerance of the solver; options: what only this engine knows; source: who recommends it.
        pace: the recorded sequence of lengths that steps follow, dt their mean (`harness.trajectory.pace`); '' for even ones.
    """

    dt: float = 1 / 240
    substeps: int | None = None
    iterations: int | None = None
    integrator: str | None = None
    solver: str | None = None
    tolerance: float | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    source: str = ""
    pace: str = ""

    def __post_init__(self) -> None:
        if not 1e-12 <= self.dt <= 1e3:
            raise SettingsError(f"settings: dt {self.dt} s, expected 1e-12..1e3")
        for name in ("substeps", "iterations"):
            value = getattr(self, name)
            if value is not None and not 1 <= value <= 1_000_000:
                raise SettingsError(f"settings: {name} {value}, expected 1..1000000")
        if self.tolerance is not None and not 0 <= self.tolerance < 1:
            raise SettingsError(f"settings: tolerance {self.tolerance}, expected 0..1")
        if self.pace and self.pace not in PACES:
            raise SettingsError(f"settings: pace {self.pace!r}, expected one of {', '.join(PACES)}, or none for even steps")

    @property
    def substep(self) -> float:
        """The step that is really taken [s]: dt over its sub-steps, one where they are left to the engine."""
        return self.dt / (self.substeps or 1)

    def with_dt(self, dt: float) -> "Settings":
        """The same settings at another time step [s]."""
        return replace(self, dt=dt)

    def plain(self) -> dict[str, Any]:
        """The fields that are set, as a JSON-ready mapping."""
        flat = all(isinstance(value, str | int | float) for value in self.options.values())
        # A copy of all takes three times as long, and what an engine nests in its options has to be one.
        told = {one.name: getattr(self, one.name) for one in fields(self)} if flat else asdict(self)
        told["options"] = dict(told["options"])
        return {name: value for name, value in told.items() if value not in (None, "", {})}


BITS, OF_ONE_MACHINE = "bits", "of one machine"
"""The option, and its value where a step asks a library whose last bits go with the processor, like LAPACK."""


def only_here(resolved: Mapping[str, Any]) -> bool:
    """Do these settings promise their bits on one machine alone? Args: resolved: as a record has them."""
    return bool(resolved.get("options", {}).get(BITS) == OF_ONE_MACHINE)
