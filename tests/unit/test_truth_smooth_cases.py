"""What every smooth and every sensor case promises: a truth at any times, a ladder, a headline, and samples that stay few."""

import numpy as np
import pytest

from plumbline.cases import (
    flight_damped,
    flight_projectile,
    joint_conical_pendulum,
    joint_double_pendulum,
    joint_fourbar,
    joint_limits,
    joint_pendulum,
    joint_spring,
    sensor_imu_noise,
    sensor_lidar_noise,
    spin_asymmetric_top,
    spin_fast,
    spin_heavy_top,
    spin_intermediate_axis,
    spin_principal,
    spin_symmetric_top,
)
from plumbline.harness.case import Case, Converged
from plumbline.harness.trajectory import State

SMOOTH = (
    flight_damped,
    flight_projectile,
    joint_conical_pendulum,
    joint_double_pendulum,
    joint_fourbar,
    joint_limits,
    joint_pendulum,
    joint_spring,
    spin_asymmetric_top,
    spin_fast,
    spin_heavy_top,
    spin_intermediate_axis,
    spin_principal,
    spin_symmetric_top,
)
CASES = [module.CASE for module in (*SMOOTH, sensor_imu_noise, sensor_lidar_noise)]


ROUNDING = {"velocity_error_max", "angular_velocity_error_max"}
"""Where only rounding is left to allow for, more steps make more of it."""


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
@pytest.mark.parametrize("time", [[], [0.0], [0.0, 0.1]], ids=["none", "start", "two"])
def test_a_truth_answers_at_no_one_and_two_instants(case: Case, time: list[float]) -> None:
    truth = case.truth_at(np.array(time), case.parameters)
    trajectory = truth.trajectory if isinstance(truth, Converged) else truth
    assert trajectory is not None
    assert len(trajectory) == len(time)
    assert trajectory.finite


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_a_truth_starts_in_the_state_of_the_scene(case: Case) -> None:
    truth = case.truth_at(np.zeros(1), case.parameters)
    trajectory = truth.trajectory if isinstance(truth, Converged) else truth
    assert trajectory is not None
    start = State.initial(case.scene(case.parameters))
    for array in ("p_WB", "q_WB", "v_WB", "w_WB"):
        np.testing.assert_allclose(getattr(trajectory, array)[0], getattr(start, array), atol=1e-12)


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_a_case_has_six_steps_a_headline_it_measures_and_at_most_two_thousand_samples(case: Case) -> None:
    assert len(set(case.ladder)) >= 6
    assert case.headline in {metric.name for metric in case.metrics}
    assert case.duration / case.sample_interval <= 2000 + 1e-6
    for check in case.checks:
        assert np.isfinite([check.bound(dt, case.parameters) for dt in case.ladder]).all()
        assert len(check.because) > 10


@pytest.mark.parametrize("case", [m.CASE for m in SMOOTH if m not in (spin_fast, spin_principal)], ids=lambda c: c.name)
def test_bounds_of_errors_shrink_with_the_time_step(case: Case) -> None:
    # Left out: a bound on what is possible at all, and one that allows for a rounding every step.
    shrinking = [check for check in case.checks if callable(check.at_most) and check.metric.name not in ROUNDING]
    assert shrinking
    for check in shrinking:
        bounds = [check.bound(dt, case.parameters) for dt in sorted(case.ladder)]
        assert bounds == sorted(bounds)
        assert bounds[0] < bounds[-1]
