"""What charts are said in is what Altair writes for the same words, and equal rows travel once."""

from typing import Any

import altair as alt
import pytest

from plumbline.reports.charts.grammar import Chart, channel, chart, fixed, layered

ROWS: list[dict[str, Any]] = [{"a": 1.0, "b": 2.0, "top": 3.0, "who": "x"}, {"a": 2.0, "b": None, "top": 4.0, "who": "y"}]
LOG: dict[str, Any] = {"type": "log", "nice": False, "padding": 14}


def points() -> tuple[Chart, Any]:
    scale: dict[str, Any] = {"domain": ["x", "y"], "range": ["#000", "#fff"]}
    said = chart(ROWS).marked("point", filled=True, size=70)
    ours = said.encode(
        x=channel("a:Q", title="of a", scale=LOG, axis={"values": [1, 2]}),
        y=channel("b:Q", scale=None, axis=None),
        color=channel("who:N", title=None, scale=scale, legend={}),
        tooltip=[channel("who:N", title="who"), channel("b:Q", format=".3~g")],
        detail="who:N",
    )
    theirs = alt.Chart({"values": ROWS}).mark_point(filled=True, size=70)
    theirs = theirs.encode(
        x=alt.X("a:Q", title="of a", scale=alt.Scale(**LOG), axis=alt.Axis(values=[1, 2])),
        y=alt.Y("b:Q", scale=None, axis=None),
        color=alt.Color("who:N", title=None, scale=alt.Scale(**scale), legend=alt.Legend()),
        tooltip=[alt.Tooltip("who:N", title="who"), alt.Tooltip("b:Q", format=".3~g")],
        detail="who:N",
    )
    return ours, theirs


def bars() -> tuple[Chart, Any]:
    ours = chart(ROWS[:1]).marked("rule", strokeWidth=1.4)
    theirs = alt.Chart({"values": ROWS[:1]}).mark_rule(strokeWidth=1.4)
    return (
        ours.encode(x=fixed("width"), y=channel("b:Q", title="b"), y2="top:Q", yOffset=channel("who:N")),
        theirs.encode(x=alt.value("width"), y=alt.Y("b:Q", title="b"), y2="top:Q", yOffset=alt.YOffset("who:N")),
    )


def words() -> tuple[Chart, Any]:
    ours, theirs = chart([]).marked("text", dx=-8), alt.Chart({"values": []}).mark_text(dx=-8)
    return ours.encode(x=fixed(0), text="who:N", y="a:T"), theirs.encode(x=alt.value(0), text="who:N", y="a:T")


@pytest.mark.parametrize("kinds", [(points,), (points, bars), (bars, words, points, points)], ids=len)
def test_layers_are_those_that_altair_writes(kinds: Any) -> None:
    pairs = [kind() for kind in kinds]
    ours = layered([one for one, _ in pairs], width="container", height=300)
    theirs = alt.layer(*(other for _, other in pairs)).properties(width="container", height=300).to_dict()
    del theirs["config"]
    assert ours == theirs


def test_equal_rows_travel_once() -> None:
    assert len(layered([points()[0], points()[0], bars()[0]])["datasets"]) == 2


def test_a_field_without_a_kind_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="channel 'who': expected a field and its kind"):
        channel("who")
