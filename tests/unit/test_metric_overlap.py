"""Overlap of balls and planes: zero where they touch, the depth where one is planted, and no swallowing of bad numbers."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.cases import stack_tower
from plumbline.cases.stack_pile import RADIUS, P, expected, scene
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.overlaps import overlap
from plumbline.harness.scene import Body, PlacedShape, Scene, Sphere, Surface
from plumbline.harness.trajectory import Trajectory

FIRST = 5  # after the floor and four walls
ROUNDING = 1e-15  # a few roundings of coordinates below 1 m


def rest(n: int = 20) -> Trajectory:
    return expected(np.arange(3) / 20, P(n=n))


def test_a_packing_that_touches_does_not_overlap() -> None:
    assert overlap(scene(P(n=20)), rest()) == pytest.approx(0.0, abs=ROUNDING)


def test_a_ball_pushed_into_another_overlaps_by_that_much() -> None:
    run = rest()
    way = run.p_WB[0, FIRST + 1] - run.p_WB[0, FIRST]
    run.p_WB[1, FIRST] += 1e-4 * way / np.linalg.norm(way)
    assert overlap(scene(P(n=20)), run) == pytest.approx(1e-4, abs=ROUNDING)


def test_two_large_balls_beside_a_small_one_overlap_by_their_depth() -> None:
    """Their centres are farther apart than a large and a small ball could touch at."""
    balls = [
        Body(name=name, mass=1.0, collision=(PlacedShape(shape=Sphere(radius=radius)),))
        for name, radius in (("a", 1.0), ("b", 1.0), ("small", 0.1))
    ]
    run = Trajectory.of(np.zeros(1), 3)
    run.p_WB[0] = [[0.0, 0.0, 0.0], [1.5, 0.0, 0.0], [0.0, 9.0, 0.0]]
    free = Surface(between=("default", "default"), static_friction=0.0, kinetic_friction=0.0, restitution=0.0)
    assert overlap(Scene(bodies=tuple(balls), surfaces=(free,)), run) == pytest.approx(0.5)


@pytest.mark.parametrize(("wall", "direction"), [("floor", (0, 0, -1)), ("west", (-1, 0, 0)), ("north", (0, 1, 0))])
def test_a_ball_that_left_the_container_overlaps_its_wall_by_more_than_a_radius(
    wall: str, direction: tuple[float, float, float]
) -> None:
    run = rest()
    run.p_WB[2, FIRST] += 3.0 * np.array(direction)
    assert overlap(scene(P(n=20)), run) > RADIUS


def test_what_is_not_finite_is_never_swallowed() -> None:
    run = rest()
    run.p_WB[1, FIRST, 0] = math.nan
    assert math.isnan(overlap(scene(P(n=20)), run))


def test_boxes_and_empty_windows_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="no single ball"):
        overlap(stack_tower.scene(stack_tower.P()), Trajectory.of(np.zeros(1), 11))
    with pytest.raises(NotMeasurable, match="sample"):
        overlap(scene(P(n=20)), replace(rest()).between(9.0, 10.0))
