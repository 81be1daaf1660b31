"""Which bodies touch at the start, by hand; and the starts of an ensemble, which open no gap between them."""

import math

import numpy as np
import pytest

from plumbline.harness.case.starts import PRESSED, TOLERANCE, member
from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    PlacedShape,
    Plane,
    Scene,
    Sphere,
    Surface,
    axis_angle,
)
from plumbline.harness.scene.shape import Shape
from plumbline.harness.study import plugins
from plumbline.harness.trajectory.touching import reach, touches

RULES = (Surface(static_friction=0.5, kinetic_friction=0.5),)
FLOOR = Body(name="floor", motion="static", collision=(PlacedShape(shape=Plane()),))
BOX, BALL = Box(half_extents=(0.1, 0.2, 0.3)), Sphere(radius=0.1)
LYING = axis_angle((1.0, 0.0, 0.0), math.pi / 2)


def body(
    name: str, shape: Shape, where: tuple[float, float, float], turn: tuple[float, float, float, float] | None = None
) -> Body:
    return Body(name=name, collision=(PlacedShape(shape=shape),), p_WB=where, q_WB=turn or (1.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("shape", "height", "turn"),
    [
        (BOX, 0.3, None),
        (BOX, 0.2, LYING),
        (BOX, 0.1 * math.sin(0.3) + 0.3 * math.cos(0.3), axis_angle((0.0, 1.0, 0.0), 0.3)),
        (BALL, 0.1, None),
        (Capsule(radius=0.1, half_length=0.2), 0.3, None),
        (Capsule(radius=0.1, half_length=0.2), 0.1, LYING),
        (Ellipsoid(semi_axes=(0.1, 0.3, 0.2)), 0.2, None),
        (Ellipsoid(semi_axes=(0.1, 0.2, 0.3)), 0.2, LYING),
        (Cylinder(radius=0.1, half_length=0.2), 0.2, None),
        (Cylinder(radius=0.1, half_length=0.2), 0.1, LYING),
    ],
)
def test_what_stands_on_the_floor_touches_it_upwards_and_what_hovers_or_is_sunk_does_not(
    shape: Shape, height: float, turn: tuple[float, float, float, float] | None
) -> None:
    for off, touching in ((0.0, True), (1e-6, False), (-1e-6, False)):
        found = touches(Scene(bodies=(FLOOR, body("one", shape, (0.3, 0.2, height + off), turn)), surfaces=RULES))
        assert [(one.first, one.second) for one in found] == ([(0, 1)] if touching else [])
        for one in found:
            np.testing.assert_allclose(one.normal, (0.0, 0.0, 1.0), atol=1e-12)


def test_balls_touch_along_the_line_of_their_centres_and_boxes_edge_on_edge() -> None:
    way = np.array([1.0, 2.0, 2.0]) / 3
    two = touches(Scene(bodies=(body("a", BALL, (0.0, 0.0, 0.0)), body("b", BALL, tuple(0.2 * way))), surfaces=RULES))
    assert len(two) == 1
    np.testing.assert_allclose(two[0].normal, way, atol=1e-12)
    # One edge along y, turned by 45 degrees about it, across another along x: they meet along z.
    cube, half = Box(half_extents=(0.1, 0.1, 0.1)), 0.1 * math.sqrt(2)
    low = body("low", cube, (0.0, 0.0, 0.0), axis_angle((0.0, 1.0, 0.0), math.pi / 4))
    high = body("high", cube, (0.0, 0.0, 2 * half), axis_angle((1.0, 0.0, 0.0), math.pi / 4))
    crossed = touches(Scene(bodies=(low, high), surfaces=RULES))
    assert len(crossed) == 1
    np.testing.assert_allclose(crossed[0].normal, (0.0, 0.0, 1.0), atol=1e-9)


def test_a_body_reaches_as_far_as_its_farthest_point() -> None:
    turned = body("one", BOX, (1.0, 0.0, 0.0), axis_angle((0.0, 0.0, 1.0), 0.4))
    assert reach(turned, np.array([1.0, 0.0, 0.0])) == pytest.approx(1 + 0.1 * math.cos(0.4) + 0.2 * math.sin(0.4))
    assert reach(FLOOR, np.array([0.0, 0.0, 1.0])) == 0.0
    assert reach(FLOOR, np.array([0.0, 0.0, -1.0])) == math.inf


@pytest.mark.parametrize(
    "name", ["friction_wall_pinch", "stack_tower", "stack_mass_ratio", "stack_card_house", "stack_arch", "stack_pyramid"]
)
def test_no_start_of_an_ensemble_opens_a_gap_between_bodies_that_touch(name: str) -> None:
    case = plugins.case(name)
    scene = case.scene(case.parameters)
    touched = touches(scene)
    assert touched
    for number in range(4):
        start = member(scene, number, 1 / 240, turn=False).scene
        off = np.array([a.p_WB for a in start.bodies]) - np.array([b.p_WB for b in scene.bodies])
        opened = np.array([(off[one.second] - off[one.first]) @ one.normal / one.width for one in touched])
        # Where bodies are wedged no displacement presses all of them alike; the rounding of places is 1e-16 m of 1e-2 m.
        assert opened.max() < 1e-13
        assert opened.min() > -10 * PRESSED
        if name == "stack_tower":
            # Boxes 0.2 m wide are still laid down beside their places, the farthest of twenty ways by most of the tolerance.
            assert (np.abs(off[:, :2]).max() > 0.5 * TOLERANCE * 0.2) == (number > 0)
