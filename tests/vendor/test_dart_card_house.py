"""Two houses of two cards in dartpy's own words: one with more friction at its feet than it needs, one with less."""

import math

import numpy as np
import pytest

from tests.vendor.dart_world import UP, dartpy, make_ground, make_mover, make_pose, make_world, moments_of_box

pytestmark = pytest.mark.dart

DT, ANGLE = 1 / 240, math.radians(20.0)
HALF = np.array([0.01, 0.15, 0.2])
"""Half extents of a card [m]."""
CRITICAL = (math.tan(ANGLE) - HALF[0] / HALF[2]) / 2
"""The least friction at the feet with which a house stands."""


def height(friction: float, detector: str, conic: bool = False) -> float:
    """The height of the lower of two cards after 2 s, over that at the start. DART takes the lesser friction of two bodies."""
    world = make_world(detector, DT)
    if conic:
        world.getConstraintSolver().setBoxedLcpSolver(dartpy.constraint.NsgsFrictionSolver())
    make_ground(world, dartpy.dynamics.BoxShape(np.array([4.0, 4.0, 0.1])), make_pose(UP, -0.05), friction=friction)
    across = HALF[2] * math.sin(ANGLE) + HALF[0] * math.cos(ANGLE)
    high = HALF[2] * math.cos(ANGLE) + HALF[0] * math.sin(ANGLE)
    shape, law = dartpy.dynamics.BoxShape(2 * HALF), {"mass": 0.1, "moments": moments_of_box(HALF), "friction": 1.0}
    cards = [
        make_mover(world, shape, make_pose((0.0, way * ANGLE, 0.0), high, x=-way * across), f"card {way}", **law)
        for way in (1, -1)
    ]
    for _ in range(round(2 / DT)):
        world.step()
    return min(float(node.getWorldTransform().translation()[2]) for node in cards) / high


@pytest.mark.parametrize(("margin", "stands"), [(0.5, True), (0.2, True), (-0.2, False), (-0.5, False)])
def test_a_house_stands_with_more_friction_than_it_needs_and_falls_with_less(margin: float, stands: bool) -> None:
    # A card that lies down has its centre at its half thickness, 0.05 of its height when it stands.
    left = height((1 + margin) * CRITICAL, "ode")
    assert left > 0.9 if stands else left < 0.2


@pytest.mark.parametrize("margin", [0.1, 0.05, 0.02])
def test_near_the_critical_friction_it_falls_by_dantzig_and_stands_by_the_conic_solver(margin: float) -> None:
    assert height((1 + margin) * CRITICAL, "ode") < 0.2
    assert height((1 + margin) * CRITICAL, "ode", conic=True) > 0.9
    assert height((1 - margin) * CRITICAL, "ode", conic=True) < 0.2
