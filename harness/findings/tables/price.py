"""The price list: what an error of a case costs on each engine; worked out in `harness.findings.prices`."""

from collections.abc import Callable, Sequence

from plumbline.harness.findings.columns import Column, Table, Titled, Titles, at, bracketed, milli, plain, scene, span
from plumbline.harness.findings.emulations import share_in_words
from plumbline.harness.findings.parameter_words import step_in_words
from plumbline.harness.findings.prices import Beyond, Price, Reached, Silent, priced
from plumbline.harness.findings.standing import cheapest, counted, standing


def _cost(price: Price) -> str:
    match price.outcome:
        case Reached(cost=cost):
            return f"{cost.value:.3g}"
        case Silent(verdict=verdict, reason=reason):
            return f"{verdict}: {reason}"
        case Beyond(at=best, trend=trend):
            down = "" if price.finest is None else step_in_words(price.finest.dt, price.finest.substeps)
            ahead = "" if trend is None else f", trend {1e3 * trend.dt:.2g} ms"
            return f"{price.verdict}, best {best.error:.2g} down to {down}{ahead}"


def _marks(price: Price) -> str:
    """* cheapest to deploy, ~ an unstable timing, <= the cheapest point errs less already."""
    if price.reached is None:
        return ""
    marks = ("*" if price.cheapest else "") + ("~" if price.unstable else "")
    marks += {"at most": "<=", "within the truth's error": "truth"}.get(price.verdict, "")
    return " ".join(filter(None, (marks, share_in_words(price.reached.at.emulated))))


def _tried(price: Price) -> str:
    return f"{price.tried}" + (" (all there are)" if price.ended == "nothing left to try" else "")


def _sentences(prices: Sequence[Price]) -> list[str]:
    """Who is cheapest how often."""
    pairs = cheapest(prices)
    if not pairs:
        return []
    counts = counted(standing(pairs))
    shared = len(pairs) - sum(count for _, count in counts)
    alone = ", ".join(f"{engine} {count}" for engine, count in counts)
    open_ = f"; in {shared} intervals meet or larger steps were not tried, and nobody is counted" if shared else ""
    return [f"Of {len(pairs)} pairs of case and error that an engine to deploy reaches, cheapest: {alone}{open_}."]


def _of_reached(value: Callable[[Reached], object]) -> Callable[[Price], object]:
    return lambda price: None if price.reached is None else value(price.reached)


_WORDS = {"at most": "upper bound", "not within the ladder": "not reached"}
"""What verdicts are called in a paper."""

TABLE = Table(
    holds="case where target engine verdict unit cost(low,high)=reached.cost ratio..=reached.ratio cheapest "
    "best_error=best.error finest_dt=finest.dt finest_substeps=finest.substeps foreseen_dt=outcome.trend.dt "
    "foreseen_order=outcome.trend.order foreseen_track?=outcome.trend.track track?=outcome.at.track dt=outcome.at.dt "
    "substeps=outcome.at.substeps trial?=outcome.at.trial unstable emulated=reached.at.emulated reason?=outcome.reason tried "
    "ended",
    objects=lambda store: priced(store).prices,
    shown=(
        Column("case", scene),
        *plain("error=target:.0e", "engine"),
        Column("CPU s", _cost),
        Column("95 %", lambda price: bracketed(at(price, "reached.cost"), ".3g")),
        Column("x cheapest", "reached.ratio.value", ".3g"),
        Column("95 %", lambda price: bracketed(at(price, "reached.ratio"), ".3g")),
        Column("setting", lambda price: at(price, "outcome.at.track") or ""),
        Column("step", lambda price: "" if (met := price.reached) is None else step_in_words(met.at.dt, met.at.substeps)),
        Column("tried", _tried),
        Column("marks", _marks),
    ),
    sentences=_sentences,
    paper=(
        Titled("Case", Titles.scene),
        Column("Error", "target"),  # a share of the case's scale
        Titled("Engine", Titles.engine),
        Column("CPU time [ms/s]", _of_reached(lambda met: milli(met.cost.value))),  # CPU milliseconds a simulated second
        Column("95 % interval", _of_reached(lambda met: span(met.cost, 1e3))),
        Column("Times the cheapest", "reached.ratio.value"),
        Column("95 % interval", _of_reached(lambda met: span(met.ratio))),
        Column("Setting", lambda price: at(price, "outcome.at.track") or ""),
        Column("Time step [ms]", _of_reached(lambda met: milli(met.at.dt))),
        Column("Sub-steps", "reached.at.substeps"),
        Column("Price", lambda price: _WORDS.get(price.verdict, price.verdict)),
    ),
)
