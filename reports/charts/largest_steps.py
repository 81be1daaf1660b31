"""The largest time steps: a chart over all scenes, and default and tuned beside each other, scene by scene, as a table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter

from plumbline.harness.findings.tables.steps import StepRange
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure, tabled
from plumbline.reports.charts.grammar import Row, channel, chart, hovering
from plumbline.reports.charts.marks import POINT, SHARES, TRACKS, Marks, decades, finished, logarithmic
from plumbline.reports.words.catalogue import engines, labels, titled
from plumbline.reports.words.text import amount


@dataclass(frozen=True, slots=True)
class LargestSteps:
    """How far one engine may step in one scene: on each track, and where it is fastest."""

    case: str
    title: str
    engine: str
    tracks: Mapping[str, StepRange]
    fastest: StepRange | None


def allowances(store: Store, steps: Sequence[StepRange]) -> list[LargestSteps]:
    """Steps of one scene and engine in one row, engines in their usual order within a scene."""
    scenes = list(dict.fromkeys((step.case, step.where) for step in steps))
    order = list(engines(store))
    ordered = sorted(steps, key=lambda step: (scenes.index((step.case, step.where)), order.index(step.engine)))
    return [
        LargestSteps(
            case=case,
            title=titled(store, case, where),
            engine=engine,
            tracks={step.track: step for step in mine if step.track in TRACKS},
            fastest=max((step for step in mine if step.realtime), key=lambda step: step.realtime or 0.0, default=None),
        )
        for (case, where, engine), mine in grouped(ordered, attrgetter("case", "where", "engine")).items()
    ]


def survival(steps: Sequence[StepRange]) -> list[tuple[float, float, int]]:
    """The share of scenes that are still within one per cent at a time step, one row a scene.

    Returns:
        By time step [s]: the share, and how many scenes still say something of it.

    Source: E. L. Kaplan & P. Meier, J. Am. Stat. Assoc. 53 (1958) 457; a scene good at its coarsest step is censored there.
    """
    share, curve = 1.0, []
    for dt in sorted({step.accurate or 0.0 for step in steps}):
        left = sum((step.accurate or 0.0) >= dt for step in steps)
        if dt > 0:
            curve.append((dt, share, left))
        ended = sum((step.accurate or 0.0) == dt and step.accurate != step.coarsest for step in steps)
        share *= 1 - ended / left
    return curve


def steps_chart(store: Store, steps: Sequence[StepRange]) -> Figure | None:
    """The share of scenes within one per cent over the time step, default and tuned; None where nothing stays within it."""
    rows: list[Row] = []
    for engine, track in dict.fromkeys((step.engine, step.track) for step in steps if step.track in TRACKS):
        mine = [step for step in steps if (step.engine, step.track) == (engine, track)]
        same = {"engine": labels(store)[engine], "track": track, "series": f"{engine} {track}"}
        rows += [same | {"dt": 1e3 * dt, "share": share, "run": run} for dt, share, run in survival(mine)]
    if not rows:
        return None
    style = Marks(store, rows)
    x = logarithmic("dt", "time step [ms]", decades(row["dt"] for row in rows))
    scale = {"domain": [0, 1], "nice": False, "padding": 6}
    y = channel("share:Q", title="share of the scenes within 1 %", scale=scale, axis=SHARES)
    tooltips = hovering("engine:N", "track:N", ("dt:Q", "time step [ms]", ".3~g"))
    tooltips += hovering(("share:Q", "", ".1%"), ("run:Q", "scenes left"))
    line = chart(rows).marked("line", strokeWidth=1.6, interpolate="step-before")
    layers = [
        line.encode(x=x, y=y, detail="series:N", color=style.colour(), strokeDash=style.dash()),
        chart(rows).marked("point", **POINT | {"size": 45}).encode(x=x, y=y, **style.channels(tooltips)),
    ]
    caption = "Higher and farther right is better: an engine that may take larger steps."
    how = (
        "The share of the scenes in which an engine stays within one per cent of the case's scale at a time step and at every "
        "smaller one that was run. A scene that is still within it at its coarsest step "
        "says nothing of coarser ones and counts up to there (Kaplan and Meier). Whole lines and filled marks are tuned, "
        "dashes and open ones the vendor's defaults."
    )
    spec = finished(layers, height=320)
    share = ("share", lambda row: f"{amount(100 * row['share'])} %")
    table = tabled(rows, "engine", "track", "time step [ms]=dt", share, "scenes left=run")
    return Figure("largest-steps", "Share of scenes within 1 % against time step", caption, spec, *table, how)
