"""Why a tuned track stands as it does although another setting does better in some cases."""

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
