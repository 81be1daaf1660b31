"""Charts: every trial is on them, as a point, at an edge or as an outcome, and in the table below."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pandas as pd
import pytest

from plumbline.harness.store.store import Store
from plumbline.reports.charts.compact import SCRIPTED, shown_rows
from plumbline.reports.charts.errors import across_cases, error_by_step, points
from plumbline.reports.charts.figure import POINTS, Figure, thin
from plumbline.reports.charts.marks import ENGINES, decades
from plumbline.reports.tables.trial_results import answers, at_own_step
from tests.charts import specs
from tests.run_folder import BAD_CASE, CASES, write_run_folder


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(write_run_folder(tmp_path_factory.mktemp("charts") / "run", hostile=True))


def layers(figure: Figure, mark: str) -> Iterator[dict[str, Any]]:
    return (one for one in figure.spec["layer"] if one["mark"]["type"] == mark)


def rows_of(figure: Figure, layer: dict[str, Any]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = figure.spec["datasets"][layer["data"]["name"]]
    return found


def drawn(store: Store, figure: Figure, marks: tuple[str, ...] = ("point", "text")) -> list[str]:
    """Trials that stand on a chart as a mark."""
    names = [row.get("trial", "") for mark in marks for one in layers(figure, mark) for row in rows_of(figure, one)]
    return [name for name in names if name]


@pytest.mark.parametrize("case", [*CASES, BAD_CASE])
def test_every_trial_of_a_case_stands_on_its_chart_of_errors_once(store: Store, case: str) -> None:
    rows = answers(store)
    rows = rows[rows["case"] == case]
    figure = error_by_step(store, rows, "any", "e", "m")
    assert figure is not None
    assert sorted(drawn(store, figure)) == sorted(rows["trial"])
    assert len(figure.rows) == len(rows)


def test_an_exact_answer_stands_on_the_lower_edge(store: Store) -> None:
    rows = answers(store)
    by_step = error_by_step(store, rows[rows["case"] == "flight_projectile"], "any", "e", "m")
    assert by_step is not None
    exact = [one for one in layers(by_step, "point") if one["encoding"]["y"] == {"value": "height"}]
    assert [row["engine"] for one in exact for row in rows_of(by_step, one)] == ["Plumbline reference (ours)"] * 4


def test_the_seeds_of_one_setting_are_joined_by_their_range_and_their_median(store: Store) -> None:
    rows = answers(store)
    rows = rows[(rows["case"] == "rest_table") & (rows["engine"] == "mujoco") & (rows["track"] == "tuned")].head(1)
    seeds = pd.concat([rows.assign(seed=k, error=error, trial=f"t{k}") for k, error in enumerate((1.0, 2.0, 9.0))])
    figure = error_by_step(store, seeds, "any", "e", "m")
    assert figure is not None
    (span,) = [row for one in layers(figure, "rule") for row in rows_of(figure, one)]
    (middle,) = [row for one in layers(figure, "line") for row in rows_of(figure, one)]
    assert (span["least"], span["most"], middle["error"]) == (1.0, 9.0, 2.0)
    assert sorted(drawn(store, figure)) == ["t0", "t1", "t2"]


def test_points_carry_no_number_that_json_lacks(store: Store) -> None:
    for row in points(store, answers(store)):
        json.dumps(row, allow_nan=False)


def test_an_engine_has_its_colour_and_shape_in_every_chart(store: Store) -> None:
    rows = answers(store)
    for case in ("joint_chain", "rest_table"):
        figure = error_by_step(store, rows[rows["case"] == case], "any", "e", "m")
        assert figure is not None
        for one in layers(figure, "point"):
            colour, shape = one["encoding"]["color"]["scale"], one["encoding"]["shape"]["scale"]
            place = colour["domain"].index("DART")
            assert colour["range"][place] == ENGINES["dart"].colour
            assert shape["range"][place] == ENGINES["dart"].path


def test_failures_stand_beside_the_charts_across_cases(store: Store) -> None:
    own = at_own_step(store, answers(store))
    figure = across_cases(store, own, "error", "any", "e", "c")
    assert figure is not None
    beside = [row for one in layers(figure, "text") for row in rows_of(figure, one)]
    assert ("Box resting on an incline", "Bullet", "∅") in {(row["case"], row["engine"], row["symbol"]) for row in beside}
    newton = [row for row in beside if row["engine"] == "Newton"]
    assert len(newton) == 2 * len(CASES)


def test_exact_answers_stand_on_the_left_edge_across_cases(store: Store) -> None:
    rows = answers(store)
    rows = rows[rows["dt"] == 1 / 1920]
    figure = across_cases(store, rows, "error", "any", "e", "c")
    assert figure is not None
    exact = [one for one in layers(figure, "point") if one["encoding"]["x"] == {"value": 0}]
    assert {(row["case"], row["engine"]) for one in exact for row in rows_of(figure, one)} == {
        ("Thrown body", "Plumbline reference (ours)")
    }


def test_no_chart_is_drawn_of_nothing(store: Store) -> None:
    rows = answers(store)
    assert error_by_step(store, rows.iloc[:0], "any", "e", "m") is None


def test_the_static_picture_is_whole_xml_without_a_script(store: Store) -> None:
    rows = answers(store)
    figure = error_by_step(store, rows[rows["case"] == BAD_CASE], "any", "</svg><script>", "m")
    assert figure is not None
    tree = ElementTree.fromstring(figure.svg)
    names = {node.tag.rpartition("}")[2].lower() for node in tree.iter()}
    assert "path" in names
    assert not names & {"script", "foreignobject", "a", "image", "iframe"}
    assert not [key for node in tree.iter() for key in node.attrib if key.lower().startswith("on")]


def test_thinning_keeps_the_extremes_and_the_limit() -> None:
    rows = [{"x": float(k), "y": float(k % 97)} for k in range(10_000)]
    rows[5_000]["y"] = 1e9
    rows[7_000]["y"] = -1e9
    kept = thin(rows, "x", "y")
    assert len(kept) <= POINTS
    assert rows[5_000] in kept
    assert rows[7_000] in kept
    assert [row["x"] for row in kept] == sorted(row["x"] for row in kept)


def test_a_short_series_is_not_thinned() -> None:
    rows = [{"x": float(k), "y": 1.0} for k in range(POINTS)]
    assert thin(rows, "x", "y") == rows


@pytest.mark.parametrize(
    ("numbers", "first", "last"), [([0.3], 0.1, 9.0), ([1e-12, 1.0], 1e-12, 1.0), ([2e-3, 8e-2], 1e-3, 0.5)]
)
def test_ticks_stand_at_round_numbers_around_the_values(numbers: list[float], first: float, last: float) -> None:
    values = decades(numbers)["values"]
    assert min(values) == pytest.approx(first)
    assert max(values) == pytest.approx(last)
    assert len(values) <= 18


@pytest.mark.parametrize(("low", "high"), [(0.67, 1.0), (0.96, 1.17), (1.9, 2.6), (41.2, 43.9), (9.5e-5, 1.02e-4)])
def test_a_chart_within_one_decade_has_several_ticks_inside(low: float, high: float) -> None:
    ticks = decades([low, high])
    assert sum(low <= value <= high for value in ticks["values"]) >= 3
    labels = json.loads(ticks["labelExpr"].split("[indexof")[0])
    assert len(set(labels)) == len(ticks["values"])


def test_the_text_of_a_figure_is_the_same_in_two_builds(store: Store, tmp_path: Path) -> None:
    again = Store(write_run_folder(tmp_path / "run", hostile=True))
    texts = []
    for one in (store, again):
        rows = answers(one)
        figure = error_by_step(one, rows[rows["case"] == "stack_tower"], "any", "e", "m")
        assert figure is not None
        texts.append(json.dumps(figure.spec))
    assert texts[0] == texts[1]


def test_a_page_says_each_word_of_two_charts_of_the_same_trials_once(store: Store) -> None:
    """What the page's script reads is what is drawn: words as they are, numbers to the digits that a chart or a hover shows."""
    own = at_own_step(store, answers(store))
    errors = across_cases(store, own, "error", "errors", "e", "c")
    paces = across_cases(store, own, "pace", "paces", "p", "c")
    assert errors is not None
    assert paces is not None
    pair = (errors, replace(paces, after=errors))
    page = "".join(
        f'<figure class="chart" id="{one.name}"><script type="application/json" class="spec">{one.shown}</script></figure>'
        for one in pair
    )
    first, second = (json.loads(one.shown)["words"] for one in pair)
    assert len({*first, *second}) == len(first) + len(second)
    assert not second or len(second) < len(json.loads(paces.shown)["words"])
    for one, shown in zip(pair, specs(page), strict=True):
        drawn_field = "error" if one is errors else "pace"
        for name, rows in shown_rows(one.spec, SCRIPTED).items():
            for given, read in zip(rows, shown["datasets"][name], strict=True):
                assert given.keys() == read.keys()
                for field, value in given.items():
                    close = 5e-6 if field == drawn_field else 5e-3
                    assert read[field] == (pytest.approx(value, rel=close) if isinstance(value, float) else value), field
                    if isinstance(value, float):
                        assert f"{read[field]:.3g}" == f"{value:.3g}"
