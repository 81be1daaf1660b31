"""What it saves to leave out what a scene does not call for: a number for each engine, a mark for each scene."""

from collections.abc import Mapping, Sequence

from plumbline.harness.case.alteration import EVERYTHING
from plumbline.harness.findings.effects_audit import EffectVerdict
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure, tabled
from plumbline.reports.charts.grammar import Row, channel, chart, hovering
from plumbline.reports.charts.marks import POINT, Marks, decades, finished, logarithmic
from plumbline.reports.words.catalogue import cases, labels


def savings_chart(store: Store, verdicts: Sequence[EffectVerdict]) -> Figure | None:
    """The cost of everything on over that of each scene as it is, engine under engine; None where nothing was clocked."""
    rows: list[Row] = [
        {
            "engine": labels(store)[verdict.engine],
            "track": verdict.track,
            **dict(zip(("cost", "low", "high"), verdict.cost or (), strict=True)),
            "case": f"{cases(store)[verdict.case]['title']} {verdict.where}".strip(),
            "trial": verdict.trial,
        }
        for verdict in verdicts
        if verdict.verdict == EVERYTHING and verdict.cost is not None
    ]
    if not rows:
        return None
    style = Marks(store, rows)
    spread = [row[key] for row in rows for key in ("low", "high")]
    x = logarithmic("cost", "CPU time, everything on over the scene as it is", decades(spread))
    y = channel("engine:N", title=None, sort=style.engines, axis={"labelLimit": 210})
    tooltips = hovering(
        ("case:N", "scene"),
        "engine:N",
        ("cost:Q", "ratio", ".3~g"),
        ("low:Q", "95 % from", ".3~g"),
        ("high:Q", "to", ".3~g"),
        "trial:N",
    )
    shift = channel("case:N", scale={"paddingOuter": 0.2})
    layers = [
        chart(rows)
        .marked("rule", opacity=0.35)
        .encode(x=channel("low:Q"), x2="high:Q", y=y, yOffset=shift, color=style.colour()),
        chart(rows).marked("point", **POINT | {"size": 40}).encode(x=x, y=y, yOffset=shift, **style.channels(tooltips)),
    ]
    caption = "CPU time of a step with everything on, over that of the scene as it is: at 1 nothing is saved."
    how = (
        "A mark for each scene. Every other effect of the engine is present so faintly that it changes nothing but the work; "
        "both are clocked side by side. Bars are 95 % intervals."
    )
    table = tabled(rows, "engine", "scene=case", "ratio=cost", "95 % from=low", "to=high")
    # A line for each mark, and room between engines: as high as it needs to be, and no higher than a screen.
    height = min(420, 12 * len({row["case"] for row in rows}) * len(style.engines) + 30 * len(style.engines) + 20)
    return Figure("savings-ratio", "What everything on costs", caption, finished(layers, height), *table, how)


def matrix(store: Store, verdicts: Sequence[EffectVerdict]) -> list[tuple[str, str, Mapping[str, Sequence[EffectVerdict]]]]:
    """By scene (name, title) and engine, the verdicts that are worth a word: all but what is needed and on, or not and off."""
    quiet = ("needed and on", "left out", EVERYTHING, "left out together", "needed together")
    made: dict[tuple[str, str], dict[str, list[EffectVerdict]]] = {}
    for verdict in verdicts:
        title = cases(store)[verdict.case]["title"] + (f", {verdict.where}" if verdict.where else "")
        row = made.setdefault((verdict.case, title), {})
        if verdict.verdict not in quiet:
            row.setdefault(verdict.engine, []).append(verdict)
    return [(case, title, row) for (case, title), row in made.items() if row]
