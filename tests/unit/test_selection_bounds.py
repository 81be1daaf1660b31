"""Selection with prices that are only bounds: a bound wins what it shows, loses what it shows, and leaves the rest open."""

import math
from pathlib import Path

import pytest

from plumbline.harness.findings.selection import Answer, Wish, choose
from plumbline.harness.findings.selection.evidence import Datum
from plumbline.harness.findings.selection.words import undecided_sentence
from plumbline.harness.store.store import Store
from tests.run_folder import LADDER
from tests.selection_folder import Made, write_selection_folder

PRICE_ALONE = {"accuracy": 0.0, "robustness": 0.0, "capability": 0.0}
COARSEST = 240 * max(LADDER)
"""Times the step at which made errors and costs are given."""


def bound(cost: float) -> Made:
    """An engine whose coarsest step errs less than is asked for: it costs at most `cost` [CPU s a simulated second] there."""
    return Made(error=0.1 / COARSEST, cost=cost * COARSEST)


def exact(cost: float) -> Made:
    """An engine whose price of the error asked for is `cost`: it is met at half of the step at which it errs twice that."""
    return Made(error=2.0, cost=cost / 2)


def answer(folder: Path, engines: dict[str, Made], weights: dict[str, float] = PRICE_ALONE, **wish: float) -> Answer:
    store = Store(write_selection_folder(folder, engines, 0, noise=0.0))
    return choose(store, Wish(weights=weights, **wish), draws=500)  # type: ignore[arg-type]


def places(found: Answer) -> dict[str, int]:
    assert found.rank is not None
    return {place.engine: place.number for place in found.rank.places}


def prices(found: Answer) -> dict[str, Datum]:
    return {engine: datum for (criterion, case, engine), datum in found.evidence.table.items() if case == "joint_pendulum"
            and criterion == "price"}  # fmt: skip


def test_a_bound_below_a_price_wins_by_what_it_shows(tmp_path: Path) -> None:
    found = answer(tmp_path, {"mujoco": bound(0.01), "dart": exact(0.1)})
    assert places(found) == {"mujoco": 1, "dart": 2}
    # Ten times the price is half of the way to no use, by the logarithm over two decades.
    assert prices(found)["mujoco"].value == 1.0
    assert prices(found)["dart"].value == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("times", [10.0, *(pytest.param(times, marks=pytest.mark.slow) for times in (1.5, 1000.0))])
def test_a_bound_above_a_price_loses_nothing_by_it(tmp_path: Path, times: float) -> None:
    found = answer(tmp_path, {"mujoco": bound(0.1 * times), "dart": exact(0.1)})
    assert places(found) == {"mujoco": 1, "dart": 1}
    datum = prices(found)["mujoco"]
    assert datum.bounded
    assert datum.says.startswith("at least ")
    assert (datum.low, datum.high) == pytest.approx((max(0.0, 1 - math.log10(times) / 2), 1.0), abs=0.01)


def test_a_bound_above_a_price_wins_nothing_from_a_third(tmp_path: Path) -> None:
    """It is level with one that costs less than it shows and with one that costs more than that, but less than it shows too."""
    found = answer(tmp_path, {"mujoco": bound(1.0), "dart": exact(0.1), "bullet": exact(0.5)})
    assert set(places(found).values()) == {1}
    beyond = answer(tmp_path / "beyond", {"mujoco": bound(0.2), "dart": exact(0.1), "bullet": exact(2.0)})
    assert places(beyond) == {"mujoco": 1, "dart": 1, "bullet": 3}


def test_of_two_bounds_neither_is_ahead_and_each_wins_no_more_than_the_larger_shows(tmp_path: Path) -> None:
    found = answer(tmp_path, {"mujoco": bound(0.001), "bullet": bound(0.02), "dart": exact(0.1)})
    assert places(found) == {"mujoco": 1, "bullet": 1, "dart": 3}
    assert found.rank is not None
    assert {place.engine: place.first for place in found.rank.places} == {"mujoco": 0.5, "bullet": 0.5, "dart": 0.0}
    assert prices(found)["dart"].value == pytest.approx(1 - math.log10(5) / 2, abs=0.01)
    alone = answer(tmp_path / "alone", {"mujoco": bound(0.001), "bullet": bound(5.0)})
    assert set(places(alone).values()) == {1}


def test_what_does_not_come_to_the_error_is_behind_a_bound(tmp_path: Path) -> None:
    found = answer(tmp_path, {"mujoco": bound(5.0), "dart": Made(error=1e4, cost=0.001)})
    assert places(found) == {"mujoco": 1, "dart": 2}


def test_a_bound_leaves_open_whether_a_pace_is_kept(tmp_path: Path) -> None:
    found = answer(tmp_path, {"mujoco": bound(0.2), "dart": exact(0.1), "bullet": exact(0.01)}, realtime=20.0)
    assert [drop.engine for drop in found.dropped] == ["dart"]
    assert [drop.engine for drop in found.undecided] == ["mujoco"]
    said = undecided_sentence(found.undecided[0], str, str)
    assert said.startswith("Of mujoco it is not known whether it has 20 times real time in ")
    assert "at least 5 times" in said


def test_a_bound_alone_never_turns_who_leads(tmp_path: Path) -> None:
    """A price that counts double would put one first that is known by a bound only, by the middle of what it leaves open."""
    weights = {"accuracy": 1.0, "price": 1.0, "robustness": 0.0, "capability": 0.0}
    found = answer(tmp_path, {"mujoco": bound(0.3), "dart": exact(0.1), "bullet": exact(4.0)}, weights)
    assert not [turn for turn in found.turns if turn.first == "dart"]
