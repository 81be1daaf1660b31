"""What adapters declare: why a tuned track stays though a setting does better somewhere, why ours errs least, what an extra
takes.
"""

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class TradeOff:
    """Why 'tuned' stands as it does although another setting does better in some cases.

    Terms:
        cases: by name. why: with the figures. knob: the one that does better if it is turned alone ('iterations',
        'options.cone'); '' for the track 'default'. values: to which of them; to any, if none is named. at: the case's own time
        step; or, of 'default' alone, where it does better: it errs less at the own step, or over the ladder in the mean, or it
        errs no more there and costs less (price).
    """

    cases: tuple[str, ...]
    why: str
    knob: str = ""
    values: tuple[Any, ...] = ()
    at: tuple[Literal["own step", "ladder", "price"], ...] = ("own step",)

    def __post_init__(self) -> None:
        where = f"trade-off in {', '.join(self.cases) or 'no case'}"
        if not self.cases or not self.why.strip() or not self.at:
            raise ValueError(f"{where}: expected cases, a reason, and at which steps")
        if (self.values and not self.knob) or (self.knob and self.at != ("own step",)):
            raise ValueError(f"{where}: expected values of a knob alone, and a knob at the own step alone")


def check_named(adapter: str, trade_offs: Iterable[TradeOff], knobs: Mapping[str, Sequence[Any]]) -> None:
    """Raises: ValueError, if one names a knob or a value that the adapter does not have."""
    for one in trade_offs:
        known = knobs.get(one.knob, ())
        if (one.knob and one.knob not in knobs) or any(value not in known for value in one.values):
            where = f"adapter '{adapter}': trade-off in {', '.join(one.cases)}"
            raise ValueError(f"{where}: '{one.knob}' {list(one.values)}, expected one of its knobs and some of its values")


@dataclass(frozen=True, slots=True, kw_only=True)
class Advantage:
    """Why an engine errs least in a case: what it is given, and not what it is.

    Terms:
        by: sub-steps, where it takes several to the others' one; the order of its integrator; construction, where its method
        keeps or has in it what the truth says; its own law, where others have none; a solver, where another method solves the
        same equations; defaults, where the others' own ones, or their adapters', add what the scene does not ask for. why: as a
        sentence without its full stop, with the figures.
    """

    by: Literal["sub-steps", "order", "construction", "own law", "solver", "defaults"]
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Extra:
    """An engine that is installed when it is asked for: by plumbline's extra of its name, or in an environment of its own.

    Terms: megabytes: that its environment takes on the disk. seconds: that installing it took where that was measured. pythons:
    the versions of Python that its package index has wheels for.
    """

    megabytes: int
    seconds: int
    pythons: tuple[str, ...] = ("3.11", "3.12", "3.13")

    @property
    def price(self) -> str:
        """What it takes, in words."""
        return f"{self.megabytes} MB, about {self.seconds} s"

    @property
    def hindrance(self) -> str:
        """Why it cannot be installed beside this Python; '' where it can."""
        running = f"{sys.version_info.major}.{sys.version_info.minor}"
        return "" if running in self.pythons else f"needs Python {' or '.join(self.pythons)}; this is {running}"
