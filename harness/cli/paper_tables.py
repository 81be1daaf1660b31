"""Tables as a paper prints them: the columns that a reader asks for, titles for names, units in headings, digits that count."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plumbline.harness.findings.steps_taken import substeps_of

if TYPE_CHECKING:
    from plumbline.harness.findings.limits_found import Search
    from plumbline.harness.store.store import Store

Row = Sequence[object]


@dataclass(frozen=True, slots=True)
class Span:
    """An interval, printed low to high."""

    low: float
    high: float


def paper_table(store: "Store", name: str, rows: Sequence[Mapping[str, Any]]) -> tuple[Sequence[str], list[Row]] | None:
    """Headings and cells of the table of that name with these rows; None for one that is printed as a terminal shows it."""
    titles = _Titles.of(store)
    match name:
        case "trials":
            return _trials(store, rows, titles)
        case "price":
            return _PRICE, [_price(row, titles) for row in rows]
        case "steps":
            return _STEPS, [_step(row, titles) for row in rows]
        case "limits":
            from plumbline.harness.findings.limits_found import searches

            return _LIMITS, [_limit(search, titles) for search in searches(store) if not search.remedied]
        case _:
            return None


@dataclass(frozen=True, slots=True)
class _Titles:
    """What cases and engines are called on pages, by name."""

    cases: Mapping[str, str]
    engines: Mapping[str, str]

    @classmethod
    def of(cls, store: "Store") -> "_Titles":
        from plumbline.reports.words.catalogue import cases, engines

        of_cases = {name: str(case["title"]) for name, case in cases(store).items()}
        return cls(of_cases, {name: str(engine["title"]) for name, engine in engines(store).items()})

    def scene(self, case: str, where: str) -> str:
        """'A tower of boxes, n 4': a case and what tells its scene from others of it."""
        return self.cases[case] + (f", {where}" if where else "")


def _ms(seconds: float | None) -> float | None:
    return None if seconds is None else 1e3 * seconds


def _span(low: float | None, high: float | None) -> Span | None:
    return None if low is None or high is None else Span(low, high)


def _trials(store: "Store", rows: Sequence[Mapping[str, Any]], titles: _Titles) -> tuple[Sequence[str], list[Row]]:
    headings = (
        "Case",
        "Engine",
        "Track",
        "Time step [ms]",
        "Sub-steps",
        "Error",
        "Unit",
        "CPU time [ms/s]",
        "95 % interval",
        "Outcome",
    )
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
        about = (titles.cases[row["case"]], titles.engines[row["engine"]], row["track"])
        cells.append([*about, _ms(row["dt"]), substeps_of(str(row["resolved"])), error, unit, *price, row["status"]])
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
    "Sub-steps",
    "Price",
)
"""The error is a share of the case's scale; ms/s are CPU milliseconds a simulated second."""


def _price(row: Mapping[str, Any], titles: _Titles) -> Row:
    word = {"at most": "upper bound", "not within the ladder": "not reached"}.get(row["verdict"], row["verdict"])
    cost = (
        _ms(row["cost"]),
        _span(_ms(row["low"]), _ms(row["high"])),
        row["ratio"],
        _span(row["ratio_low"], row["ratio_high"]),
    )
    step = None if row["cost"] is None else _ms(row["dt"])
    return [
        titles.scene(row["case"], row["where"]),
        row["target"],
        titles.engines[row["engine"]],
        *cost,
        row["track"],
        step,
        None if step is None else row["substeps"],
        word,
    ]


_STEPS = (
    "Case",
    "Engine",
    "Track",
    "Stable to [ms]",
    "Sub-steps",
    "Within 1 % to [ms]",
    "Sub-steps",
    "Error there",
    "Times real time",
)


def _step(row: Mapping[str, Any], titles: _Titles) -> Row:
    about = (titles.scene(row["case"], row["where"]), titles.engines[row["engine"]], row["track"])
    steps = (_ms(row["stable"]), row["stable_substeps"], _ms(row["accurate"]), row["accurate_substeps"])
    return [*about, *steps, row["error"], row["realtime"]]


_LIMITS = ("Case", "Engine", "Track", "Axis", "Unit", "Held to", "Broke at", "CPU time [ms/s]", "By")


def _limit(search: "Search", titles: _Titles) -> Row:
    from plumbline.harness.findings.parameter_words import called
    from plumbline.harness.metric.titles import metric_title  # late: NumPy comes with it, and every command reads this file

    about = (titles.scene(search.case, search.where), titles.engines[search.engine], search.track)
    axis = (called(search.case, search.axis), "" if search.unit == "1" else search.unit)
    signs = ", ".join(f"{metric_title(metric)} {count}" for metric, count in search.signs.counts)
    return [*about, *axis, search.held, search.broke, _ms(search.cost), signs or search.signs.text or search.verdict]
