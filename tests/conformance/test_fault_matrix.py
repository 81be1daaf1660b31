"""Every planted fault is noticed by the checks of the cases themselves, and a sound engine fails none of them."""

import ast
from collections import Counter
from fnmatch import fnmatchcase

import pytest

from plumbline.harness.conformance import CHECKS
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State
from tests.conformance.fault_matrix import (
    FILE,
    KINDS,
    NAMED,
    applied,
    broken_checks,
    caught,
    head,
    known,
    sound_failures,
    steps,
)
from tests.fresh_faults import faults
from tests.mutants import planted
from tests.planted_faults import FAULTS, Fault
from tests.planted_faults.planting import Rewritten, plant

FAULT = {fault.name: fault for fault in FAULTS}
QUICK = (
    ("gravity_upside_down", "flight_projectile"),
    ("gravity_upside_down", "rest_penetration"),
    ("friction_five_percent_strong", "friction_stop"),
    ("friction_five_percent_strong", "friction_threshold"),
    ("twice_the_time_step", "flight_projectile"),
    ("twice_the_time_step", "joint_pendulum"),
    ("no_gyroscopic_torque", "spin_asymmetric_top"),
    ("no_gyroscopic_torque", "spin_symmetric_top"),
    ("angular_velocity_in_the_body_frame", "spin_asymmetric_top"),
    ("angular_velocity_in_the_body_frame", "spin_symmetric_top"),
    ("inertia_axes_exchanged", "spin_asymmetric_top"),
    ("inertia_axes_exchanged", "spin_intermediate_axis"),
    ("hidden_damping", "flight_projectile"),
    ("hidden_damping", "joint_pendulum"),
    ("sleeping", "friction_threshold"),
    ("sleeping", "friction_wall_pinch"),
    ("state_one_step_behind", "flight_projectile"),
    ("state_one_step_behind", "spin_principal"),
    ("noise_from_one_seed", "sensor_imu_noise"),
    ("noise_from_one_seed", "sensor_lidar_noise"),
)
"""Two cases for each of the ten faults, the cheapest that notice at their own step."""
DEAR = {("sleeping", "friction_threshold"), ("noise_from_one_seed", "sensor_imu_noise")}
"""Those of which the other case takes half as long: `make test-all` looks at them."""


def test_the_page_counts_and_names_every_planted_fault() -> None:
    text = FILE.read_text(encoding="utf-8")
    assert f"in one way, {len(FAULTS)} ways in all" in text
    assert not [name for name in FAULT if f"| `{name}` |" not in text]


def test_the_faults_thought_out_from_the_code_can_be_planted_and_stand_on_the_page() -> None:
    root, fresh = FILE.parents[1], faults()
    assert max(Counter(fault.name for fault in fresh).values()) == 1
    for fault in fresh:
        ast.parse(planted(fault))
        assert fault.kind in KINDS, fault.name
        assert not fault.check or (fault.checked_on and fault.check in {check.name for check in CHECKS}), fault.name
        assert all((root / test.partition("::")[0]).is_file() for test in fault.tests), fault.name


def test_the_page_is_of_today_down_to_what_cases_notice() -> None:
    assert FILE.read_text(encoding="utf-8").startswith(head() + "\n")


def test_the_page_names_only_checks_and_cases_that_there_are() -> None:
    rows = [line.strip("| \n").split(" | ") for line in FILE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    named = {name.strip("`") for row in rows if len(row) == 3 and row[1].startswith("`") for name in row[2].split(", ")}
    assert named <= {check.name for check in CHECKS} | set(plugins.cases()) | {"noise_axes_are_independent"}


def _look(fault: Fault, case: str) -> None:
    dt, checks = known()[fault.name, case]
    rung = next(step for step in steps(plugins.case(case)) if step == pytest.approx(dt, rel=1e-5))
    assert not sound_failures(case, rung), f"the sound engine fails {sound_failures(case, rung)}"
    found = caught(fault, plugins.case(case), rung)
    assert found is not None, f"{case} no longer notices {fault.words}"
    assert checks & set(found.checks), f"{sorted(found.checks)} noticed instead of {sorted(checks)}"


@pytest.mark.parametrize(
    ("fault", "case"), [pytest.param(*two, marks=pytest.mark.slow if two in DEAR else ()) for two in QUICK]
)
def test_two_cases_notice_each_of_the_ten_faults(fault: str, case: str) -> None:
    _look(FAULT[fault], case)


def test_the_ten_faults_are_looked_for_twice_each() -> None:
    assert sorted(fault for fault, _ in QUICK) == sorted(2 * NAMED)
    assert len(set(QUICK)) == len(QUICK)


def test_the_page_holds_every_fault_twice_and_knows_its_controls_and_cases() -> None:
    rows = known()
    for fault in NAMED:
        assert sum(row[0] == fault for row in rows) >= 2, fault
    assert {fault for fault, _ in rows} <= set(FAULT)
    assert {case for _, case in rows} <= set(plugins.cases())


def test_patterns_name_cases_that_exist() -> None:
    for fault in FAULTS:
        for pattern in fault.cases:
            assert any(fnmatchcase(case, pattern) for case in plugins.cases()), (fault.name, pattern)


@pytest.mark.parametrize("case", ["friction_wall_pinch", pytest.param("friction_threshold", marks=pytest.mark.slow)])
def test_an_engine_that_is_built_anew_in_each_step_without_a_fault_fails_nothing(case: str) -> None:
    """Sleep is planted by building anew: what the cases notice has to be the sleep, not the planting."""
    question = plugins.case(case)

    class Rebuilt(Rewritten):
        def edit(self, before: State, after: State, dt: float) -> bool:
            return True

    rebuilt = plant(plugins.adapter("reference"), simulation=Rebuilt)
    assert not broken_checks(question, rebuilt, question.dt)


@pytest.mark.slow
@pytest.mark.parametrize("fault", [fault for fault in FAULTS if fault.cases], ids=lambda fault: fault.name)
def test_every_case_notices_the_faults_that_it_should(fault: Fault) -> None:
    missed = [case.name for case in applied(fault) if (fault.name, case.name) not in known()]
    assert not missed, f"{fault.words} is not on the page for {missed}"
    for case in applied(fault):
        _look(fault, case.name)
