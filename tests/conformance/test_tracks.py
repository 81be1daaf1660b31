"""Tuned is never worse than default: the whole catalogue on every engine, against what the adapters list as trade-offs."""

import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path

import pytest

from harness.adapter import Adapter
from harness.case import Case
from harness.study import plugins
from tests.conformance.engines import NAMES, adapter, why_unavailable
from tests.known_prices import PLUGINS
from tests.tracks import (
    LADDER,
    WORSE,
    Answer,
    Comparison,
    compare,
    comparisons,
    disagreements,
    over_the_ladder,
    run_both_tracks,
)

CASES = plugins.cases()
BRIEF = frozenset(
    {
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
    }
)
"""A cheap case of every family, with most of those whose trade-offs adapters list; `make test-all` runs the others."""
LONG = frozenset(CASES) - BRIEF
ENGINES = pytest.mark.parametrize("name", NAMES)


def _errors(*errors: float, status: str = "passed", off: float = 0.0) -> list[Answer]:
    return [Answer(status=status, error=error, off=off) for error in errors]


def test_tuned_is_worse_from_more_than_a_tenth_on_and_when_it_no_longer_passes() -> None:
    case = CASES["flight_projectile"]
    for default, tuned, worse in (
        (_errors(1.0), _errors(1.09), False),
        (_errors(1.0), _errors(1.11), True),
        (_errors(1.0), _errors(0.5, status="failed"), True),
        (_errors(1.0, status="failed"), _errors(0.5, status="failed"), False),
        (_errors(1.0), [Answer(status="diverged")], True),
        (_errors(1.0, status="failed"), [Answer(status="unsupported")], True),
        ([Answer(status="unsupported")], [Answer(status="unsupported")], False),
        ([Answer(status="diverged")], _errors(5.0, status="failed"), False),
        (_errors(1.0, 3.0), _errors(3.0, 1.0), False),
        (_errors(1.0, 1.0), _errors(1.0, 1.3), True),
    ):
        assert compare(case, case.dt, default, tuned).worse is worse, (default, tuned)


def test_what_takes_more_sub_steps_is_not_worse_for_the_stricter_bound_alone() -> None:
    """A fall of g dt: tuned in eight sub-steps is left with a quarter of what default may have in one, and with twice that."""
    case, fall = CASES["joint_limits"], 9.81 * CASES["joint_limits"].dt
    default = Answer(status="passed", error=0.0, substep=case.dt)
    for speed, worse in ((fall / 4, False), (2 * fall, True)):
        values = {"rms_speed": (speed, 0.0)}
        tuned = Answer(status="failed", error=0.0, substep=case.dt / 8, values=values)
        assert compare(case, case.dt, [default], [tuned]).worse is worse
        # In as many sub-steps as default it is.
        assert compare(case, case.dt, [replace(default, substep=case.dt / 8)], [tuned]).worse


def test_below_the_floor_errors_are_one_and_the_same() -> None:
    case = CASES["flight_projectile"]
    bound = next(check.bound(case.dt) for check in case.checks if check.metric.name == case.headline)
    unbounded = replace(case, checks=(), observe=case.metrics)
    for judged, default, tuned, worse in (
        (case, _errors(0.0), _errors(bound / 101), False),
        (case, _errors(0.0), _errors(bound / 90), True),
        (unbounded, _errors(0.0), _errors(bound / 101), True),
        (unbounded, _errors(0.0), _errors(1.05e-9 * case.scale), False),
        (unbounded, _errors(1e-4, off=1e-3), _errors(1.05e-3, off=1e-3), False),
        (unbounded, _errors(1e-4, off=1e-4), _errors(1.05e-3, off=1e-4), True),
    ):
        assert compare(judged, case.dt, default, tuned).worse is worse, (default, tuned)


def test_where_more_is_better_less_is_worse() -> None:
    case = CASES["stack_card_house"]
    assert compare(case, case.dt, _errors(5.0), _errors(4.0)).worse
    assert not compare(case, case.dt, _errors(5.0), _errors(6.0)).worse
    assert math.isinf(compare(case, case.dt, _errors(5.0), _errors(0.0)).ratio)


def test_a_list_of_trade_offs_is_held_to_both_ways() -> None:
    worse = {"a": "a at dt 1", "b": "b at dt 1"}
    assert disagreements(worse, {"a": "why", "b": "why"}) == []
    assert disagreements(worse, {"a": "why"}) == ["not listed in trade_offs: b at dt 1"]
    assert disagreements({}, {"a": "why"}) == ["listed in trade_offs, but no longer worse: a"]
    assert disagreements({"a": "a"}, {"a": " "}) == ["listed in trade_offs without a reason: a"]


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


def test_every_case_is_compared_in_one_of_the_two_parts() -> None:
    assert set(CASES) > BRIEF


def test_the_brief_part_has_cases_of_every_family_but_what_lasts_and_what_stands() -> None:
    """Orbits take revolutions and machines take seconds on their feet: each of their cases is long."""
    families = {name.partition("_")[0] for name in CASES}
    assert {name.partition("_")[0] for name in BRIEF} == families - {"orbit", "stand"}


@ENGINES
def test_every_trade_off_names_a_case(name: str) -> None:
    assert {one.removesuffix(LADDER) for one in adapter(name).trade_offs} <= set(CASES)


def _run(
    folder: Path, ladder: bool, cases: Mapping[str, Case] = CASES, names: Sequence[str] = NAMES
) -> Mapping[str, Sequence[Comparison]]:
    """Comparisons by engine, of every engine that is there."""
    engines = {name: adapter(name) for name in names if not why_unavailable(name)}
    return comparisons(run_both_tracks(folder, cases, engines, ladder), cases)


@pytest.fixture(scope="session", params=[False, pytest.param(True, marks=pytest.mark.slow)], ids=["brief", "long"])
def own_steps(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Sequence[Comparison]]:
    """The whole catalogue at each case's own time step, in two parts."""
    part = {name: case for name, case in CASES.items() if (name in LONG) == request.param}
    return _run(tmp_path_factory.mktemp("own") / "run", ladder=False, cases=part)


@ENGINES
@pytest.mark.timeout(1200)  # the first of the engines waits for the runs of all
def test_tuned_is_never_worse_than_default_but_where_the_adapter_says_why(
    name: str, own_steps: Mapping[str, Sequence[Comparison]]
) -> None:
    if why_unavailable(name):
        pytest.skip(why_unavailable(name))
    compared = own_steps[name]
    cases = {one.case for one in compared}
    assert cases in (LONG, BRIEF)
    listed = {one: reason for one, reason in adapter(name).trade_offs.items() if one in cases}
    found = disagreements({one.case: str(one) for one in compared if one.worse}, listed)
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
    ladders, worse = dict(_run(tmp_path / "run", ladder=True, names=(name,))), {}
    drawn = CASES[STIRRED]
    for seed in range(1, DRAWS):
        other = replace(drawn, parameters={**drawn.parameters, "seed": seed})
        ladders[name] = [*ladders[name], *_run(tmp_path / str(seed), True, {STIRRED: other}, (name,))[name]]
    for case in CASES:
        steps = [one for one in ladders[name] if one.case == case]
        assert len(steps) == len(CASES[case].ladder) * (DRAWS if case == STIRRED else 1)
        if (mean := over_the_ladder(steps)) > WORSE:
            worse[case + LADDER] = f"{case + LADDER}: {mean:.3g} times in the mean; " + "; ".join(map(str, steps))
    listed = {one: reason for one, reason in adapter(name).trade_offs.items() if one.endswith(LADDER)}
    found = disagreements(worse, listed)
    assert not found, "\n".join(found)
