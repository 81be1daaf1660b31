"""The way from a run to a price, on engines whose error and price are planted: orders, clock and ratios are what they must be.

No time of the machine is asserted: the engines burn a known CPU time themselves. Per call of `step` the clock sees besides it
two looks at the process's clock and a call, some microseconds in at least 120 steps of 20 us, a thousandth. The three per cent
asked for are left for clocks of processes that tick in tens of microseconds.
"""

import json

import numpy as np
import pytest

from plumbline.harness.findings.tables.orders import convergences
from plumbline.harness.statistics.order import fit_order
from tests.known_prices import CASE, LADDER, LAWS, KnownPrices

CLOSE = 0.03


def test_every_cell_ran_was_clocked_and_errs_by_its_law(known_prices: KnownPrices) -> None:
    trials, measured = known_prices.store.trials, known_prices.store.measurements
    assert len(trials) == len(LAWS) * len(LADDER)
    assert set(trials["status"]) == {"passed"}
    error = measured[measured["metric"] == "position_error_max"].set_index("trial")["value"]
    for row in trials.itertuples():
        law = known_prices.laws[(row.engine, row.track)]
        # Rounding: positions of 15 m, a few ulps of 2e-15 m each, against errors of 5e-6 m and more.
        assert error[row.trial] == pytest.approx(law.error(row.dt), rel=1e-8)
        assert json.loads(row.resolved)["integrator"] == f"order_{law.order}"
    samples = known_prices.store.samples.groupby("trial")
    assert set(samples.size()) == {10}
    assert set(samples["process"].nunique()) == {2}


def test_the_fitted_order_is_the_planted_one(known_prices: KnownPrices) -> None:
    found = {(row.engine, row.track): row for row in convergences(known_prices.store)}
    assert found.keys() == known_prices.laws.keys()
    for key, law in known_prices.laws.items():
        assert found[key].case == CASE
        assert found[key].fit.order == pytest.approx(law.order, abs=0.05)
        assert (found[key].promised, found[key].verdict) == (law.order, "kept")
        fit = fit_order(LADDER, [law.error(dt) for dt in LADDER])
        assert fit is not None
        assert fit.order == pytest.approx(law.order, abs=1e-9)  # logarithms of powers: rounding alone


def test_the_clock_finds_the_planted_price(known_prices: KnownPrices) -> None:
    for row in known_prices.store.trials.itertuples():
        law = known_prices.laws[(row.engine, row.track)]
        assert row.cpu_per_sim_s == pytest.approx(law.cost(row.dt), rel=CLOSE)
        assert row.cpu_per_unit == pytest.approx(law.spin, rel=CLOSE)
        assert row.cpu_low <= row.cpu_per_sim_s <= row.cpu_high


def test_the_ratio_of_two_engines_is_the_planted_one(known_prices: KnownPrices) -> None:
    prices = known_prices.store.trials.set_index(["engine", "track", "dt"])["cpu_per_sim_s"]
    for track in ("default", "tuned"):
        for dt in LADDER:
            assert prices["laggard", track, dt] / prices["spinner", track, dt] == pytest.approx(3.0, rel=CLOSE)


def test_an_error_between_two_steps_costs_what_the_laws_say(known_prices: KnownPrices) -> None:
    """Costs and errors are powers of the step, so that logarithms lie on a line: interpolating them adds nothing of its own."""
    prices = known_prices.store.trials.set_index(["engine", "track", "dt"])["cpu_per_sim_s"]
    for (engine, track), law in known_prices.laws.items():
        errors = [law.error(dt) for dt in reversed(LADDER)]
        costs = [prices[engine, track, dt] for dt in reversed(LADDER)]
        wanted = law.error(1 / 173)
        found = float(np.exp(np.interp(np.log(wanted), np.log(errors), np.log(costs))))
        assert found == pytest.approx(law.cost(law.step(wanted)), rel=CLOSE)


def test_the_cheapest_way_to_an_error_is_the_highest_order_that_an_engine_has(known_prices: KnownPrices) -> None:
    """By hand: 0.02 m at 60 steps a second falls to a 16th with twice the steps at order 4, four times at order 2."""
    assert known_prices.price("spinner", 0.02 / 16) == pytest.approx(20e-6 * 120)
    assert known_prices.price("laggard", 0.02 / 16) == pytest.approx(60e-6 * 240)
    assert known_prices.price("laggard", 1.0) == pytest.approx(60e-6 * 60)
    assert known_prices.price("laggard", 1e-5) is None
