"""Engines broken in exactly one way are caught by the check that names the fault, and sound ones are not."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import count

import numpy as np
import pytest

from plumbline.harness.adapter import Adapter, Feature
from plumbline.harness.conformance import CHECKS, noise_axes_are_independent, run_check
from plumbline.harness.scene import AxisNoise
from plumbline.harness.sensors.imu import three_axes
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State, Trajectory
from tests.conformance import fault_matrix
from tests.conformance.engines import NAMES, adapter, outcome_of, why_unavailable
from tests.planted_faults import FAULTS, Fault
from tests.planted_faults.planting import Rewritten, Wrapped, plant
from tests.planted_faults.sound_engines import AnyOrder, EitherSign

ON_ENGINES = tuple(fault for fault in FAULTS if not fault.on_trajectory)
ON_TRAJECTORIES = tuple(fault for fault in FAULTS if fault.on_trajectory and fault.seen_by)
ON_READINGS = tuple(fault for fault in FAULTS if fault.on_trajectory and not fault.seen_by)
"""Faults that only cases of sensors can see: those that the control names."""
CHECK = {check.name: check for check in CHECKS}


@pytest.fixture(scope="module")
def caught() -> set[str]:
    """The names of the controls caught so far."""
    return set()


def _candidates(fault: Fault) -> list[Adapter]:
    """The engines on which the fault can show: none of its checks is a failure that they declare. MuJoCo comes first."""
    order = sorted(NAMES, key=lambda name: (name not in {"mujoco", "reference"}, name))
    present = [adapter(name) for name in order if not why_unavailable(name)]
    excused = {f"tuned/{check}" for check in fault.seen_by}
    return [one for one in present if fault.needs in one.features and not excused & set(one.known_failures)]


@pytest.mark.parametrize("fault", ON_ENGINES, ids=lambda fault: fault.name)
def test_a_planted_fault_is_caught_and_named(fault: Fault, caught: set[str]) -> None:
    candidates = _candidates(fault)
    assert candidates, f"no installed engine has {fault.needs.names}"
    engine = candidates[0]
    checks = [CHECK[name] for name in fault.seen_by]
    sound = {name: outcome_of(engine.name, "tuned", name) for name in fault.seen_by}
    assert {o.status for o in sound.values()} == {"passed"}, [(n, o.status, o.message) for n, o in sound.items()]
    broken = {check.name: run_check(fault.plant(engine), "tuned", check) for check in checks}
    missed = [(name, outcome.status, outcome.message) for name, outcome in broken.items() if outcome.status != "failed"]
    assert not missed, f"{fault.words} on {engine.name} went unnoticed by {missed}"
    caught.add(fault.name)


@pytest.mark.parametrize("fault", ON_TRAJECTORIES, ids=lambda fault: fault.name)
def test_a_fault_in_recorded_streams_is_caught_and_named(fault: Fault, caught: set[str]) -> None:
    time = np.arange(4000) / 400.0
    noise = three_axes(AxisNoise(density=2e-3), len(time), 1 / 400, 7, "imu", "accelerometer")
    streams = {"imu/accelerometer": np.array([0.0, 0.0, 9.81]) + noise, "imu/accelerometer/time": time}
    sound = replace(Trajectory.of(np.zeros(1), 1), streams=streams)
    assert fault.seen_by == ("noise_axes_are_independent",)
    assert noise_axes_are_independent(sound).status == "passed"
    assert noise_axes_are_independent(fault.spoil(sound)).status == "failed"
    caught.add(fault.name)


@pytest.mark.parametrize(
    ("fault", "case"),
    [(fault, name) for fault in ON_READINGS for name in fault.cases],
    ids=lambda one: getattr(one, "name", one),
)
def test_a_fault_in_readings_is_caught_by_every_case_that_the_control_names(fault: Fault, case: str, caught: set[str]) -> None:
    found = fault_matrix.caught(fault, plugins.case(case), plugins.case(case).dt)
    assert found is not None, f"{fault.words} went unnoticed by {case}, or the sound engine fails it"
    caught.add(fault.name)


def test_every_control_is_caught(caught: set[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Runs last: each of the tests above adds what it caught."""
    if not caught:
        pytest.skip("run with the whole file: it counts what the tests before it caught")
    with capsys.disabled():
        print(f"\nnegative controls: caught {len(caught)} of {len(FAULTS)}")
    assert caught == {fault.name for fault in FAULTS}


@pytest.mark.slow
def test_every_check_can_fail() -> None:
    """All checks against all quick controls on one engine: a check that nothing makes fail would prove nothing."""
    engine = _candidates(ON_ENGINES[0])[0]
    # Read off the adapter's own file or class, which no wrapper changes, with tests of their own in test_conformance; and what
    # the harness draws after an engine, which test_mounted_sensors breaks.
    elsewhere = {"imports_without_its_vendor", "declarations_are_well_formed", "version_is_a_string", "warnings_are_strings"}
    elsewhere |= {"lidar_noise_has_its_strength"}
    waiting = {c.name for c in CHECKS if c.needs in engine.features} - elsewhere
    for fault in ON_ENGINES:
        if fault.needs in engine.features and fault.name not in {"hidden_damping", "sleeping"}:
            broken = fault.plant(engine)
            waiting -= {name for name in waiting if run_check(broken, "tuned", CHECK[name]).status == "failed"}
    assert not waiting


def test_controls_have_unique_names_and_name_real_checks() -> None:
    names = [fault.name for fault in FAULTS]
    assert len(set(names)) == len(names) >= 90
    for fault in ON_ENGINES:
        assert set(fault.seen_by) <= set(CHECK), fault.name
        assert fault.seen_by


def both(engine: Adapter) -> Adapter:
    """It tells q or -q, and its contacts in another order."""
    return plant(plant(engine, simulation=AnyOrder), simulation=EitherSign)


ONE_BY_ONE = [pytest.param(partial(plant, simulation=kind), marks=pytest.mark.slow) for kind in (EitherSign, AnyOrder)]


@pytest.mark.parametrize("sound", [both, *ONE_BY_ONE], ids=["both", "either_sign", "any_order"])
def test_a_sound_engine_that_uses_what_the_contract_leaves_open_passes_every_check(sound: Callable[[Adapter], Adapter]) -> None:
    """MuJoCo's tuned track declares no failure: the same engine with q or -q, with contacts in another order, fails none.

    Pictures, which neither changes, are looked at by `make test-all`.
    """
    engine = adapter("mujoco")
    assert not any(key.startswith("tuned/") for key in engine.known_failures)
    asked = [check for check in CHECKS if sound is not both or Feature.RENDER not in check.needs]
    outcomes = [run_check(sound(engine), "tuned", check) for check in asked]
    assert not [(o.check, o.message) for o in outcomes if o.status not in {"passed", "not_applicable"}]
    assert sum(o.status == "passed" for o in outcomes) > 80


def test_a_wrapped_engine_without_a_fault_behaves_as_the_engine_inside() -> None:
    """The wrapper itself must not be what the checks catch: one that builds anew does so after every tenth step."""
    engine, steps = _candidates(ON_ENGINES[0])[0], count(1)

    class Tenth(Rewritten):
        def edit(self, before: State, after: State, dt: float) -> bool:
            return next(steps) % 10 == 0

    for wrapped in (plant(engine), plant(engine, simulation=Wrapped), plant(engine, simulation=Tenth)):
        for name in ("initial_state_comes_back", "hidden_damping_is_off", "velocity_is_not_clamped", "sleeping_is_off"):
            outcome = run_check(wrapped, "tuned", CHECK[name])
            assert outcome.status == "passed", (name, outcome.message)
