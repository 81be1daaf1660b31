"""What a ball gains a bounce in DART, and what an impact lacks at any step, in dartpy's own words."""

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.vendor.dart_world import UP, G, dartpy, make_ground, make_mover, make_pose, make_world

pytestmark = pytest.mark.dart


FALL = math.sqrt(2 / G)
"""Time to the first impact, from a metre [s]."""
GROUNDS = {
    "plane": (dartpy.dynamics.PlaneShape(np.array([0.0, 0.0, 1.0]), 0.0), make_pose(UP, 0.0)),
    "box": (dartpy.dynamics.BoxShape(np.array([10.0, 10.0, 1.0])), make_pose(UP, -0.5)),
}


def apexes(detector: str, dt: float, ground: str = "plane") -> list[float]:
    """The vertices [m] of the parabolas of a ball dropped from 1 m on the ground, within 4.5 s; the last one foreseen."""
    world = make_world(detector, dt)
    surface = {"friction": 0.0, "restitution": 1.0}
    make_ground(world, *GROUNDS[ground], **surface)
    node = make_mover(world, dartpy.dynamics.SphereShape(0.1), make_pose(UP, 1.1), **surface)
    z = [1.0]
    for _ in range(round(4.5 / dt)):
        world.step()
        z.append(float(node.getTransform().translation()[2]) - 0.1)
    tops = [k for k in range(1, len(z) - 1) if z[k - 1] < z[k] >= z[k + 1]] + [len(z) - 2]
    return [z[k] + ((z[k + 1] - z[k - 1]) / (2 * dt)) ** 2 / (2 * G) for k in tops]


@pytest.mark.parametrize("detector", ["fcl", "ode"])
def test_a_ball_of_e_1_gains_1_9_per_cent_a_bounce(detector: str) -> None:
    """DART reverses the speed that gravity has already made greater by g dt: height grows by 2 g dt/v, v = sqrt(2 g h)."""
    found = [1.0, *apexes(detector, 1 / 240)]
    gains = [after / before - 1 for before, after in pairwise(found)]
    assert gains == pytest.approx([2 / 240 / FALL] * len(gains), rel=0.05)
    # Published: after five bounces.
    assert max(found) - 1 == pytest.approx(0.09433, rel=5e-4)


@pytest.mark.parametrize("dt", [1 / 240, 1 / 480, 1 / 960])
def test_each_bounce_gains_the_speed_of_one_step_of_gravity(dt: float) -> None:
    """2 g dt/v = 2 dt/t0 of the height a bounce: of first order in the step, on DART's own detector as on the others."""
    tops = [1.0, *apexes("dart", dt, "box")]
    assert len(tops) >= 5
    gains = np.array(tops[1:]) / np.array(tops[:-1]) - 1
    # The ball is turned back where it is found, up to one step's way deep, v dt/h = 2 dt/t0, to either side of what it gains.
    assert np.all(np.abs(gains - 2 * dt / FALL) <= 2 * dt / FALL)
    assert gains.mean() == pytest.approx(2 * dt / FALL, rel=0.1)


SOFTNESS = 1e-5
"""ContactConstraint's constraint force mixing, a share of a contact's own mobility; dartpy has no name for it."""
MU, E, APPROACH, SLIP = 0.3, 0.6, 2.0, 6.0


def oblique(detector: str, dt: float, conic: bool) -> tuple[float, float]:
    """By how much [m/s] a ball that slips leaves a plane too slowly, upwards, and too fast along it; without gravity."""
    world = make_world(detector, dt)
    world.setGravity((0.0, 0.0, 0.0))
    if conic:
        solver = dartpy.constraint.NsgsFrictionSolver()
        options = solver.getOptions()
        options.tolerance = 1e-12
        solver.setOptions(options)
        world.getConstraintSolver().setBoxedLcpSolver(solver)
    make_ground(world, GROUNDS["plane"][0], make_pose(UP, 0.0), friction=MU, restitution=1.0)
    ball = make_mover(
        world, dartpy.dynamics.SphereShape(0.2), make_pose(UP, 0.45), moments=0.4 * 0.2**2, friction=MU, restitution=E
    )
    ball.getParentJoint().setLinearVelocity(np.array([SLIP, 0.0, -APPROACH]))
    for _ in range(round(0.25 / dt)):
        world.step()
    velocity = ball.getCOMLinearVelocity()
    return E * APPROACH - float(velocity[2]), float(velocity[0]) - (SLIP - MU * (1 + E) * APPROACH)


@pytest.mark.parametrize("rate", [240, 960, 7680])
@pytest.mark.parametrize("detector", ["ode", "bullet", "fcl"])
@pytest.mark.parametrize("conic", [False, True], ids=["dantzig", "conic"])
def test_every_impulse_is_short_by_the_softness_of_contacts_at_any_step(detector: str, rate: int, conic: bool) -> None:
    # A contact of mobility A answers by A (1 + 1e-5) j = (1 + e) v: to first order in 1e-5 it lacks that share.
    lacking = SOFTNESS * (1 + E) * APPROACH
    slow, fast = oblique(detector, 1 / rate, conic)
    assert slow == pytest.approx(lacking, rel=1e-3)
    # Along the plane the ball slips under mu times a normal impulse that lacks as much.
    assert fast == pytest.approx(MU * lacking, rel=0.05)
