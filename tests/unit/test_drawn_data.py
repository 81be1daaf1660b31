"""Pages as data: which engine, which field, which axis and which ends, over engines whose numbers all differ."""

from typing import Any

import pytest

from plumbline.harness.findings.tables.orders import ObservedOrder
from plumbline.harness.statistics.order import Order
from plumbline.reports.charts.marks import ENGINES
from plumbline.reports.charts.work_precision import miniatures, work_precision
from plumbline.reports.pages.case import orders
from plumbline.reports.tables.price_list import scenes
from tests.unit.test_prices import Priced, ladder

LADDERS = {"mujoco": (1e-3, 1e-3), "dart": (3e-3, 1e-2), "bullet": (2e-4, 3e-2)}
"""Cost at a step of 1 s and finest step: in no order of the alphabet, and of 4, 3 and 2 steps."""


@pytest.fixture(scope="module")
def store() -> Priced:
    """Each price with an interval that is wider above than below."""
    told = [line for name, (cost, finest) in LADDERS.items() for line in ladder("a", name, cost, finest=finest)]
    priced = Priced(told)
    trials = priced.trials
    trials["cpu_low"] = trials["cpu_per_sim_s"] * 0.9
    trials["cpu_high"] = trials["cpu_per_sim_s"] * 1.3
    return priced


def test_each_engine_has_its_own_colour_and_each_field_its_own_axis(store: Priced) -> None:
    (scene,) = scenes(store)
    figure = work_precision(store, scene)
    drawn = [layer for layer in figure.spec["layer"] if layer["mark"]["type"] == "point" and "shape" in layer["encoding"]]
    assert drawn
    for layer in drawn:
        encoding: dict[str, Any] = layer["encoding"]
        colours = dict(zip(encoding["color"]["scale"]["domain"], encoding["color"]["scale"]["range"], strict=True))
        assert colours == {name: ENGINES[name].colour for name in LADDERS}
        shapes = dict(zip(encoding["shape"]["scale"]["domain"], encoding["shape"]["scale"]["range"], strict=True))
        assert shapes == {name: ENGINES[name].path for name in LADDERS}
        assert (encoding["x"]["field"], encoding["x"]["scale"]["type"]) == ("error", "log")
        assert (encoding["y"]["field"], encoding["y"]["scale"]["type"]) == ("pace", "log")
        assert encoding["y"]["title"] == "times real time"
        for row in figure.spec["datasets"][layer["data"]["name"]]:
            cost, _ = LADDERS[row["engine"]]
            dt = (2 * row["error"]) ** 0.5
            assert row["cost"] == pytest.approx(cost / dt)
            assert row["pace"] == pytest.approx(dt / cost)


def test_bars_reach_from_the_slower_end_to_the_faster_end(store: Priced) -> None:
    (scene,) = scenes(store)
    figure = work_precision(store, scene)
    bars = [layer for layer in figure.spec["layer"] if layer["mark"]["type"] == "rule" and "y2" in layer["encoding"]]
    assert [(bar["encoding"]["y"]["field"], bar["encoding"]["y2"]["field"]) for bar in bars] == [("slow", "fast")]
    for row in figure.spec["datasets"][bars[0]["data"]["name"]]:
        assert row["slow"] == pytest.approx(row["pace"] / 1.3)
        assert row["fast"] == pytest.approx(row["pace"] / 0.9)


def test_a_cost_that_is_not_per_simulated_second_is_drawn_as_a_cost() -> None:
    told = [line for name, (cost, finest) in LADDERS.items() for line in ladder("a", name, cost, finest=finest)]
    (scene,) = scenes(store := Priced(told, unit="ray"))
    figure = work_precision(store, scene)
    points = [layer for layer in figure.spec["layer"] if layer["mark"]["type"] == "point" and "shape" in layer["encoding"]]
    assert {layer["encoding"]["y"]["field"] for layer in points} == {"cost"}
    assert {layer["encoding"]["y"]["title"] for layer in points} == {"CPU time per ray [s]"}


def test_the_line_of_a_miniature_is_in_the_colour_of_the_engine_whose_front_it_is(store: Priced) -> None:
    """Fronts have as many points as their ladders have steps, and a dearer engine lies lower at the same error."""
    (miniature,) = miniatures(store)
    by_colour = {colour: places for colour, _, places in miniature.lines}
    assert {colour: len(places) for colour, places in by_colour.items()} == {
        ENGINES["mujoco"].colour: 4,
        ENGINES["dart"].colour: 3,
        ENGINES["bullet"].colour: 2,
    }
    coarsest = {name: max(by_colour[ENGINES[name].colour]) for name in LADDERS}
    assert len({across for across, _ in coarsest.values()}) == 1
    heights = {name: height for name, (_, height) in coarsest.items()}
    assert heights["bullet"] < heights["mujoco"] < heights["dart"], "pixels count from the top: up is faster"


def test_orders_stand_with_their_own_engine_and_track_in_the_order_of_the_page() -> None:
    def ladder_of(engine: str, track: str, order: float) -> ObservedOrder:
        fit = Order(
            order=order,
            low=order - 0.1,
            high=order + 0.1,
            floor=None,
            used=4,
            coarse=0.1,
            fine=0.01,
            at_fine_end=order,
            left=0.0,
        )
        return ObservedOrder(
            case="a", where="", engine=engine, track=track, metric="e", integrator="x", fit=fit, promised=1,
            verdict="kept", finding="",
        )  # fmt: skip

    rows = [ladder_of("bullet", "tuned", 1.1), ladder_of("mujoco", "default", 1.2), ladder_of("mujoco", "tuned", 4.0)]
    sides = [("mujoco", "tuned"), ("mujoco", "default"), ("bullet", "tuned")]
    listed = orders(rows, sides)
    assert [(row.engine, row.track, row.fit.order) for row in listed if row.fit is not None] == [
        ("mujoco", "tuned", 4.0),
        ("mujoco", "default", 1.2),
        ("bullet", "tuned", 1.1),
    ]
