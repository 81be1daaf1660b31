"""Every engine gets as many tries: the sweep of a price study, on engines as they are and on one without its knobs."""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from plumbline.harness.findings.cost_point import ALIKE
from plumbline.harness.study import plugins
from tests.conformance.engines import NAMES, adapter, why_unavailable
from tests.knobs import Tried, swept, unequal

BARE = "bare"
SWEEP = 16
"""As many points beyond the ladder as the study of prices gives."""
STEPS = {"impact_oblique": 4}
"""Of a case's ladder, its own among them, where not the whole: the two finest cost three times as much as these."""


def test_one_and_a_half_times_as_many_settings_are_alike_and_more_are_not() -> None:
    some = [Tried(case="c", engine=name, settings=count, trials=count) for name, count in (("a", 30), ("b", 20), ("d", 19))]
    assert ALIKE == 1.5
    assert unequal(some) == ["c: 19 settings of d, 30 of a"]


@pytest.fixture(scope="module", params=["impact_oblique", pytest.param("friction_slip_to_roll", marks=pytest.mark.slow)])
def tried(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Sequence[Tried]:
    """A cheap case with contact, in which every engine has knobs that matter; and MuJoCo once more without a knob."""
    full = plugins.case(request.param)
    # The headline, by which points are chosen, at some twenty instants: the steps are what settings answer by.
    headline = tuple(check for check in full.checks if check.metric.name == full.headline)
    case = replace(full, checks=headline, observe=(), with_contacts=False, sample_interval=max(full.ladder))
    engines = {name: adapter(name) for name in NAMES if not why_unavailable(name)}
    engines[BARE] = replace(adapter("mujoco"), name=BARE, knobs={}, trade_offs=())
    return swept(case, engines, case.ladder[: STEPS.get(case.name)], SWEEP, tmp_path_factory.mktemp("knobs"))


@pytest.mark.timeout(600)  # some forty trials of each engine
def test_the_sweep_tries_as_many_settings_of_each_engine(tried: Sequence[Tried]) -> None:
    assert unequal([one for one in tried if one.engine != BARE]) == []


@pytest.mark.timeout(600)
def test_an_engine_whose_knobs_were_taken_away_is_noticed(tried: Sequence[Tried]) -> None:
    (words,) = unequal(tried)
    assert f" settings of {BARE}, " in words
