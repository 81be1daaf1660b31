"""What DART's joints have of dry friction and rotors, in dartpy's own words."""

import numpy as np
import pytest

from tests.vendor.dart_world import dartpy

pytestmark = pytest.mark.dart


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_coulomb_friction_of_a_joint_holds_to_its_bound_and_takes_all_of_it_beyond(share: float) -> None:
    """A slide of 2 kg under a pull of a share of 3 N: 0, or (share - 1) f t / m."""
    world, skeleton = dartpy.simulation.World("w"), dartpy.dynamics.Skeleton("s")
    world.setTimeStep(1 / 240)
    world.setGravity([share * 3.0 / 2.0, 0.0, 0.0])
    options = world.getDeactivationOptions()
    options.mEnabled = False
    world.setDeactivationOptions(options)
    slide, body = skeleton.createPrismaticJointAndBodyNodePair()
    slide.setAxis([1.0, 0.0, 0.0])
    slide.setCoulombFriction(0, 3.0)
    body.setInertia(dartpy.dynamics.Inertia(2.0, np.zeros(3), np.eye(3)))
    world.addSkeleton(skeleton)
    for _ in range(240):
        world.step()
    assert slide.getVelocity(0) == pytest.approx(max(share - 1, 0) * 3.0 / 2.0, abs=1e-9)


def test_a_joint_has_no_rotor() -> None:
    told = dir(dartpy.dynamics.RevoluteJoint)
    assert not [name for name in told if "rotor" in name.lower() or "armature" in name.lower()]
