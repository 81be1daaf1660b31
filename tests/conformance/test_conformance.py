"""Every built-in adapter keeps the contract, and the kit itself serves a third party's engine."""

import ast
import re
from collections import Counter
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.adapter import Adapter, Feature, Settings
from plumbline.harness.conformance import CHECKS, CheckResult, ConformanceCheck, checks, gate, run_check, run_conformance
from plumbline.harness.conformance.catalogue import SUBJECTS
from plumbline.harness.conformance.checks.contract.features import PROBED
from plumbline.harness.conformance.checks.contract.protocol import loaded_at_once
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import State
from tests.conformance.engines import NAMES, adapter, outcome_of, why_unavailable
from tests.conformance.free_flight import ADAPTER as FREE_FLIGHT
from tests.conformance.free_flight import Flight, FreeFlight

TRACKS = ("default", "tuned")
FOUR = ("reference", "mujoco", "bullet", "dart")


BOTH = {
    "box_rests_on_box",
    "contact_forces_carry_the_weight",
    "drive_reaches_its_target",
    "friction_has_its_size",
    "gyroscopic_term_is_present",
    "hidden_damping_is_off",
    "initial_state_comes_back",
    "joint_pendulum_period",
    "limits_hold",
    "no_restitution_does_not_bounce",
    "resolved_settings_are_complete",
    "restitution_of_a_pair",
    "rolling_is_free_without_rolling_friction",
    "same_input_same_hash",
    "sleeping_is_off",
    "spring_frequency",
    "stack_stays_up",
    "substeps_divide_dt",
    "velocity_is_not_clamped",
}
"""What `make test` asks of 'default' too, beside the checks of which a failure is declared; `make test-all` asks everything."""
LONGEST = {("dart", "tuned", "hull_rests_on_box"), ("dart", "tuned", "hull_rests_on_plane")}
"""Hulls on other supports, and these on the other track, take a thirtieth of the time."""


def _asked(engine: str, track: str, check: ConformanceCheck) -> Any:
    known = f"{track}/{check.name}" in adapter(engine).known_failures
    brief = (engine, track, check.name) not in LONGEST and (track == "tuned" or check.name in BOTH or known)
    return pytest.param(engine, track, check, marks=[] if brief else [pytest.mark.slow], id=f"{engine}-{track}-{check.name}")


@pytest.mark.parametrize(("engine", "track", "check"), [_asked(*three) for three in product(NAMES, TRACKS, CHECKS)])
def test_adapter_keeps_the_contract(engine: str, track: str, check: ConformanceCheck) -> None:
    if reason := why_unavailable(engine):
        pytest.skip(reason)
    outcome = outcome_of(engine, track, check.name)
    if outcome.status == "not_applicable":
        pytest.skip(outcome.message)
    if outcome.status == "known":
        pytest.xfail(outcome.message)
    assert outcome.status == "passed", outcome.message


@pytest.mark.parametrize("engine", NAMES)
def test_at_least_twenty_five_checks_apply_to_each_engine_and_track(engine: str) -> None:
    if reason := why_unavailable(engine):
        pytest.skip(reason)
    claimed = adapter(engine).features
    asked = [check for check in CHECKS if not check.needs & ~claimed]
    assert len(asked) >= 25, f"{engine}: {len(asked)} of {len(CHECKS)} checks apply"


def test_the_four_engines_have_an_adapter_each() -> None:
    assert set(FOUR) <= set(NAMES)


def test_names_of_checks_are_unique_and_snake_case() -> None:
    counts = Counter(check.name for check in CHECKS)
    assert not [name for name, count in counts.items() if count > 1]
    # Frames keep their capitals: angular_velocity_is_in_W.
    assert all(re.fullmatch(r"[a-z][a-z0-9]*(_([a-z0-9]+|[ABW]))*", name) for name in counts)


def test_every_file_of_checks_is_asked() -> None:
    folder = Path(checks.__path__[0])
    files = {".".join(path.relative_to(folder).with_suffix("").parts) for path in folder.glob("*/*.py")}
    assert {name for name in files if not name.endswith("__init__")} == set(SUBJECTS)


def test_every_feature_is_needed_by_a_check_or_tried_by_the_probe_of_features() -> None:
    needed = Feature.NONE
    for check in CHECKS:
        needed |= check.needs
    assert (~(needed | PROBED)).names == ("native_steps",)


@pytest.mark.parametrize("track", ["default", pytest.param("tuned", marks=pytest.mark.slow)])
def test_a_third_party_engine_passes_with_few_features(track: str) -> None:
    outcomes = run_conformance(FREE_FLIGHT, (track,))
    assert gate(outcomes), [(o.check, o.message) for o in outcomes if o.status not in {"passed", "not_applicable"}]
    counts = Counter(outcome.status for outcome in outcomes)
    assert counts["passed"] >= 25
    assert counts["not_applicable"] > 0
    assert len(outcomes) == len(CHECKS)


def test_both_tracks_are_asked_unless_one_is_named() -> None:
    asked = run_conformance(FREE_FLIGHT, checks=[_check("version_is_a_string")])
    assert [(outcome.track, outcome.status) for outcome in asked] == [(track, "passed") for track in TRACKS]


def test_a_feature_claimed_but_refused_fails_by_name() -> None:
    boaster = replace(FREE_FLIGHT, features=FREE_FLIGHT.features | Feature.SPHERE)
    outcome = run_check(boaster, "tuned", _check("claimed_features_build"))
    assert outcome.status == "failed"
    assert "sphere: claimed, but Unsupported" in outcome.message
    outcome = run_check(boaster, "tuned", _check("centre_of_mass_off_the_shape_origin"))
    assert outcome.status == "failed"
    assert "which the engine claims" in outcome.message


def test_a_feature_kept_silent_fails_every_check_that_needs_it() -> None:
    modest = replace(FREE_FLIGHT, features=FREE_FLIGHT.features & ~Feature.WRENCH)
    for name in ("unclaimed_features_raise_unsupported", "wrench_has_sign_and_size"):
        outcome = run_check(modest, "default", _check(name))
        assert outcome.status == "failed"
        assert "wrench" in outcome.message


def test_an_exception_in_a_check_is_a_failure_with_its_text() -> None:
    def stumble(adapter: Adapter, settings: Settings) -> CheckResult:
        raise ZeroDivisionError("no ground to stand on")

    outcome = run_check(FREE_FLIGHT, "tuned", ConformanceCheck(name="stumble", question="?", run=stumble))
    assert (outcome.status, outcome.message) == ("failed", "ZeroDivisionError: no ground to stand on")


def _check(name: str) -> ConformanceCheck:
    return next(check for check in CHECKS if check.name == name)


def _sometimes(status: str, *, excusable: bool = True) -> ConformanceCheck:
    def run(adapter: Adapter, settings: Settings) -> CheckResult:
        return CheckResult(status, "got 1, expected 2")  # type: ignore[arg-type]

    return ConformanceCheck(name="sometimes", question="?", run=run, excusable=excusable)


@pytest.mark.parametrize(
    ("found", "excusable", "expected", "admitted"),
    [
        ("failed", True, "known", True),
        ("passed", True, "improved", False),
        ("not_applicable", True, "failed", False),
        ("failed", False, "failed", False),
        ("passed", False, "failed", False),
    ],
)
def test_a_declared_failure_is_a_strict_expectation(found: str, excusable: bool, expected: str, admitted: bool) -> None:
    declaring = replace(FREE_FLIGHT, known_failures={"tuned/sometimes": "its clock is slow"})
    check = _sometimes(found, excusable=excusable)
    declared, undeclared = run_check(declaring, "tuned", check), run_check(declaring, "default", check)
    assert declared.status == expected
    assert "its clock is slow" in declared.message
    assert undeclared.status == found
    assert gate([declared]) is admitted


def test_a_version_that_is_no_string_is_caught() -> None:
    class Numbered(FreeFlight):
        def version(self) -> str:
            return 1.0  # type: ignore[return-value]

    numbered = Numbered(**{name: getattr(FREE_FLIGHT, name) for name in FREE_FLIGHT.__dataclass_fields__})
    assert run_check(numbered, "tuned", _check("version_is_a_string")).status == "failed"


def test_the_gate_is_shut_where_nothing_was_asked() -> None:
    assert not gate([])


def test_an_adapter_that_imports_its_vendor_at_once_is_caught() -> None:
    source = "import json\ntry:\n    import vendor.core\nexcept ImportError:\n    pass\n\ndef build():\n    import other\n"
    assert list(loaded_at_once(ast.parse(source))) == ["json", "vendor.core"]


def test_a_known_failure_of_no_check_is_caught() -> None:
    for key in ("tuned/no_such_check", "tuned/quaternion_is_wxyz", "track/hidden_damping_is_off"):
        sloppy = replace(FREE_FLIGHT, known_failures={key: "because"})
        outcome = run_check(sloppy, "tuned", _check("declarations_are_well_formed"))
        assert outcome.status == "failed"
        assert key in outcome.message


def test_an_engine_that_writes_only_half_of_the_state_is_caught() -> None:
    class HalfHearted(FreeFlight):
        def build(self, scene: Scene, settings: Settings) -> Flight:
            simulation = super().build(scene, settings)
            whole = simulation.state

            def state(out: State) -> None:
                whole(State(out.p_WB, out.q_WB, out.v_WB, out.w_WB.copy()))

            simulation.state = state  # type: ignore[method-assign]
            return simulation

    lazy = HalfHearted(**{name: getattr(FREE_FLIGHT, name) for name in FREE_FLIGHT.__dataclass_fields__})
    for name in ("state_is_written_into_the_given_arrays", "initial_state_comes_back"):
        assert run_check(lazy, "tuned", _check(name)).status == "failed"
