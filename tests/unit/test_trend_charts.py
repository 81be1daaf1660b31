"""Charts of trends as data: a panel of two levels, a step and a new version, whose numbers all differ."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.findings.changes import Change
from plumbline.harness.history.readings import NightOf
from plumbline.harness.history.steps import PriceStep
from plumbline.harness.statistics.change_points import Level
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.marks import ENGINES
from plumbline.reports.charts.trends import TrendPanel, index_chart, miniature

INDEX = np.array([1.01, 0.99, np.nan, 1.31, 1.29, 0.71])
"""A night without a clock, a step on the night after it, and another version on the last one."""
LEVELS = (
    Level(first=0, last=1, value=1.0, low=0.9, high=1.1),
    Level(first=3, last=4, value=1.3, low=1.2, high=1.4),
    Level(first=5, last=5, value=0.7, low=0.6, high=0.8),
)
VERSIONS = ("3.3",) * 5 + ("3.4",)
NIGHTS = [
    NightOf(stamp=f"2026010{n}T020000Z", folder="", machine="m", processor="EPYC", versions={"mujoco": version, "dart": "6"})
    for n, version in enumerate(VERSIONS, 1)
]
STEP = PriceStep(night=3, change=Change(kind="price", sense="worse", engine="mujoco", ratio=1.3))
PANEL = TrendPanel(
    case="joint_chain",
    engine="mujoco",
    case_title="A chain",
    engine_title="MuJoCo",
    index=INDEX,
    segments=np.array([0, 0, -1, 0, 0, 1]),
    levels=LEVELS,
    steps=(STEP,),
    beside="canary",
    series=7,
    otherwise=((4, 1, 2),),
)


def drawn(*panels: TrendPanel) -> Figure:
    figure = index_chart(panels, NIGHTS, ENGINES, "title")
    assert figure is not None
    return figure


def rows_of(figure: Figure, mark: str) -> list[list[dict[str, Any]]]:
    layers = [layer for layer in figure.spec["layer"] if layer["mark"]["type"] == mark]
    return [figure.spec["datasets"][layer["data"]["name"]] for layer in layers]


def test_a_level_goes_on_to_the_next_one_so_that_a_step_is_upright() -> None:
    (line,) = rows_of(drawn(PANEL), "line")
    ends = [(row["night"][8:10], row["level"]) for row in line]
    assert ends == [("01", 1.0), ("04", 1.0), ("04", 1.3), ("06", 1.3), ("06", 0.7), ("06", 0.7)]
    assert [(row["low"], row["high"]) for row in line[::2]] == [(0.9, 1.1), (1.2, 1.4), (0.6, 0.8)]


def test_points_are_the_nights_that_were_clocked_with_the_version_of_each() -> None:
    (points,) = rows_of(drawn(PANEL), "point")
    assert [(row["night"][8:10], row["index"], row["version"]) for row in points] == [
        ("01", 1.01, "3.3"), ("02", 0.99, "3.3"), ("04", 1.31, "3.3"), ("05", 1.29, "3.3"), ("06", 0.71, "3.4"),
    ]  # fmt: skip


def test_a_step_and_a_new_version_stand_at_their_night() -> None:
    steps, segments = rows_of(drawn(PANEL), "rule")
    assert [(row["night"][8:10], row["what"]) for row in steps] == [("04", "MuJoCo: 1.3 times")]
    assert [(row["night"][8:10], row["what"]) for row in segments] == [("06", "MuJoCo 3.4")]


@pytest.mark.parametrize(("beside", "words"), [("canary", "over the canary"), ("other engines", "over other engines of the")])
def test_what_prices_were_divided_by_is_told(beside: Any, words: str) -> None:
    assert words in drawn(replace(PANEL, beside=beside)).caption


def test_each_of_two_engines_has_its_own_colour_and_mark() -> None:
    dart = replace(PANEL, engine="dart", engine_title="DART", index=2 * INDEX)
    (layer,) = [layer for layer in drawn(dart, PANEL).spec["layer"] if layer["mark"]["type"] == "point"]
    for channel, field in (("color", "colour"), ("shape", "path")):
        scale = layer["encoding"][channel]["scale"]
        assert dict(zip(scale["domain"], scale["range"], strict=True)) == {
            title: getattr(ENGINES[name], field) for name, title in (("mujoco", "MuJoCo"), ("dart", "DART"))
        }


@pytest.mark.parametrize(("ratio", "kind"), [(1.3, "worse"), (0.7, "better")])
def test_a_step_of_a_miniature_is_worse_where_the_price_rises(ratio: float, kind: str) -> None:
    panel = replace(PANEL, steps=(replace(STEP, change=replace(STEP.change, ratio=ratio)),))
    assert [sense for _, sense in miniature(panel, "#000000").steps] == [kind]


def test_a_miniature_has_its_levels_from_end_to_end_higher_where_the_price_is() -> None:
    small = miniature(PANEL, "#123456")
    ends = [end for *both, _ in small.levels for end in both]
    # Six nights between the frame's ends, 34 and 216: of 30.35 each.
    assert ends == pytest.approx([34 + 182 * night / 6 for night in (0, 2, 3, 5, 5, 6)], abs=0.1)
    heights = [height for *_, height in small.levels]
    assert heights[1] < heights[0] < heights[2]
    assert (small.colour, small.engine, len(small.segments), len(small.ticks)) == ("#123456", "MuJoCo", 1, 1)
