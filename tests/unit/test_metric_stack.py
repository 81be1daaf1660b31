"""Stack metrics on towers moved by hand."""

import math

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.stack import lean, residual_kinetic_energy, stack_height_error, standing_height
from plumbline.harness.scene import Body, Scene, axis_angle, principal_inertia
from plumbline.harness.trajectory import Trajectory

METRICS = (stack_height_error, standing_height, lean, residual_kinetic_energy)

INERTIA = principal_inertia(1.0, 2.0, 2.5)
# The highest movable body stands in the middle of the list, under a lamp that is fixed.
STAGE = Scene(
    bodies=(
        Body(name="low", mass=2.0, p_WB=(0.0, 0.0, 1.0), inertia=INERTIA),
        Body(name="top", mass=2.0, p_WB=(0.0, 0.0, 4.0), inertia=INERTIA),
        Body(name="lamp", motion="static", p_WB=(0.0, 0.0, 9.0)),
    )
)


def stand() -> Trajectory:
    run = Trajectory.of(np.arange(11) * 0.1, 3)
    run.p_WB[:] = [b.p_WB for b in STAGE.bodies]
    return run


def test_a_standing_tower_has_full_height_and_no_error() -> None:
    assert [m(STAGE, stand()) for m in (stack_height_error, standing_height, lean, residual_kinetic_energy)] == [
        0.0,
        1.0,
        0.0,
        0.0,
    ]


@pytest.mark.parametrize(("change", "error"), [(-0.2, 0.05), (0.2, 0.05), (-3.0, 0.75)])
def test_sinking_and_rising_are_both_errors_of_height(change: float, error: float) -> None:
    run = stand()
    run.p_WB[4, 1, 2] += change
    assert stack_height_error(STAGE, run) == pytest.approx(error)
    assert standing_height(STAGE, run) == pytest.approx(min(1.0, 1 + change / 4))


def test_lean_is_the_farthest_any_movable_body_went_aside() -> None:
    run = stand()
    run.p_WB[3, 0, :2] = (0.3, -0.4)
    run.p_WB[:, 2, 0] = 7.0
    assert lean(STAGE, run) == pytest.approx(0.5)


def test_kinetic_energy_is_per_mass_and_takes_the_inertia_along() -> None:
    run = stand()
    run.v_WB[:, 0] = (0.0, 3.0, 0.0)
    # Turned by a quarter about z, the body's x axis (moment 1) lies along y.
    run.q_WB[:, 1] = axis_angle((0.0, 0.0, 1.0), math.pi / 2)
    run.w_WB[:, 1] = (0.0, 4.0, 0.0)
    assert residual_kinetic_energy(STAGE, run) == pytest.approx((0.5 * 2 * 9 + 0.5 * 1.0 * 16) / 4)


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(metric: object, bad: float) -> None:
    run = stand()
    run.p_WB[5, 0, 0] = bad
    assert callable(metric)
    assert math.isnan(metric(STAGE, run))


@pytest.mark.parametrize("metric", METRICS)
def test_no_samples_are_not_measurable(metric: object) -> None:
    assert callable(metric)
    with pytest.raises(NotMeasurable, match="no sample"):
        metric(STAGE, stand().between(5.0, 6.0))
