"""The chaotic release and Painleve's rod: their references by another route, and faults that must fail their checks."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases import friction_painleve as painleve
from plumbline.cases import joint_double_pendulum_chaotic as chaos
from plumbline.harness.case import Case, Converged
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.chaos import ensemble_energy_error, ensemble_spread, kinetic_energies
from plumbline.harness.metrics.contacts import impulse_max
from plumbline.harness.metrics.slide import painleve_coefficient
from plumbline.harness.trajectory import Contacts, Floats, Trajectory


def verdicts(case: Case, run: Trajectory, **parameters: Any) -> dict[str, bool]:
    chosen = dict(case.parameters) | parameters
    made = case.truth_at(run.time, chosen)
    expected = made.trajectory if isinstance(made, Converged) else made
    found = {}
    # Made by hand, a run has no forces that would move it: the laws of these have tests of their own.
    for c in (c for c in case.checks if not c.metric.name.endswith("_residual")):
        end = np.inf if c.end is None else c.end
        truth = None if expected is None else expected.between(c.start, end)
        found[c.metric.name] = c.passes(
            c.metric(case.scene(case.at(**chosen)), run.between(c.start, end), truth), run.dt, case.parameters
        )
    return found


# --- joint_double_pendulum_chaotic ----------------------------------------------------------------

TIME = np.arange(601) / 60


def test_each_member_starts_as_far_from_the_first_as_it_says() -> None:
    upper = [body for body in chaos.scene(chaos.P()).bodies if body.name.startswith("upper")]
    angles = np.array([2 * np.arctan2(-b.q_WB[2], b.q_WB[0]) for b in upper])
    assert angles[0] == pytest.approx(np.radians(120.0), abs=1e-15)
    np.testing.assert_allclose(angles[1:] - angles[0], np.geomspace(1e-6, 1e-3, 7), rtol=1e-9)


def test_the_reference_is_converged_up_to_the_horizon_and_keeps_its_energy_to_the_end() -> None:
    made = chaos.expected(TIME, chaos.P())
    bound = min(c.bound(min(chaos.CASE.ladder), chaos.CASE.parameters) for c in chaos.CASE.checks if c.end is not None)
    assert 0 < made.position_error < 1e-6 * bound
    again = chaos._roughly(120.0, 120.0, 8)
    late = TIME > 8.0
    # What is one to rounding at the horizon is another motion at the end: nothing there is to be compared.
    assert np.abs(made.trajectory.p_WB - again.p_WB)[late].max() > 0.1
    assert np.abs(made.trajectory.p_WB - again.p_WB)[TIME <= 1.0].max() < 1e-7


def test_the_starts_have_forgotten_each_other_by_the_time_that_averages_are_taken() -> None:
    run, scene = chaos.expected(TIME, chaos.P()).trajectory, chaos.scene(chaos.P())
    early, late = (ensemble_spread(scene, run.between(0.0, t), None) for t in (1.0, chaos.PARTED + 1))
    assert early < 0.01
    assert late > 0.1
    # Another set of starts has the same average, to the standard errors that the bound is made of.
    other = chaos._roughly(120.02, 120.0, 8).between(chaos.PARTED, 10.0)
    assert ensemble_energy_error(scene, other, run.between(chaos.PARTED, 10.0)) < 5 * chaos._late(chaos.P())[0]


def test_chaos_passes_and_a_brake_a_gap_and_a_late_start_fail() -> None:
    fine = replace(chaos.expected(TIME, chaos.P()).trajectory, dt=1 / 1920)
    assert all(verdicts(chaos.CASE, fine).values())
    braked = replace(
        fine, v_WB=fine.v_WB * np.exp(-0.1 * TIME)[:, None, None], w_WB=fine.w_WB * np.exp(-0.1 * TIME)[:, None, None]
    )
    found = verdicts(chaos.CASE, braked)
    assert not found["energy_drift_max"]
    assert not found["ensemble_energy_error"]
    torn = replace(fine, p_WB=fine.p_WB.copy())
    torn.p_WB[300:, 3, 0] += 0.001
    assert not verdicts(chaos.CASE, torn)["joint_gap_max"]
    late = replace(fine, p_WB=np.roll(fine.p_WB, 1, axis=0))
    assert not verdicts(chaos.CASE, late)["position_error_max"]


def test_an_ensemble_needs_members_and_swallows_nothing() -> None:
    scene, run = chaos.scene(chaos.P()), chaos.expected(TIME, chaos.P()).trajectory
    energies = kinetic_energies(scene, run.between(0.0, 0.0))
    assert energies.shape == (8,)
    assert not energies.any()
    faster = replace(run, v_WB=1.1 * run.v_WB, w_WB=1.1 * run.w_WB)
    assert ensemble_energy_error(scene, faster, run) == pytest.approx(0.21, rel=1e-12)
    lone = replace(scene, bodies=scene.bodies[:2], joints=scene.joints[:2])
    with pytest.raises(NotMeasurable, match="two members"):
        ensemble_energy_error(lone, run, run)
    broken = replace(run, v_WB=run.v_WB.copy(), p_WB=run.p_WB.copy())
    broken.v_WB[5, 3, 0], broken.p_WB[-1, 2, 0] = np.nan, np.nan
    assert np.isnan(ensemble_energy_error(scene, broken, run))
    assert np.isnan(ensemble_spread(scene, broken, run))


# --- friction_painleve ----------------------------------------------------------------------------

STEPS = np.arange(round(painleve.DURATION * 960) + 1) / 960


def _newton_euler(_t: float, y: Floats, friction: float) -> Floats:
    """x, z, a of the rod under a stiff damped spring at its foot and Coulomb's friction: no constraint, no algebra of loads."""
    (_, z, a), (u, w, turning) = y[:3], y[3:]
    reach_x, reach_z = -painleve.HALF * np.cos(a), -painleve.HALF * np.sin(a) - painleve.RADIUS
    depth = -(z + reach_z)
    closing = -(w + turning * reach_x)
    normal = max(0.0, 1e8 * depth + 2e3 * closing)
    return np.array(
        [u, w, turning, friction * normal, normal - 9.81, (reach_x * normal - reach_z * friction * normal) / painleve.INERTIA]
    )


@pytest.mark.parametrize("friction", [0.3, 0.7, 1.0])
def test_the_rod_obeys_newton_and_euler_on_a_stiff_spring(friction: float) -> None:
    time = STEPS[::10]
    truth = painleve.expected(time, painleve.P(friction))
    assert truth is not None
    start = [0.0, painleve.RADIUS + painleve.HALF * np.sin(np.arctan(2.0)), np.arctan(2.0), -8.0, 0.0, 0.0]
    found = solve_ivp(_newton_euler, (0.0, time[-1]), start, "LSODA", time, rtol=1e-9, atol=1e-11, args=(friction,)).y
    # The spring gives way by N/k = 2.5e-7 m, and takes the milliseconds of its damping to build up its load.
    np.testing.assert_allclose(truth.trajectory.p_WB[:, 1, 0], found[0], atol=3e-5)
    np.testing.assert_allclose(truth.trajectory.p_WB[:, 1, 2], found[1], atol=3e-5)
    np.testing.assert_allclose(truth.trajectory.w_WB[:, 1, 1], -found[5], atol=3e-3)


def test_without_a_radius_the_least_critical_friction_is_four_thirds_at_the_angle_of_two(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(painleve, "RADIUS", 0.0)
    angles = np.radians(np.linspace(1.0, 89.0, 8801))
    critical = (1 + 3 * np.cos(angles) ** 2) / (3 * np.sin(angles) * np.cos(angles))
    assert critical.min() == pytest.approx(4 / 3, rel=1e-7)
    assert np.degrees(angles[np.argmin(critical)]) == pytest.approx(63.43, abs=0.01)
    assert painleve.load(np.arctan(2.0), 0.0, 4 / 3)[0] == pytest.approx(0.0, abs=1e-15)
    assert painleve.load(np.arctan(2.0), 0.0, 1.3)[0] > 0 > painleve.load(np.arctan(2.0), 0.0, 1.4)[0]


def test_the_blow_that_stops_the_foot_is_that_of_the_docstring() -> None:
    """W J = -v of the foot, W = 1/m + r x I^-1 x r in the plane, at tan a = 2 without a radius."""
    c, s = 1 / np.sqrt(5), 2 / np.sqrt(5)
    compliance = np.array([[1 + 3 * s * s, -3 * s * c], [-3 * s * c, 1 + 3 * c * c]])
    np.testing.assert_allclose(np.linalg.solve(compliance, [8.0, 0.0]), [3.2, 2.4], rtol=1e-12)


def test_beyond_the_paradox_and_where_the_foot_stops_there_is_no_truth() -> None:
    assert painleve.expected(STEPS, painleve.P(1.0)) is not None
    assert painleve.expected(STEPS, painleve.P(1.2)) is None  # lifts off
    assert painleve.expected(STEPS, painleve.P(1.5)) is None  # paradox
    assert painleve.expected(STEPS, painleve.P(1.0, speed=1.0)) is None  # stops


def _rod(force: float = 20.0) -> Trajectory:
    made = painleve.expected(STEPS, painleve.P())
    assert made is not None
    contact = Contacts.of([0], [1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], [0.0], [[0.0, 0.0, force]])
    return replace(made.trajectory, dt=1 / 960, contacts=(contact,) * len(STEPS))


def test_the_rod_passes_and_each_fault_fails_its_check() -> None:
    assert all(verdicts(painleve.CASE, _rod()).values())
    assert not verdicts(painleve.CASE, _rod(force=20_000.0))["impulse_max"]
    stuck = _rod()
    stuck.p_WB[:, 1, 0] *= 0.98
    assert not verdicts(painleve.CASE, stuck)["position_error_max"]
    thrown = _rod()
    thrown.v_WB[5, 1, 2] += 3.0
    assert not verdicts(painleve.CASE, thrown)["energy_gain_max"]


def test_impulses_and_the_coefficient_are_as_planted_and_nothing_is_swallowed() -> None:
    scene, run = painleve.scene(painleve.P()), _rod()
    assert impulse_max(scene, run) == pytest.approx(20.0 / 960, rel=1e-12)
    odd = replace(run.contacts[0], force_W=np.array([[np.nan, 0.0, 0.0]]))  # type: ignore[index]
    assert np.isnan(impulse_max(scene, replace(run, contacts=(*run.contacts[:3], odd, *run.contacts[4:]))))  # type: ignore[index]
    with pytest.raises(NotMeasurable, match="no contacts"):
        impulse_max(scene, replace(run, contacts=None))
    angles = 2 * np.arctan2(run.q_WB[:, 1, 2], run.q_WB[:, 1, 0])
    by_hand = min(painleve.load(np.pi / 2 - float(a), 0.0, 1.0)[0] for a in angles)
    assert painleve_coefficient(scene, run) == pytest.approx(by_hand, rel=1e-12)
    assert painleve_coefficient(painleve.scene(painleve.P(friction=1.5)), run) < 0
    run.q_WB[3] = np.nan
    assert np.isnan(painleve_coefficient(scene, run))
    with pytest.raises(NotMeasurable, match="no rod"):
        painleve_coefficient(
            replace(scene, bodies=(scene.bodies[0], replace(scene.bodies[1], collision=scene.bodies[1].collision[:1]))), _rod()
        )
