"""Tunnelling metrics on shots placed by hand, and Wilson's interval against tables, scipy.stats and its defining equation."""

import math

import numpy as np
import pytest
from scipy.stats import binomtest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.passage import stop_gap, tunnel_probability, tunnel_probability_high, tunnel_probability_low
from plumbline.harness.scene import Body, Box, PlacedShape, Scene, Sphere, Surface, axis_angle, rotate
from plumbline.harness.statistics.student import Z_95, wilson_interval
from plumbline.harness.trajectory import Trajectory

METRICS = (tunnel_probability, tunnel_probability_low, tunnel_probability_high, stop_gap)

R, HALF = 0.1, 0.02


def stage(count: int, azimuth: float = 0.0) -> Scene:
    """A wall across a shot towards `azimuth` [rad] through (1, 2, 3), and `count` spheres on their way."""
    turn = axis_angle((0.0, 0.0, 1.0), azimuth)
    wall = Body(
        name="wall",
        motion="static",
        material="wall",
        collision=(PlacedShape(shape=Box(half_extents=(HALF, 50.0, 1.0))),),
        p_WB=(1.0, 2.0, 3.0),
        q_WB=turn,
    )
    way = rotate(turn, (10.0, 0.0, 0.0))
    spheres = tuple(
        Body(name=f"s{i}", material="sphere", collision=(PlacedShape(shape=Sphere(radius=R)),), v_WB=way) for i in range(count)
    )
    return Scene(bodies=(wall, *spheres), surfaces=(Surface(between=("wall", "sphere")),), apart=(("sphere", "sphere"),))


def end(scene: Scene, places: list[float]) -> Trajectory:
    """A run that ends with each centre `place` [m] beyond the middle of the wall along the shot."""
    run = Trajectory.of(np.array([0.0, 1.0]), len(scene.bodies))
    wall = scene.bodies[0]
    for i, place in enumerate(places, start=1):
        way = np.array(rotate(wall.q_WB, (1.0, 0.0, 0.0)))
        side = np.array(rotate(wall.q_WB, (0.0, 1.0, 0.0)))
        run.p_WB[1, i] = np.array(wall.p_WB) + place * way + i * side
    return run


@pytest.mark.parametrize("azimuth", [0.0, 1.0, math.pi])
@pytest.mark.parametrize(
    ("place", "passed"),
    [(-5.0, 0), (-HALF - R, 0), (-R + 0.001, 0), (-HALF, 0), (-1e-6, 0), (1e-6, 1), (HALF + R + 0.001, 1), (300.0, 1)],
)
def test_a_sphere_has_passed_when_its_centre_ends_beyond_the_middle(place: float, passed: int, azimuth: float) -> None:
    scene = stage(1, azimuth)
    assert tunnel_probability(scene, end(scene, [place])) == passed


def test_the_share_is_that_of_all_shots_with_its_wilson_bounds() -> None:
    scene = stage(8)
    run = end(scene, [-1.0, -1.0, 0.01, 9.0, 9.0, -1.0, -1.0, -1.0])
    assert tunnel_probability(scene, run) == 3 / 8
    assert (tunnel_probability_low(scene, run), tunnel_probability_high(scene, run)) == wilson_interval(3, 8)


def test_the_stop_gap_is_the_farthest_end_of_a_stopped_sphere() -> None:
    scene = stage(4)
    assert stop_gap(scene, end(scene, [-HALF - R, -HALF - R, -HALF - R - 0.5, 9.0])) == pytest.approx(0.5)
    assert stop_gap(scene, end(scene, [-R - 0.001] * 4)) == 0.0
    with pytest.raises(NotMeasurable, match="no sphere is stopped"):
        stop_gap(scene, end(scene, [9.0] * 4))


@pytest.mark.parametrize(("hits", "trials"), [(0, 64), (1, 64), (3, 8), (32, 64), (63, 64), (64, 64), (15, 148), (1, 1)])
def test_wilsons_interval_is_its_formula_and_ends_at_nothing_and_at_all(hits: int, trials: int) -> None:
    share, square = hits / trials, Z_95**2 / trials
    half = Z_95 * math.sqrt(share * (1 - share) / trials + square / (4 * trials))
    formula = [(share + square / 2 + side * half) / (1 + square) for side in (-1, 1)]
    low, high = wilson_interval(hits, trials)
    assert (low, high) == pytest.approx(formula, abs=1e-12)
    assert (low == 0.0, high == 1.0) == (hits == 0, hits == trials)


def test_wilsons_interval_agrees_with_a_published_example() -> None:
    # Newcombe, Statistics in Medicine 17 (1998) 857, table I: 15 of 148, and 0 of 20.
    assert wilson_interval(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert wilson_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)


def test_wilsons_interval_is_scipys_to_the_last_bit() -> None:
    for trials in (1, 2, 7, 64, 100):
        for hits in range(trials + 1):
            assert wilson_interval(hits, trials) == binomtest(hits, trials).proportion_ci(0.95, method="wilson")


@pytest.mark.parametrize(("hits", "trials"), [(2, 10), (31, 64), (5, 500)])
def test_at_each_bound_the_observation_lies_z_deviations_off(hits: int, trials: int) -> None:
    for bound in wilson_interval(hits, trials):
        assert abs(hits / trials - bound) == pytest.approx(Z_95 * math.sqrt(bound * (1 - bound) / trials))


@pytest.mark.parametrize(("hits", "trials"), [(-1, 5), (6, 5), (0, 0)])
def test_impossible_counts_are_refused(hits: int, trials: int) -> None:
    with pytest.raises(ValueError, match="expected 0 <= hits"):
        wilson_interval(hits, trials)


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_never_swallowed(metric: object, bad: float) -> None:
    scene = stage(2)
    run = end(scene, [-1.0, -1.0])
    run.p_WB[1, 2, 0] = bad
    assert callable(metric)
    assert math.isnan(metric(scene, run))


def test_a_scene_without_a_wall_or_a_shot_is_not_measurable() -> None:
    run = Trajectory.of(np.array([0.0, 1.0]), 1)
    with pytest.raises(NotMeasurable, match="no wall"):
        tunnel_probability(Scene(bodies=(Body(name="free"),)), run)
    with pytest.raises(NotMeasurable, match="no sphere"):
        tunnel_probability(Scene(bodies=(stage(1).bodies[0],)), run)
