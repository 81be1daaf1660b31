"""A cube pressed against a wall by a push far beyond its weight, in dartpy's own words: a gap at the start decides its fate."""

import numpy as np
import pytest

from tests.vendor.dart_world import UP, G, dartpy, make_ground, make_mover, make_pose, make_world

pytestmark = pytest.mark.dart

DT, HALF = 1 / 240, 0.1


def strayed(detector: str, push: float, gap: float) -> float:
    """How far [m] a cube of friction 0.5 is from where it touches a wall, 1 s after it was set `gap` [m] before that.

    Gravity leans: `push` times the weight presses the cube on the wall, the weight itself pulls it down.
    """
    world = make_world(detector, DT)
    world.setGravity((push * G, 0.0, -G))
    make_ground(world, dartpy.dynamics.BoxShape(np.array([1.0, 2.0, 12.0])), make_pose(UP, 0.0, x=0.5))
    start = make_pose(UP, 0.0, x=-HALF - gap)
    cube = make_mover(world, dartpy.dynamics.BoxShape(np.full(3, 2 * HALF)), start, friction=0.5)
    for _ in range(round(1 / DT)):
        world.step()
    return float(np.linalg.norm(cube.getWorldTransform().translation() - np.array([-HALF, 0.0, 0.0])))


BOTH = pytest.mark.parametrize("detector", ["ode", "bullet"])


@BOTH
@pytest.mark.parametrize("push", [4.0, 2e2, 2e4])
def test_a_cube_that_touches_is_held_by_any_push(detector: str, push: float) -> None:
    # DART softens a contact by 1e-5 of its mobility (DART_CFM), and so leaves that share of a step's push as a speed, for 1 s.
    assert strayed(detector, push, 0.0) < 1e-5 * push * G * DT


@BOTH
@pytest.mark.parametrize("push", [2e2, 2e4])
@pytest.mark.parametrize("gap", [1e-7, 2e-5])
def test_one_that_starts_short_of_the_wall_is_driven_in_by_a_step(detector: str, push: float, gap: float) -> None:
    # The first step is free, p g dt^2, whatever the width of the gap: 3.4 m under twenty thousand weights. What it drives in
    # comes out at 1 mm/s at most (DART_MAX_ERV).
    assert strayed(detector, push, gap) > push * G * DT**2 - gap - 1e-3
