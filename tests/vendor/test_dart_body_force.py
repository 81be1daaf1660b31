"""What DART's `BodyNode.getBodyForce` holds: the wrench of the joint on its body, in which frame, and of when."""

from typing import Any

import numpy as np
import pytest

from tests.vendor.dart_world import dartpy

pytestmark = pytest.mark.dart

ARM, WEIGHT, MOMENT = 0.4, 9.81, 0.1


def beam() -> tuple[Any, Any, Any]:
    """A body of 1 kg whose centre of mass lies .4 m along x from a hinge about y; the world, the joint, the body."""
    world, skeleton = dartpy.simulation.World("w"), dartpy.dynamics.Skeleton("s")
    world.setTimeStep(1e-3)
    world.setGravity([0.0, 0.0, -WEIGHT])
    options = world.getDeactivationOptions()
    options.mEnabled = False
    world.setDeactivationOptions(options)
    hinge, body = skeleton.createRevoluteJointAndBodyNodePair()
    hinge.setAxis([0.0, 1.0, 0.0])
    place = dartpy.math.Isometry3()
    place.set_translation([-ARM, 0.0, 0.0])
    hinge.setTransformFromChildBodyNode(place)
    body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) * MOMENT))
    world.addSkeleton(skeleton)
    return world, hinge, body


@pytest.mark.parametrize("by", ["spring", "limit"])
def test_what_springs_and_limits_hold_is_in_it(by: str) -> None:
    """Level at rest: torque and force about the body's origin, in this order; the weight upwards and no moment in all."""
    world, hinge, body = beam()
    if by == "spring":
        hinge.setSpringStiffness(0, 1000.0)
        hinge.setDampingCoefficient(0, 50.0)
        hinge.setRestPosition(0, -WEIGHT * ARM / 1000.0)
    else:
        hinge.setLimitEnforcement(True)
        hinge.setPositionUpperLimit(0, 0.0)
    for _ in range(100):
        world.step()
    np.testing.assert_allclose(body.getBodyForce(), (0.0, 0.0, 0.0, 0.0, 0.0, WEIGHT), atol=1e-6)


def test_it_is_of_the_start_of_the_step_in_the_frame_that_the_body_had_then() -> None:
    """Level at 3 rad/s: w^2 l along the beam as it stood, weight less l a'' across it, and I a'' about the centre of mass."""
    world, hinge, body = beam()
    hinge.setVelocity(0, 3.0)
    world.step()
    turn = WEIGHT * ARM / (MOMENT + ARM**2)
    np.testing.assert_allclose(body.getBodyForce(), (0.0, MOMENT * turn, 0.0, -9.0 * ARM, 0.0, WEIGHT - ARM * turn), atol=1e-9)
