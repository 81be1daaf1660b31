"""What becomes of measurements: a verdict, its words, and the intervals of prices that are turned over."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from plumbline.cases import spin_heavy_top
from plumbline.harness.case import Case, Check, Converged, Parameters
from plumbline.harness.findings import speed
from plumbline.harness.findings.cost_point import CostPoint
from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metrics.errors import position_error_max
from plumbline.harness.metrics.periods import nutation_amplitude
from plumbline.harness.scene import Body, Scene
from plumbline.harness.statistics.bootstrap import ratio
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.record import Measurement
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trial.accuracy import _verdict, judge

SCENE = Scene(bodies=(Body(name="a"),))


def measured(value: float, at_most: float | None, passed: bool | None, unit: str = "m") -> Measurement:
    return Measurement(metric="gap", value=value, unit=unit, at_most=at_most, passed=passed, because="why")


def case(**fields: Any) -> Case:
    return Case(
        name="still",
        title="Still",
        question="Does it stand?",
        source="by hand",
        truth="rest",
        scene=lambda _: SCENE,
        duration=1.0,
        parameters=Parameters(),
        **fields,
    )


def still(off: float = 0.0) -> Trajectory:
    run = replace(Trajectory.of(np.arange(4) / 4, 1), dt=0.25)
    run.p_WB[2, 0, 0] = off
    return run


def test_a_trial_in_which_no_check_could_be_measured_has_not_passed() -> None:
    @metric("m")
    def blind(_run: Run) -> float:
        """nothing"""
        raise NotMeasurable("nothing is told")

    rows = judge(case(checks=(Check(blind, 1.0, "why"),)), SCENE, still(), None)
    assert [row.passed for row in rows] == [None]
    assert _verdict(rows) == ("unsupported", "not measurable: nothing is told")
    assert _verdict(()) == ("unsupported", "no check could be measured")


def test_what_is_no_number_passes_no_bound_that_the_truths_own_error_widens() -> None:
    truth = Converged(trajectory=still(), position_error=0.5, velocity_error=0.0)
    asked = case(checks=(Check(position_error_max, 1e-3, "why"),))
    assert [row.passed for row in judge(asked, SCENE, still(0.4), truth)] == [True]
    assert [row.passed for row in judge(asked, SCENE, still(0.6), truth)] == [False]

    @metric("m")
    def holed(run: Run) -> float:
        """of a finite run, against its truth"""
        assert len(run.truth)
        return float("nan")

    (row,) = judge(case(checks=(Check(holed, 1e-3, "why"),)), SCENE, still(), truth)
    assert row.truth_error == 0.5
    assert row.passed is False


def test_what_is_only_observed_keeps_the_unit_of_its_metric() -> None:
    @metric("rad/s")
    def spin(_run: Run) -> float:
        """three"""
        return 3.0

    (row,) = judge(case(checks=(), observe=(spin,)), SCENE, still(), None)
    assert (row.value, row.unit, row.at_most, row.passed) == (3.0, "rad/s", None, None)


@pytest.mark.parametrize(
    ("value", "bound", "said"),
    [
        (0.25, 0.1, "gap = 0.25 m, bound 0.1"),
        (0.9984, 0.998, "gap = 0.9984 m, bound 0.998"),
        (1.00004, 1.0, "gap = 1.00004 m, bound 1"),
        (np.nextafter(1.0, 2.0), 1.0, "gap = 1.0000000000000002 m, bound 1"),
        (float("nan"), 1.0, "gap = nan m, bound 1"),
    ],
)
def test_a_failure_is_told_in_as_many_digits_as_it_takes_to_see_it(value: float, bound: float, said: str) -> None:
    assert _verdict((measured(value, bound, passed=False),)) == ("failed", said)


def test_nutation_late_in_a_run_counts_as_much_as_early() -> None:
    top, time = spin_heavy_top.CASE, np.linspace(0.0, 2.0, 481)
    truth, fallen = (top.truth_at(time, {"tilt": tilt, "spin": 200.0}) for tilt in (30.0, 31.0))
    assert isinstance(truth, Trajectory)
    assert isinstance(fallen, Trajectory)
    for part in (slice(0, 20), slice(461, 481)):
        run = replace(truth, q_WB=truth.q_WB.copy())
        run.q_WB[part] = fallen.q_WB[part]
        assert nutation_amplitude(top.scene(top.parameters), run, truth) == pytest.approx(np.radians(1.0), rel=1e-6)


def test_a_ratio_is_the_median_of_ratios_and_no_ratio_of_medians() -> None:
    """A machine that slows down slows both of a block: 2, 4 and 5 over 1, 4 and 10 are 2, 1 and .5; medians 4 over 4 are 1."""
    found = ratio(np.array([2.0, 12.0, 5.0]), np.array([1.0, 4.0, 10.0]))
    assert found.value == 2.0
    assert found.low <= found.value <= found.high


def test_a_speed_has_its_lower_end_from_the_dearer_end_of_the_price(monkeypatch: pytest.MonkeyPatch) -> None:
    point: Any = SimpleNamespace(
        case="x", engine="e", track="tuned", dt=0.01, substeps=1, error=1e-4, cost=Interval(0.5, 0.4, 0.8),
        clocked=True, status="passed", unstable=False, trial="t",
    )  # fmt: skip
    assert CostPoint.__dataclass_fields__["cost"].type is Interval
    monkeypatch.setattr(
        speed, "List", lambda *_: SimpleNamespace(middle=np.full((1, 1), np.nan))
    )  # one run: no steps on both sides
    of_one: Any = speed._speed([point], SimpleNamespace(), 1e-3, 0.01)  # type: ignore[arg-type]
    assert of_one.times == Interval(2.0, 1.25, 2.5)
