"""Error against speed of each engine over the cases of a run: the picture of the first page."""

from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.grammar import Row, chart, hovering
from plumbline.reports.charts.marks import POINT, Marks, decades, finished, logarithmic
from plumbline.reports.tables.selection import answer
from plumbline.reports.words.catalogue import cases, labels, setting_words
from plumbline.reports.words.text import amount, visible

LEAST = 1e-6
"""Share of the scale: what errs less stands here, since a ratio of rounding errors says nothing."""
ERROR, SPEED = "error, as a share of the case's scale", "times real time"


def error_against_speed(store: Store) -> Figure | None:
    """A small mark for each engine and case, a large one at its figures over all; None where no engine has a speed."""
    evidence = answer(store).evidence
    rows: list[Row] = [
        {
            "engine": labels(store)[engine],
            "track": evidence.tracks[engine],
            "setting": visible(setting_words(store, engine, evidence.tracks[engine]))[:60],
            "case": visible(str(cases(store)[case]["title"]))[:60],
            "error": max(speed.error, LEAST),
            "pace": speed.times,
            "step": speed.step or "at the error asked for",
        }
        for (case, engine), speed in evidence.speeds.items()
        if engine in evidence.engines
    ]
    if not rows:
        return None
    over_all: list[Row] = []
    for engine in evidence.engines:
        error, pace = evidence.error(engine), evidence.speed(engine)
        if error is not None and pace is not None:
            mine = next(row for row in rows if row["engine"] == labels(store)[engine])
            over_all.append(mine | {"error": max(error, LEAST), "pace": pace, "case": "all cases", "step": ""})
    style = Marks(store, rows)
    x = logarithmic("error", ERROR, decades(row["error"] for row in rows))
    y = logarithmic("pace", SPEED, decades(row["pace"] for row in rows))
    shown = hovering("engine:N", "setting:N", "case:N", ("error:Q", ERROR, ".2~g"), ("pace:Q", SPEED, ".3~g"), "step:N")
    channels = style.channels() | {"tooltip": shown, "x": x, "y": y}
    layers = [
        chart([{"error": 0.01}]).marked("rule", strokeDash=[4, 4], color="#8a93a0").encode(x=x),
        chart(rows).marked("point", **POINT | {"size": 34, "opacity": 0.4}).encode(**channels),
        chart(over_all).marked("point", **POINT | {"size": 330}).encode(**channels),
    ]
    cells = [
        [*(row[key] for key in ("engine", "setting", "case")), amount(row["error"]), amount(row["pace"]), row["step"]]
        for row in [*over_all, *rows]
    ]
    caption = "Up is faster, left is more accurate. Large: all cases together. Small: each case. Dashed: 1 % error."
    how = (
        "A speed is the one at 1 % error if steps on both sides of it were run, else that of the cheapest run that passes "
        "every check of its case. All together: the geometric mean of speeds over the cases in which the engines have "
        "one, and the median of errors. Errors below a millionth of the scale stand there."
    )
    columns = ("engine", "setting", "case", "error", SPEED, "speed taken")
    return Figure("error-and-speed", "Error against speed", caption, finished(layers, height=300), columns, cells, how)
