"""The price list, the profile and the largest steps on stores written by hand, whose rows are known."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from plumbline.harness.findings.columns import at
from plumbline.harness.findings.prices import Prices, interval, medians
from plumbline.harness.findings.tables import price as price_table
from plumbline.harness.findings.tables.profile import FACTOR, TABLE, SceneName, hinges, profile, without
from plumbline.harness.findings.tables.steps import largest_steps
from plumbline.harness.search.front import spread
from plumbline.harness.statistics.bootstrap import ratio
from plumbline.harness.statistics.pareto import price
from plumbline.harness.store.store import Store
from plumbline.reports.charts.work_precision import drawn
from tests.run_folder import row, untimed

Told = tuple[str, str, str, float, float, float | None]
"""case, engine, track, dt, error, cost; a trial without a cost was not clocked."""


class Priced(Store):
    """A store whose trials are told in a line each; every case has the same scale, and its truth may be off by as much."""

    def __init__(self, told: list[Told], unit: str = "step", rough: float = 1.0, scale: float = 1.0, off: float = 0.0) -> None:
        self.folder = Path("run")
        trials, measured, samples = [], [], []
        for case, engine, track, dt, error, cost in told:
            trial = row(case, engine, track, dt, parameters="{}", unit=unit, rough_cost=rough)
            name = trial["trial"]
            if cost is None:
                trial |= untimed()
            elif unit == "step":
                trial |= {"cpu_per_sim_s": cost, "cpu_low": cost, "cpu_high": cost}
            else:
                trial |= {"cpu_per_unit": cost, "cpu_per_unit_low": cost, "cpu_per_unit_high": cost}
            trials.append(trial)
            measured.append({"trial": name, "metric": "e", "value": error, "unit": "m", "at_most": 1.0, "truth_error": off})
            samples += [
                {"trial": name, "process": 0, "block": k, "steps": 1, "units": 1, "cpu": cost} for k in range(3) if cost
            ]
        self.__dict__["_read"] = {
            "trials": pd.DataFrame(trials).astype({"unstable_timing": "boolean"}),
            "measurements": pd.DataFrame(measured).assign(passed=True, because=""),
            "samples": pd.DataFrame(samples, columns=["trial", "process", "block", "steps", "units", "cpu", "canary"]),
        }
        cases = {case: {"title": case, "headline": "e", "scale": scale, "dt": 0.01, "parameters": {}} for case, *_ in told}
        engines = {engine: {"title": engine, "ours": engine == "reference"} for _, engine, *_ in told}
        self.__dict__["catalogue"] = json.loads(json.dumps({"cases": cases, "engines": engines}))
        self.__dict__["machine"] = self.__dict__["study"] = {}


def ladder(case: str, engine: str, cost: float, *, finest: float = 1e-3, track: str = "tuned") -> list[Told]:
    """Second order down to the finest step, of which each decade costs ten times the one before."""
    steps = [dt for dt in (1e-1, 3e-2, 1e-2, 1e-3) if dt >= finest]
    return [(case, engine, track, dt, 0.5 * dt**2, cost / dt) for dt in steps]


def test_an_unclocked_answer_is_not_one_that_was_never_reached() -> None:
    told = [*ladder("a", "dart", 1.0, finest=1e-2), ("a", "dart", "tuned", 1e-3, 1e-6, None)]
    rows = {round(-math.log10(p.target)): p for p in Prices(Priced(told, rough=7.0)).prices}
    assert rows[4].verdict == "priced"
    assert (rows[5].verdict, at(rows[5], "outcome.reason"), at(rows[5], "outcome.at.dt")) == (
        "not clocked",
        "roughly 7 CPU s",
        1e-3,
    )
    assert rows[5].reached is None
    assert rows[7].verdict == "not within the ladder"


def test_an_error_below_the_ladder_is_foreseen_where_a_trend_leads_to_it() -> None:
    """Of .5 dt^2 down to 1e-3 s: 1e-8 is met at the root of 2e-8 s, and three decades of an order are no interval."""
    rows = {round(-math.log10(p.target)): p for p in Prices(Priced(ladder("a", "dart", 1.0))).prices}
    assert rows[6].verdict == "priced"
    assert (rows[8].verdict, at(rows[8], "finest.dt"), at(rows[8], "best.error")) == (
        "not within the ladder",
        1e-3,
        pytest.approx(5e-7),
    )
    assert (at(rows[8], "outcome.trend.dt"), at(rows[8], "outcome.trend.order")) == pytest.approx(
        (math.sqrt(2e-8), 2.0), rel=1e-9
    )
    assert at(rows[8], "outcome.trend.track") == "tuned"


@pytest.mark.parametrize("errors", [(1e-1, 1e-2, 1e-3, 1e-3, 1e-3), (1e-3, 1e-1, 2e-3, 5e-2, 1e-2), (1e-3,) * 5, (1e-1, 1e-2)])
def test_nothing_is_foreseen_of_an_error_that_does_not_shrink_steadily(errors: tuple[float, ...]) -> None:
    """A floor, mere scatter, no slope at all, and two points, which have no interval."""
    told: list[Told] = [("a", "dart", "tuned", 0.1 / 2**k, error, 1.0 * 2**k) for k, error in enumerate(errors)]
    (last,) = [p for p in Prices(Priced(told)).prices if p.target == 1e-8]
    assert (last.verdict, at(last, "outcome.trend")) == ("not within the ladder", None)


def test_no_trend_is_followed_beyond_a_millionth_of_the_finest_step() -> None:
    """An order of .02 from .5 down to 1e-8 takes 385 decades, which no floating-point number of steps has."""
    told: list[Told] = [("a", "dart", "tuned", 0.1 / 2**k, 0.5 * 2 ** (-0.02 * k), 1.0 * 2**k) for k in range(6)]
    (last,) = [p for p in Prices(Priced(told)).prices if p.target == 1e-8]
    assert (last.verdict, at(last, "outcome.trend")) == ("not within the ladder", None)


def test_of_two_trends_the_cheaper_is_foreseen() -> None:
    """First order is ahead at every step that was run; where it would be met, second order is cheaper by far."""
    first: list[Told] = [("a", "dart", "default", dt, 1e-2 * dt, 0.1 / dt) for dt in (1e-1, 3e-2, 1e-2)]
    (last,) = [p for p in Prices(Priced([*ladder("a", "dart", 1.0), *first])).prices if p.target == 1e-8]
    assert at(last, "outcome.trend.track") == "tuned"


def test_an_error_that_jumps_costs_what_the_finer_step_does() -> None:
    """By hand: from 1e-1 to 1e-3 for four times the cost is an order of 3.3, to 1e-9 for twice the cost one of 20."""
    error, cost = np.array([1e-1, 1e-3, 1e-9]), np.array([1.0, 4.0, 8.0])
    found = price(error, cost, np.array([1.0, 1e-2, 1e-3, 1e-4, 1e-8, 1e-10]))
    np.testing.assert_allclose(found, [1.0, 2.0, 4.0, 8.0, 8.0, math.nan])


def test_an_error_and_what_the_truth_may_be_off_are_shares_of_the_scale() -> None:
    """Errors of .5 dt^2 on a scale of 4 m, with a truth known to .0002 m: that is 5e-5 of the scale, to both sides."""
    store = Priced(ladder("a", "dart", 1.0), scale=4.0, off=2e-4)
    prices = Prices(store)
    point = next(point for point in prices.points if point.dt == 3e-2)
    assert (point.error, point.off) == pytest.approx((0.5 * 3e-2**2 / 4, 5e-5), rel=1e-12)
    bar = drawn(store, point)
    assert bar["most"] - point.error == pytest.approx(5e-5, rel=1e-9)
    assert point.error - bar["least"] == pytest.approx(5e-5, rel=1e-9)
    told = {round(-math.log10(p.target)): p.verdict for p in prices.prices}
    # The finest step errs by 1.25e-7 of the scale: it reaches 1e-5 and 1e-6, where its truth cannot tell.
    assert (told[4], told[5], told[6], told[7]) == ("priced", *["within the truth's error"] * 2, "not within the ladder")


def test_what_the_truth_may_be_off_widens_the_price_by_as_much_as_moves_the_error() -> None:
    """All errors shift alike and evenly within the bar: the ends are the prices at .95 of it, to either side.

    Of 400 even draws the fortieth from an end has a standard deviation of sqrt(.025 .975 / 400) = .8 % of their range, 1.6 % of
    the bar to one side. The bar is a tenth of the finer error, whose square root the price goes by: three of them are .25 %.
    """
    error, cost, off = np.array([8e-2, 8e-4]), np.array([1.0, 10.0]), 8e-5
    told: list[Told] = [("a", "dart", "tuned", 0.1 / c, 4 * e, c) for e, c in zip(error, cost, strict=True)]
    (found,) = [p for p in Prices(Priced(told, scale=4.0, off=4 * off)).prices if p.target == 1e-3]
    low, middle, high = (price(error + share * off, cost, np.array([1e-3]))[0] for share in (-0.95, 0.0, 0.95))
    assert found.reached is not None
    assert found.reached.cost.value == pytest.approx(middle, rel=1e-9)
    assert found.reached.cost.ends == pytest.approx((low, high), rel=2.5e-3)


def test_a_price_leans_on_the_cheapest_run_that_is_as_accurate() -> None:
    rows = {round(-math.log10(p.target)): p for p in Prices(Priced(ladder("a", "dart", 1.0))).prices}
    assert [at(rows[k], "reached.at.dt") for k in (1, 2, 3, 4, 5)] == [1e-1, 1e-1, 3e-2, 1e-2, 1e-3]


def test_an_interval_leaves_out_a_fortieth_on_either_side() -> None:
    values = np.append(np.arange(1001.0), [math.nan] * 9)
    assert interval(values) == (25.0, 975.0)


def test_the_interval_of_a_ratio_is_that_of_the_median_of_its_blocks() -> None:
    """Of 17 blocks redrawn, the median is at most the k-th with the chance that Bin(17, k / 17) >= 9.

    That is .008 at the fourth, .036 at the fifth and .104 at the sixth: a fortieth lies at the fifth, a twentieth at the sixth.
    """
    found = ratio(np.arange(1.0, 18.0), np.ones(17))
    wider = 2.1199 / 1.95996  # Student's t of 16 degrees of freedom over the normal's percentile
    ends = 9.0 * (5 / 9) ** wider, 9.0 * (13 / 9) ** wider
    assert (found.value, found.low, found.high) == pytest.approx((9.0, *ends), rel=1e-4)


def test_medians_leave_out_what_is_missing() -> None:
    values = np.random.default_rng(0).normal(size=(50, 7))
    values[values > 0.6] = math.nan
    values[0] = math.nan
    with pytest.warns(RuntimeWarning):
        known = np.nanmedian(values, axis=1)
    np.testing.assert_array_equal(medians(values), known)


def test_a_case_that_an_engine_was_not_put_to_is_not_held_against_it() -> None:
    prices = Prices(Priced([*ladder("a", "dart", 1.0), *ladder("a", "bullet", 2.0), *ladder("b", "bullet", 1.0)])).prices
    shares = {(s.engine, s.within): s for s in profile(prices) if s.limit == FACTOR}
    assert shares["dart", 1.0].share == 1.0
    # Both reach errors of 1e-1 to 1e-6, six pairs a case: bullet is the cheapest in b alone.
    assert (shares["dart", 1.0].pairs, shares["bullet", 1.0].pairs) == (6, 12)
    assert (shares["bullet", 1.0].share, shares["bullet", 2.0].share) == (0.5, 1.0)


def test_the_case_on_which_a_share_hangs_is_named() -> None:
    told = [*ladder("a", "dart", 1.0), *ladder("a", "bullet", 9.0), *ladder("b", "dart", 9.0), *ladder("b", "bullet", 1.0)]
    store = Priced([*told, *ladder("c", "dart", 1.0), *ladder("c", "bullet", 9.0)])
    found = {share.engine: share for share in hinges(profile(Prices(store).prices)) if share.limit == FACTOR}
    assert without(found["dart"]) == (SceneName("b", ""), 1.0)
    assert without(found["bullet"]) == (SceneName("b", ""), 0.0)
    assert "dart depends most on b: without it, it answers 100% instead of 67% at the lowest price." in TABLE.said(store)


def test_the_reference_engine_is_a_line_beside_the_cheapest_that_can_be_deployed() -> None:
    """It costs half of what dart does in a; nobody else was put to b, which is then no pair."""
    told = [
        *ladder("a", "dart", 2.0),
        *ladder("a", "bullet", 6.0),
        *ladder("a", "reference", 1.0),
        *ladder("b", "reference", 1.0),
    ]
    prices = Prices(Priced(told)).prices
    ratios = {(price.case, price.engine): at(price, "reached.ratio.value") for price in prices if price.target == 1e-2}
    assert ratios.pop(("b", "reference")) is None
    assert ratios == pytest.approx({("a", "dart"): 1.0, ("a", "bullet"): 3.0, ("a", "reference"): 0.5}, rel=1e-9)
    assert {price.engine for price in prices if price.cheapest} == {"dart"}
    shares = {(s.engine, s.within): (s.share, s.pairs) for s in profile(prices) if s.limit == FACTOR}
    assert (shares["dart", 1.0], shares["reference", 1.0], shares["bullet", 2.0]) == ((1.0, 6), (1.0, 6), (0.0, 6))
    told_of_prices = [price_table.TABLE.brief(price) for price in prices]
    assert not any("None" in str(cell) or "nan" in str(cell) for row in told_of_prices for cell in row)
    assert price_table.TABLE.sentences(prices) == [
        "Of 6 pairs of case and error that an engine to deploy reaches, cheapest: dart 4, bullet 0; in 2 intervals meet or "
        "larger steps were not tried, and nobody is counted."
    ]


def test_rays_have_no_real_time() -> None:
    of_steps, of_rays = (largest_steps(Priced(ladder("a", "dart", 1e-3), unit=unit)) for unit in ("step", "ray"))
    assert [step.accurate for step in (*of_steps, *of_rays)] == [1e-1, 1e-1]
    assert of_steps[0].realtime == pytest.approx(100.0)
    assert of_rays[0].realtime is None


class At:
    """A point of a front that has an error only."""

    def __init__(self, error: float) -> None:
        self.error = error


def test_a_long_front_is_clocked_at_both_ends_and_evenly_between() -> None:
    front = [At(10.0**-k) for k in (0, 0.1, 0.2, 0.3, 2, 4, 8)]
    assert [one.error for one in spread(front)[:4]] == [1e-8, 1.0, 1e-4, 1e-2]  # type: ignore[arg-type]
    assert len(spread(front)) == 7  # type: ignore[arg-type]
    nothing: list[Any] = []
    assert spread(nothing) == []


def test_what_is_better_for_being_more_is_no_error() -> None:
    store = Priced(ladder("a", "dart", 1.0))
    store.catalogue["cases"]["a"]["checks"] = [{"metric": "e", "better": "higher"}]
    assert Prices(store).points == Prices(store).prices == ()
