"""A row of five balls hit at one end in DART, in dartpy's own words: each blow lacks the softness of contacts."""

import numpy as np
import pytest

from tests.vendor.dart_world import UP, dartpy, make_mover, make_pose, make_world

pytestmark = pytest.mark.dart

BALLS, R, MASS, GAP, SPEED, RUN_UP = 5, 0.02, 0.1, 1e-3, 0.5, 0.0313
SOFTNESS = 1e-5
"""ContactConstraint's constraint force mixing, a share of a contact's own mobility; dartpy has no name for it."""


def lacking(detector: str, rate: int) -> float:
    """The share of the first ball's speed that the last one lacks, of balls of restitution 1 with gaps between them."""
    world = make_world(detector, 1 / rate)
    world.setGravity((0.0, 0.0, 0.0))
    balls = [
        make_mover(
            world,
            dartpy.dynamics.SphereShape(R),
            make_pose(UP, 0.0, x=(2 * R + GAP) * k if k else -RUN_UP),
            f"ball {k}",
            mass=MASS,
            moments=0.4 * R**2,
            friction=0.0,
            restitution=1.0,
        )
        for k in range(BALLS)
    ]
    balls[0].getParentJoint().setLinearVelocity(np.array([SPEED, 0.0, 0.0]))
    for _ in range(round(0.25 * rate)):
        world.step()
    return 1 - float(balls[-1].getCOMLinearVelocity()[0]) / SPEED


@pytest.mark.parametrize("rate", [960, 7680])
@pytest.mark.parametrize("detector", ["ode", "fcl", "bullet"])
def test_each_of_four_blows_hands_on_all_but_the_softness_of_contacts_at_any_step(detector: str, rate: int) -> None:
    # A blow of e = 1 is short by the share 1e-5 of it, half of which is the speed that is handed on, twice: 1e-5 of that.
    assert lacking(detector, rate) == pytest.approx((BALLS - 1) * SOFTNESS, rel=1e-3)
