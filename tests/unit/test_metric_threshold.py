"""Threshold metrics on ways made by hand."""

import math

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.statics import incline_acceleration_error, threshold_angle_error
from plumbline.harness.scene import Body, Box, PlacedShape, Scene, Surface, axis_angle, rotate
from plumbline.harness.trajectory import Trajectory

MU, G, T = 0.6, 9.81, 2.0
SHAPE = (PlacedShape(shape=Box(half_extents=(0.1, 0.1, 0.1))),)


def stage(tangents: list[float], azimuth: float = 0.0) -> Scene:
    """Boxes on inclines that fall towards `azimuth` [rad]; where they stand plays no part."""
    axis = (-math.sin(azimuth), math.cos(azimuth), 0.0)
    boxes = tuple(
        Body(name=f"b{i}", q_WB=axis_angle(axis, math.atan(t)), collision=SHAPE, material="box") for i, t in enumerate(tangents)
    )
    incline = Body(name="incline", motion="static", collision=SHAPE, material="incline")
    law = Surface(between=("box", "incline"), static_friction=MU, kinetic_friction=MU)
    return Scene(bodies=(incline, *boxes), surfaces=(law,), apart=(("box", "box"),))


def run(scene: Scene, tangents: list[float], mu: float, azimuth: float = 0.0) -> Trajectory:
    """Coulomb's ways with friction mu, in closed form."""
    time = np.linspace(0.0, T, 21)
    trajectory = Trajectory.of(time, len(scene.bodies))
    for place, tangent in enumerate(tangents, start=1):
        angle = math.atan(tangent)
        a = max(0.0, G * (math.sin(angle) - mu * math.cos(angle)))
        down = (math.cos(azimuth) * math.cos(angle), math.sin(azimuth) * math.cos(angle), -math.sin(angle))
        np.testing.assert_allclose(
            rotate(scene.bodies[place].q_WB, (math.cos(azimuth), math.sin(azimuth), 0.0)), down, atol=1e-12
        )
        trajectory.p_WB[:, place] = np.outer(a * time**2 / 2, down)
    return trajectory


TANGENTS = [0.3, 0.5, 0.55, 0.59, 0.61, 0.65, 0.7, 0.9]


@pytest.mark.parametrize("azimuth", [0.0, 0.7, -2.5])
def test_the_true_friction_has_no_error_whichever_way_the_inclines_face(azimuth: float) -> None:
    scene = stage(TANGENTS, azimuth)
    actual = run(scene, TANGENTS, MU, azimuth)
    middle = (math.atan(0.59) + math.atan(0.61)) / 2
    assert threshold_angle_error(scene, actual) == pytest.approx(abs(middle / math.atan(MU) - 1), abs=1e-12)
    assert incline_acceleration_error(scene, actual) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("mu", "low", "high"), [(0.52, 0.5, 0.55), (0.68, 0.65, 0.7), (5.0, 0.9, math.inf), (0.0, 0.0, 0.3)])
def test_a_wrong_friction_moves_the_bracket(mu: float, low: float, high: float) -> None:
    scene = stage(TANGENTS)
    middle = (math.atan(low) + math.atan(high)) / 2
    actual = run(scene, TANGENTS, mu)
    assert threshold_angle_error(scene, actual) == pytest.approx(abs(middle / math.atan(MU) - 1), rel=1e-9)


def test_the_acceleration_error_is_the_friction_that_is_missing() -> None:
    scene = stage(TANGENTS)
    # The flattest slider has the greatest normal force, so that 0.1 less friction is felt most there.
    assert incline_acceleration_error(scene, run(scene, TANGENTS, MU - 0.1)) == pytest.approx(0.1 * math.cos(math.atan(0.61)))


@pytest.mark.parametrize("metric", [threshold_angle_error, incline_acceleration_error])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_never_swallowed(metric: object, bad: float) -> None:
    scene = stage(TANGENTS)
    actual = run(scene, TANGENTS, MU)
    actual.p_WB[-1, 2] = bad
    assert callable(metric)
    assert math.isnan(metric(scene, actual))


def test_inclines_of_different_friction_have_no_common_threshold() -> None:
    other = Body(name="c", q_WB=axis_angle((0, 1, 0), 0.3), collision=SHAPE, material="c")
    base = stage([0.3])
    scene = Scene(
        bodies=(*base.bodies, other),
        surfaces=(*base.surfaces, Surface(between=("c", "incline"), static_friction=0.1, kinetic_friction=0.1)),
        apart=(("c", "box"),),
    )
    with pytest.raises(NotMeasurable, match="differ in friction"):
        threshold_angle_error(scene, Trajectory.of(np.array([0.0, 1.0]), 3))
    with pytest.raises(NotMeasurable, match="steep enough"):
        incline_acceleration_error(base, Trajectory.of(np.array([0.0, 1.0]), 2))
