"""The price list: what an error of a case costs on each engine; worked out in `harness.findings.prices`."""

from collections.abc import Sequence

from plumbline.harness.findings.columns import Column, Row, Table, Titled, Titles, milli, names, scene, span
from plumbline.harness.findings.emulations import share_in_words
from plumbline.harness.findings.parameter_words import step_in_words
from plumbline.harness.findings.prices import Price, priced
from plumbline.harness.findings.standing import cheapest, counted, standing


def _cost(row: Row) -> str:
    if row["cost"] is not None:
        return f"{row['cost']:.3g}"
    if row["reason"]:
        return f"{row['verdict']}: {row['reason']}"
    best = ""
    if row["best_error"] is not None:
        best = f", best {row['best_error']:.2g} down to {step_in_words(row['finest_dt'], row['finest_substeps'])}"
    if row["foreseen_dt"] is not None:
        best += f", trend {1e3 * row['foreseen_dt']:.2g} ms"
    return f"{row['verdict']}{best}"


def _interval(row: Row, value: str, low: str, high: str) -> str:
    return "" if row[value] is None else f"{row[low]:.3g} .. {row[high]:.3g}"


def _marks(row: Row) -> str:
    """* cheapest to deploy, ~ an unstable timing, <= the cheapest point errs less already."""
    if row["cost"] is None:
        return ""
    marks = ("*" if row["cheapest"] else "") + ("~" if row["unstable"] else "")
    marks += {"at most": "<=", "within the truth's error": "truth"}.get(row["verdict"], "")
    return " ".join(filter(None, (marks, share_in_words(row["emulated"]))))


def _tried(row: Row) -> str:
    return f"{row['tried']}" + (" (all there are)" if row["ended"] == "nothing left to try" else "")


def _sentences(rows: Sequence[Row]) -> list[str]:
    """Who is cheapest how often."""
    pairs = cheapest([Price(**row) for row in rows])
    if not pairs:
        return []
    counts = counted(standing(pairs))
    shared = len(pairs) - sum(count for _, count in counts)
    alone = ", ".join(f"{engine} {count}" for engine, count in counts)
    open_ = f"; in {shared} intervals meet or larger steps were not tried, and nobody is counted" if shared else ""
    return [f"Of {len(pairs)} pairs of case and error that an engine to deploy reaches, cheapest: {alone}{open_}."]


_WORDS = {"at most": "upper bound", "not within the ladder": "not reached"}
"""What verdicts are called in a paper."""

TABLE = Table(
    columns=names(Price),
    objects=lambda store: priced(store).prices,
    shown=(
        Column("case", scene),
        Column("error", "target", ".0e"),
        Column("engine", "engine"),
        Column("CPU s", _cost),
        Column("95 %", lambda row: _interval(row, "cost", "low", "high")),
        Column("x cheapest", "ratio", ".3g"),
        Column("95 %", lambda row: _interval(row, "ratio", "ratio_low", "ratio_high")),
        Column("setting", "track"),
        Column("step", lambda row: "" if row["cost"] is None else step_in_words(row["dt"], row["substeps"])),
        Column("tried", _tried),
        Column("marks", _marks),
    ),
    sentences=_sentences,
    paper=(
        Titled("Case", Titles.scene),
        Column("Error", "target"),  # a share of the case's scale
        Titled("Engine", Titles.engine),
        Column("CPU time [ms/s]", lambda price: milli(price.cost)),  # CPU milliseconds a simulated second
        Column("95 % interval", lambda price: span(milli(price.low), milli(price.high))),
        Column("Times the cheapest", "ratio"),
        Column("95 % interval", lambda price: span(price.ratio_low, price.ratio_high)),
        Column("Setting", "track"),
        Column("Time step [ms]", lambda price: None if price.cost is None else milli(price.dt)),
        Column("Sub-steps", lambda price: None if price.cost is None or price.dt is None else price.substeps),
        Column("Price", lambda price: _WORDS.get(price.verdict, price.verdict)),
    ),
)
