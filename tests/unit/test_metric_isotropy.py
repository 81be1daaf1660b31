"""Isotropy metrics on displacements made by hand."""

import math

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.slide import heading_error, polar_spread
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Trajectory


def stage(azimuths: list[float]) -> Scene:
    pushed = tuple(
        Body(name=f"b{i}", p_WB=(float(i), 2.0, 0.0), v_WB=(3 * math.cos(a), 3 * math.sin(a), 0.0))
        for i, a in enumerate(azimuths)
    )
    return Scene(bodies=(*pushed, Body(name="still", motion="static")))


def run(scene: Scene, ways: list[float], turn: float = 0.0) -> Trajectory:
    """Each pushed body ends `way` [m] from its start, `turn` [rad] off its push."""
    trajectory = Trajectory.of(np.array([0.0, 1.0]), len(scene.bodies))
    trajectory.p_WB[:] = [b.p_WB for b in scene.bodies]
    for i, way in enumerate(ways):
        azimuth = math.atan2(scene.bodies[i].v_WB[1], scene.bodies[i].v_WB[0]) + turn
        trajectory.p_WB[1, i, :2] += (way * math.cos(azimuth), way * math.sin(azimuth))
    return trajectory


AZIMUTHS = [0.0, 0.4, 1.2, 2.8, -2.0]


def test_equal_ways_have_no_spread_in_any_direction() -> None:
    scene = stage(AZIMUTHS)
    assert polar_spread(scene, run(scene, [0.7] * 5)) == pytest.approx(0.0, abs=1e-14)
    assert heading_error(scene, run(scene, [0.7] * 5)) == pytest.approx(0.0, abs=1e-14)


def test_the_spread_is_the_range_over_the_mean() -> None:
    scene = stage(AZIMUTHS)
    assert polar_spread(scene, run(scene, [1.0, 1.0, 1.41, 1.0, 0.71])) == pytest.approx(0.70 / (5.12 / 5))


@pytest.mark.parametrize("turn", [-0.3, 0.05, 2.0])
def test_a_turned_path_has_its_angle_as_error(turn: float) -> None:
    scene = stage(AZIMUTHS)
    assert heading_error(scene, run(scene, [0.5] * 5, turn)) == pytest.approx(abs(turn))


@pytest.mark.parametrize("metric", [polar_spread, heading_error])
def test_bodies_that_did_not_move_or_are_not_finite_give_no_number(metric: object) -> None:
    scene = stage(AZIMUTHS)
    broken = run(scene, [0.5] * 5)
    broken.q_WB[0, 1, 0] = math.nan
    assert callable(metric)
    assert math.isnan(metric(scene, broken))
    assert math.isnan(metric(scene, run(scene, [0.0] * 5)))


def test_one_push_has_no_spread_to_measure() -> None:
    scene = stage([0.0])
    with pytest.raises(NotMeasurable, match="1 bodies are pushed"):
        polar_spread(scene, run(scene, [1.0]))
