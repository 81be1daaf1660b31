"""Two floating bodies that a hinge turns, in dartpy's own words: reduced coordinates lose momentum by the turn of a step."""

import numpy as np
import pytest

from tests.vendor.dart_world import UP, dartpy, make_pose, make_world

pytestmark = pytest.mark.dart

ARM, SPIN = 0.5, 5.0
"""From the hinge, at the centre of the one, to the centre of the other [m]; how fast the other turns about it [rad/s]."""


def lost(rate: int) -> float:
    """The share of momentum that changes within a second, with no force from outside."""
    world = make_world("ode", 1 / rate)
    world.setGravity((0.0, 0.0, 0.0))
    machine = dartpy.dynamics.Skeleton("machine")
    _, trunk = machine.createFreeJointAndBodyNodePair()
    hinge, limb = trunk.createRevoluteJointAndBodyNodePair()
    hinge.setAxis(np.array([0.0, 1.0, 0.0]))
    hinge.setTransformFromChildBodyNode(make_pose(UP, 0.0, x=-ARM))
    for node in (trunk, limb):
        node.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 150))
    world.addSkeleton(machine)
    hinge.setVelocity(0, SPIN)

    def momentum() -> np.ndarray:
        return np.asarray(trunk.getCOMLinearVelocity() + limb.getCOMLinearVelocity())

    start, worst = momentum(), 0.0
    for _ in range(rate):
        world.step()
        worst = max(worst, float(np.linalg.norm(momentum() - start)))
    return worst / float(np.linalg.norm(start))


@pytest.mark.parametrize("rate", [240, 480, 960])
def test_momentum_is_off_by_the_turn_of_one_step(rate: int) -> None:
    assert lost(rate) == pytest.approx(SPIN / rate, rel=1e-3)
