"""Tuned is never worse than default, but where an adapter lists a trade-off: a cheap case of every family, and all ladders.

All cases at their own steps, every knob and the prices belong to the study `dominance`. Engines that are installed when they
are asked for are in no such study: they have all cases at their own steps here (`make test-engines`).
"""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path

import pytest

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.search.dominance import ALIKE
from plumbline.harness.study import plugins
from tests.conformance.engines import NAMES, adapter, why_unavailable
from tests.known_prices import PLUGINS
from tests.tracks import Tracks, comparisons, disagreements, listed, over_the_ladder, run_both_tracks

CASES = plugins.cases()
BRIEF = (
    "flight_projectile",
    "friction_threshold",
    "impact_cradle",
    "joint_limits",
    "rest_penetration",
    "sensor_imu_free_fall",
    "spin_fast",
    "stack_card_house",
    "system_far_origin",
    "tunnel_sphere_wall",
)
"""A cheap case of every family, with most of those whose trade-offs adapters list."""
ENGINES = pytest.mark.parametrize("name", NAMES)


def test_a_list_of_trade_offs_is_held_to_both_ways() -> None:
    worse = {"a": "a at dt 1", "b": "b at dt 1"}
    assert disagreements(worse, {"a", "b"}) == []
    assert disagreements(worse, {"a"}) == ["not listed in trade_offs: b at dt 1"]
    assert disagreements({}, {"a"}) == ["listed in trade_offs, but no longer worse: a"]


def free_of_charge(engine: Adapter) -> Adapter:
    """A planted engine whose steps cost nothing: its errors are asked for, and no price."""
    tracks = {name: replace(track, options={**track.options, "spin": 0.0}) for name, track in engine.tracks.items()}
    made = copy(engine)
    object.__setattr__(made, "tracks", tracks)
    return made


def test_an_engine_that_was_deliberately_detuned_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two planted engines whose default errs by the first order: one is tuned to the second, one to an error that stays."""
    monkeypatch.syspath_prepend(PLUGINS)
    engines = {name: free_of_charge(plugins.adapter(name)) for name in ("spinner", "detuned")}
    case = {"flight_projectile": CASES["flight_projectile"]}
    compared = comparisons(run_both_tracks(tmp_path / "run", case, engines, ladder=False), case)
    worse = {name: {one.case: str(one) for one in some if one.worse} for name, some in compared.items()}
    assert disagreements(worse["spinner"], {}) == []
    assert [one.partition(":")[0] for one in disagreements(worse["detuned"], {})] == ["not listed in trade_offs"]


def test_the_brief_part_has_cases_of_every_family_but_what_lasts_and_what_stands() -> None:
    """Orbits take revolutions and machines take seconds on their feet: each of their cases is long."""
    families = {name.partition("_")[0] for name in CASES}
    assert {name.partition("_")[0] for name in BRIEF} == families - {"orbit", "stand"}


@ENGINES
def test_every_trade_off_names_a_case(name: str) -> None:
    assert {case for one in adapter(name).trade_offs for case in one.cases} <= set(CASES)


def _run(folder: Path, ladder: bool, cases: Mapping[str, Case], name: str) -> Sequence[Tracks]:
    """Comparisons of an engine."""
    return comparisons(run_both_tracks(folder, cases, {name: adapter(name)}, ladder), cases)[name]


@ENGINES
@pytest.mark.timeout(3600)
def test_tuned_is_never_worse_than_default_but_where_the_adapter_says_why(name: str, tmp_path: Path) -> None:
    """At each case's own step."""
    if why_unavailable(name):
        pytest.skip(why_unavailable(name))
    cases = CASES if adapter(name).extra else {case: CASES[case] for case in BRIEF}
    compared = _run(tmp_path / "run", False, cases, name)
    said = [case for case in listed(adapter(name), "own step") if case in cases]
    found = disagreements({one.case: str(one) for one in compared if one.worse}, said)
    assert not found, "\n".join(found)


STIRRED, DRAWS = "stack_stirred", 6


@ENGINES
@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_over_the_ladder_tuned_is_no_worse_on_the_whole_but_where_the_adapter_says_why(name: str, tmp_path: Path) -> None:
    """The whole catalogue over each case's ladder of time steps; what drawn forces stir, over several draws of them.

    How deep the deepest overlap of a stirred heap is, is decided by roundings: one draw's ratio lies between .7 and 1.2.
    """
    if why_unavailable(name):
        pytest.skip(why_unavailable(name))
    ladders, worse = list(_run(tmp_path / "run", True, CASES, name)), dict[str, str]()
    drawn = CASES[STIRRED]
    for seed in range(1, DRAWS):
        other = replace(drawn, parameters={**drawn.parameters, "seed": seed})
        ladders += _run(tmp_path / str(seed), True, {STIRRED: other}, name)
    for case in CASES:
        steps = [one for one in ladders if one.case == case]
        assert len(steps) == len(CASES[case].ladder) * (DRAWS if case == STIRRED else 1)
        if (mean := over_the_ladder(steps)) > ALIKE:
            worse[case] = f"{case}: {mean:.3g} times in the mean; " + "; ".join(map(str, steps))
    found = disagreements(worse, listed(adapter(name), "ladder"))
    assert not found, "\n".join(found)
