"""Tables as a paper prints them: the columns that a reader asks for, with units in their headings and numbers as numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["Span", "paper_table"]

Row = Sequence[object]


@dataclass(frozen=True, slots=True)
class Span:
    """An interval, printed low to high."""

    low: float
    high: float


def paper_table(store: "Store", name: str, rows: Sequence[Mapping[str, Any]]) -> tuple[Sequence[str], list[Row]] | None:
    """Headings and cells of the table of that name with these rows; None for one that is printed as a terminal shows it."""
    match name:
        case "trials":
            return _trials(store, rows)
        case "price":
            return _PRICE, [_price(row) for row in rows]
        case "steps":
            return _STEPS, [_step(row) for row in rows]
        case "limits":
            return _LIMITS, [_limit(row) for row in rows]
        case _:
            return None


def _ms(seconds: float | None) -> float | None:
    return None if seconds is None else 1e3 * seconds


def _span(low: float | None, high: float | None) -> Span | None:
    return None if low is None or high is None else Span(low, high)


def _trials(store: "Store", rows: Sequence[Mapping[str, Any]]) -> tuple[Sequence[str], list[Row]]:
    headings = ("Case", "Engine", "Track", "Time step [ms]", "Error", "Unit", "CPU time [ms/s]", "95 % interval", "Outcome")
    cases = store.catalogue.get("cases", {})
    table = store.measurements
    values = {
        (trial, metric): (float(value), str(unit))
        for trial, metric, value, unit in zip(table["trial"], table["metric"], table["value"], table["unit"], strict=True)
    }
    cells: list[Row] = []
    for row in rows:
        error, unit = values.get((row["trial"], cases.get(row["case"], {}).get("headline", "")), (None, ""))
        price = (_ms(row["cpu_per_sim_s"]), _span(_ms(row["cpu_low"]), _ms(row["cpu_high"])))
        about = (row["case"], row["engine"], row["track"], _ms(row["dt"]))
        cells.append([*about, error, unit, *price, row["status"]])
    return headings, cells


_PRICE = (
    "Case",
    "Error",
    "Engine",
    "CPU time [ms/s]",
    "95 % interval",
    "Times the cheapest",
    "95 % interval",
    "Setting",
    "Time step [ms]",
    "Price",
)
"""The error is a share of the case's scale; ms/s are CPU milliseconds a simulated second."""


def _price(row: Mapping[str, Any]) -> Row:
    word = {"at most": "upper bound", "not within the ladder": "not reached"}.get(row["verdict"], row["verdict"])
    cost = (
        _ms(row["cost"]),
        _span(_ms(row["low"]), _ms(row["high"])),
        row["ratio"],
        _span(row["ratio_low"], row["ratio_high"]),
    )
    case = f"{row['case']} {row['where']}".strip()
    step = None if row["cost"] is None else _ms(row["dt"])
    return [case, row["target"], row["engine"], *cost, row["track"], step, word]


_STEPS = ("Case", "Engine", "Track", "Stable to [ms]", "Within 1 % to [ms]", "Error there", "Times real time")


def _step(row: Mapping[str, Any]) -> Row:
    case = f"{row['case']} {row['where']}".strip()
    steps = (_ms(row["stable"]), _ms(row["accurate"]))
    return [case, row["engine"], row["track"], *steps, row["error"], row["realtime"]]


_LIMITS = ("Case", "Engine", "Track", "Axis", "Unit", "Held to", "Broke at", "CPU time [ms/s]", "By")


def _limit(row: Mapping[str, Any]) -> Row:
    case = f"{row['case']} {row['where']}".strip()
    about = (case, row["engine"], row["track"], row["axis"], "" if row["unit"] == "1" else row["unit"])
    return [*about, row["held"], row["broke"], _ms(row["cost"]), row["signs"] or row["verdict"]]
