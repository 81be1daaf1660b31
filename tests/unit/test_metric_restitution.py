"""Restitution metrics on parabolas made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.impacts import (
    bounce_gain,
    bounce_height_error,
    bouncing_time_error,
    impact_time_error,
    later_restitution_error,
    restitution_error,
)
from plumbline.harness.scene import Body, PlacedShape, Plane, Scene, Sphere, Surface
from plumbline.harness.trajectory import Floats, Trajectory

G, R, H = 9.81, 0.2, 0.8


def stage(restitution: float) -> Scene:
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),), p_WB=(0.0, 0.0, 1.0))
    ball = Body(name="ball", collision=(PlacedShape(shape=Sphere(radius=R)),), p_WB=(0.0, 0.0, 1.0 + R + H))
    return Scene(bodies=(ground, ball), surfaces=(Surface(restitution=restitution),))


def run(restitutions: list[float], interval: float = 1 / 240, shift: float = 0.0, duration: float = 3.0) -> Trajectory:
    """A drop from H over ground at z = 1, with these restitutions one after another, then rest; impacts `shift` [s] late."""
    time: Floats = np.arange(round(duration / interval) + 1) * interval
    trajectory = replace(Trajectory.of(time, 2), dt=interval)
    gap = np.where(time < shift, H, H - G * (time - shift) ** 2 / 2)
    landing, speed = math.sqrt(2 * H / G) + shift, math.sqrt(2 * H * G)
    for e in restitutions:
        speed *= e
        gap = np.where(time >= landing, speed * (time - landing) - G * (time - landing) ** 2 / 2, gap)
        landing += 2 * speed / G
    trajectory.p_WB[:, 1, 2] = 1.0 + R + np.where(time >= landing, 0.0, gap)
    return trajectory


@pytest.mark.parametrize("interval", [1 / 60, 1 / 240, 1 / 1920])
@pytest.mark.parametrize("found", [0.1, 0.45, 0.5, 0.62, 1.0])
def test_the_error_is_that_of_the_first_impact_at_any_sampling(found: float, interval: float) -> None:
    # Parabolas are read exactly; what is left is rounding, far below 1e-6. The hop of 0.1 lasts 81 ms, four samples at least.
    assert restitution_error(stage(0.5), run([found, 0.5], interval)) == pytest.approx(abs(found - 0.5), abs=1e-6)
    assert bounce_height_error(stage(0.5), run([found, 0.5], interval)) == pytest.approx(abs(found**2 - 0.25), abs=1e-6)


def test_no_bounce_at_all_counts_as_restitution_zero() -> None:
    assert restitution_error(stage(0.5), run([0.0])) == 0.5
    assert restitution_error(stage(0.0), run([0.0])) == 0.0


def test_a_ball_that_hangs_in_the_air_has_no_restitution() -> None:
    hanging = run([0.5])
    hanging.p_WB[:, 1, 2] = 1.0 + R + H
    assert math.isnan(restitution_error(stage(0.0), hanging))


def test_later_bounces_are_judged_by_themselves() -> None:
    truth = run([0.8, 0.8, 0.8, 0.8])
    assert later_restitution_error(stage(0.8), truth, truth) == pytest.approx(0.0, abs=1e-6)
    assert later_restitution_error(stage(0.8), run([0.8, 0.8, 0.7, 0.8]), truth) == pytest.approx(0.1, abs=1e-6)
    assert later_restitution_error(stage(0.8), run([0.8, 0.0]), truth) == pytest.approx(0.8, abs=1e-6)


def test_bounces_slower_than_half_the_first_are_not_asked() -> None:
    with pytest.raises(NotMeasurable, match="half the speed"):
        later_restitution_error(stage(0.3), run([0.3, 0.3]), run([0.3, 0.3]))


def test_a_late_impact_is_seen_between_samples() -> None:
    truth = run([0.5, 0.5], 1 / 60)
    assert impact_time_error(stage(0.5), truth, truth) == pytest.approx(0.0, abs=1e-9)
    assert impact_time_error(stage(0.5), run([0.5, 0.5], 1 / 60, shift=0.0031), truth) == pytest.approx(0.0031, abs=1e-7)


def test_a_missing_second_flight_makes_the_time_error_infinite() -> None:
    assert impact_time_error(stage(0.5), run([0.0]), run([0.5, 0.5])) == math.inf


def test_the_worst_single_bounce_is_the_gain_and_where_all_lose_it_is_below_zero() -> None:
    assert bounce_gain(stage(1.0), run([1.0, 1.02, 1.01, 0.9])) == pytest.approx(1.02**2 - 1, abs=1e-6)
    assert bounce_gain(stage(0.9), run([0.9, 0.8])) == pytest.approx(0.9**2 - 1, abs=1e-6)


def test_a_bounce_slower_than_half_the_first_is_no_gain() -> None:
    assert bounce_gain(stage(0.4), run([0.4, 1.5])) == pytest.approx(0.4**2 - 1, abs=1e-6)


def test_the_staggered_fall_of_semi_implicit_euler_is_no_gain() -> None:
    dt = 1 / 240
    trajectory = run([0.5], dt)
    k = np.arange(math.floor(math.sqrt(2 * H / G) / dt))
    trajectory.p_WB[k, 1, 2] = 1.0 + R + H - G * dt**2 * k * (k + 1) / 2
    # Its parabola's apex lies g dt^2/8 above the start, from which the bounce then rises by less.
    assert bounce_gain(stage(0.5), trajectory) == pytest.approx(0.5**2 / (1 + G * dt**2 / 8 / H) - 1, rel=1e-6)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize(
    "metric", [bounce_height_error, restitution_error, later_restitution_error, impact_time_error, bounce_gain]
)
def test_what_is_not_finite_is_never_swallowed(metric: object, bad: float) -> None:
    trajectory = run([0.9, 0.9])
    trajectory.v_WB[-1, 1, 0] = bad
    assert callable(metric)
    assert not math.isfinite(metric(stage(0.9), trajectory, run([0.9, 0.9])))


def test_a_scene_without_a_ball_over_a_plane_is_not_measurable() -> None:
    nothing = Scene(bodies=(Body(name="free"),))
    with pytest.raises(NotMeasurable, match="no ball"):
        restitution_error(nothing, Trajectory.of(np.arange(9.0), 1))


@pytest.mark.parametrize("bounces", [1, 2, 4])
def test_bouncing_that_ends_early_is_off_by_the_hops_that_are_missing(bounces: int) -> None:
    truth, lazy = run([0.5] * 6), run([0.5] * bounces)
    assert bouncing_time_error(stage(0.5), truth, truth) == 0.0
    fall = math.sqrt(2 * H / G)
    missing = sum(2 * fall * 0.5**n for n in range(bounces + 1, 7))
    # Hops are left and begun at 1e-4 of the drop, within a sample of the ground.
    assert bouncing_time_error(stage(0.5), lazy, truth) == pytest.approx(missing, abs=2 / 240)


def test_no_end_is_asked_of_a_ball_that_bounces_on_and_nothing_is_swallowed() -> None:
    with pytest.raises(NotMeasurable, match="comes to rest"):
        bouncing_time_error(stage(1.0), run([1.0] * 9), run([1.0] * 9))
    with pytest.raises(NotMeasurable, match="no truth"):
        bouncing_time_error(stage(0.5), run([0.5]), None)
    broken = run([0.5])
    broken.p_WB[3, 1, 2] = math.nan
    assert math.isnan(bouncing_time_error(stage(0.5), broken, run([0.5])))
