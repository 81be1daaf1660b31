"""Which balls get through a thin wall in dartpy's own words: stepping has no continuous collision.

Through is a ball whose centre ends beyond the wall's middle.
"""

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vendor.dart_world import UP, dartpy, make_ground, make_mover, make_pose, make_world

pytestmark = pytest.mark.dart

DT, R = 1 / 240, 0.05
DETECTORS = ("ode", "fcl", "bullet", "dart")
Floats = NDArray[np.float64]
PHASES: Floats = (np.arange(16) + 0.5) / 16
"""Of a step."""


def centres(detector: str, thickness: float, speed: float, ways: Floats) -> Floats:
    """Where balls end [m], beyond the middle of a wall, in a quarter of a second that are shot at its face from `ways` [m]."""
    world, count = make_world(detector, DT), len(ways)
    world.setGravity((0.0, 0.0, 0.0))
    wall = dartpy.dynamics.BoxShape(np.array([thickness, count + 1.0, 1.0]))
    make_ground(world, wall, make_pose(UP, 0.0, y=(count - 1) / 2), friction=0.0)
    balls = []
    for k, way in enumerate(ways.tolist()):
        start = make_pose(UP, 0.0, x=-thickness / 2 - R - way, y=k)
        balls.append(make_mover(world, dartpy.dynamics.SphereShape(R), start, f"ball {k}", moments=0.4 * R**2, friction=0.0))
        balls[-1].getParentJoint().setLinearVelocity(np.array([speed, 0.0, 0.0]))
    for _ in range(60):
        world.step()
    return np.array([ball.getWorldTransform().translation()[0] for ball in balls])


def shot(detector: str, thickness: float, speed: float) -> Floats:
    """The same of 16 balls, each from another phase of the step."""
    return centres(detector, thickness, speed, 0.05 + speed * DT * PHASES)


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("thickness", [0.005, 0.02, 0.1])
def test_no_ball_gets_through_that_is_seen_before_its_centre_is_beyond_the_middle(detector: str, thickness: float) -> None:
    # Looked at once a step: a centre is found before the middle where a step's way is at most R + thickness/2.
    for share in (0.1, 0.5, 0.95):
        assert max(shot(detector, thickness, share * (R + thickness / 2) / DT)) < 0


@pytest.mark.parametrize("detector", DETECTORS)
def test_balls_get_through_that_a_step_takes_past_the_middle(detector: str) -> None:
    # At twice that speed half of the phases lie beyond the middle when they are first looked at; more is the reach of the ball.
    assert max(shot(detector, 0.005, 2 * (R + 0.0025) / DT)) > R


def test_a_ball_that_is_stopped_stands_up_to_a_step_deep_in_the_wall() -> None:
    """Found within a step's way of the face, it keeps its place: deep beside a wall of 5 mm, and not through it."""
    speed = 4.8
    depths = shot("bullet", 0.005, speed) + 0.0025 + R
    assert 0.0025 < depths.max() <= speed * DT


@pytest.mark.parametrize("detector", ["fcl", "ode"])
def test_at_50_m_per_s_two_thirds_pass_a_wall_of_a_centimetre_and_a_quarter_stay_in_it(detector: str) -> None:
    """In a step of 21 cm; a ball of 10 cm is seen in the wall of 1 cm in 11 of them, and stays where it is seen."""
    found = centres(detector, 0.01, 50.0, 0.05 + np.random.default_rng(0).uniform(0.0, 50 / 60, 64))
    assert int((found > 0.0).sum()) == 43
    assert int(((found <= 0.0) & (found + R > 0.0)).sum()) == 17
