"""Radius, limits and the trend of energy: a clean answer measures nothing, a planted fault by as much as was planted."""

import numpy as np
import pytest

from plumbline.cases import flight_projectile, joint_conical_pendulum, joint_limits, joint_long_run, joint_pendulum
from plumbline.harness.case import Case
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.conservation import energy_growth_rate
from plumbline.harness.metrics.errors import radius_error_final, radius_error_max
from plumbline.harness.metrics.joints import limit_overshoot_final, limit_overshoot_max
from plumbline.harness.trajectory import Floats, Trajectory


def _at(case: Case, time: Floats, **parameters: object) -> Trajectory:
    truth = case.truth_at(time, {**case.parameters, **parameters})
    assert isinstance(truth, Trajectory)
    return truth


def test_a_circle_too_wide_is_seen_by_its_share() -> None:
    case, time = joint_conical_pendulum.CASE, np.linspace(0.0, 2.0, 121)
    truth, wide = _at(case, time), _at(case, time)
    assert radius_error_max(case.scene(case.parameters), truth, truth) == 0
    wide.p_WB[60, 0, :2] *= 1.07
    assert radius_error_max(case.scene(case.parameters), wide, truth) == pytest.approx(0.07, rel=1e-12)
    assert radius_error_final(case.scene(case.parameters), wide, truth) == 0
    wide.p_WB[5] = np.nan
    assert np.isnan(radius_error_max(case.scene(case.parameters), wide, truth))
    assert np.isnan(radius_error_final(case.scene(case.parameters), wide, truth))


def test_a_truth_through_the_axis_has_no_radius() -> None:
    case = flight_projectile.CASE
    truth = _at(case, np.linspace(0.0, 1.0, 3))
    with pytest.raises(NotMeasurable, match="no radius"):
        radius_error_max(case.scene(case.parameters), truth, truth)


def test_a_stop_that_gives_way_is_seen_by_its_angle() -> None:
    case, time = joint_limits.CASE, np.linspace(0.0, 3.0, 721)
    truth = _at(case, time)
    # The stop lies at an angle that rounds.
    assert limit_overshoot_max(case.scene(case.parameters), truth) < 1e-14
    soft = _at(case, time, stop=18.0)
    assert limit_overshoot_max(case.scene(case.parameters), soft) == pytest.approx(np.radians(2.0), rel=1e-9)
    assert limit_overshoot_final(case.scene(case.parameters), soft) == pytest.approx(np.radians(2.0), rel=1e-9)
    soft.q_WB[3] = np.nan
    assert np.isnan(limit_overshoot_max(case.scene(case.parameters), soft))
    with pytest.raises(NotMeasurable, match="no joint"):
        limit_overshoot_max(joint_pendulum.CASE.scene(joint_pendulum.CASE.parameters), _at(joint_pendulum.CASE, time))


def test_a_swing_has_no_trend_and_a_loss_has_its_own() -> None:
    case, scene = joint_pendulum.CASE, joint_long_run.CASE.scene(joint_long_run.CASE.parameters)
    time = np.linspace(0.0, 100.0, 2001)
    truth = _at(case, time, amplitude=joint_long_run.AMPLITUDE)
    # The closed form's energy is constant to rounding.
    assert energy_growth_rate(scene, truth, truth) < 1e-14
    swinging = _at(case, time, amplitude=joint_long_run.AMPLITUDE)
    swinging.v_WB[:] *= 1 + 0.01 * np.sin(3 * time)[:, None, None]
    assert energy_growth_rate(scene, swinging, truth) < 2e-5
    # Velocities that fall to 0.9 in 100 s lose 0.1 of the kinetic energy's mean half, doubled by the square.
    fading = _at(case, time, amplitude=joint_long_run.AMPLITUDE)
    factor = np.sqrt(1 - 0.2 * time / 100)[:, None, None]
    fading.v_WB[:] *= factor
    fading.w_WB[:] *= factor
    rate = energy_growth_rate(scene, fading, truth)
    assert 0.0005 < rate < 0.0015
    fading.v_WB[7] = np.inf
    assert not np.isfinite(energy_growth_rate(scene, fading, truth))
