"""DART's joint springs beside contact, in dartpy's own words."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vendor.dart_world import UP, G, dartpy, make_ground, make_pose, make_world, touches

pytestmark = pytest.mark.dart

DT, R = 1 / 240, 0.1
SUNK = G * DT**2
"""What a body falls in the step before a contact is found [m]."""


def _wedge(spring: bool) -> NDArray[np.float64]:
    """Coordinates of a slider that stands on a box and carries a hinged weight, 1 s after it was set down in equilibrium.

    Along z a slider of 2 kg; on it a hinge about y with a bar of 1 kg and 0.3 m, level, held by k = 200, d = 20: by a joint
    spring, or by the same law as a torque of the start of each step.
    """
    world = make_world("ode", DT)
    make_ground(world, dartpy.dynamics.BoxShape(np.array([1.0, 1.0, 0.2])), make_pose(UP, -0.1))
    skeleton = dartpy.dynamics.Skeleton("wedge")
    slider, foot = skeleton.createPrismaticJointAndBodyNodePair()
    slider.setAxis(np.array([0.0, 0.0, 1.0]))
    foot.setInertia(dartpy.dynamics.Inertia(2.0, np.zeros(3), np.eye(3) / 10))
    touches(foot, dartpy.dynamics.BoxShape(np.full(3, 2 * R)))
    slider.setPosition(0, R - 1e-6)
    hinge, bar = skeleton.createRevoluteJointAndBodyNodePair(foot)
    hinge.setAxis(np.array([0.0, 1.0, 0.0]))
    bar.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 10))
    hinge.setTransformFromChildBodyNode(make_pose(UP, 0.0, x=-0.3))
    stiffness, damping = 200.0, 20.0
    # About +y the weight at +x turns the bar down by m g l; the spring's rest lies as far above.
    rest = -G * 0.3 / stiffness
    if spring:
        hinge.setSpringStiffness(0, stiffness)
        hinge.setRestPosition(0, rest)
        hinge.setDampingCoefficient(0, damping)
    world.addSkeleton(skeleton)
    for _ in range(240):
        if not spring:
            hinge.setForce(0, stiffness * (rest - hinge.getPosition(0)) - damping * hinge.getVelocity(0))
        world.step()
    return np.array([slider.getPosition(0) - R, hinge.getPosition(0)])


def test_a_joint_spring_in_equilibrium_sags_where_a_contact_bears_it_and_a_torque_does_not() -> None:
    sprung, pushed = abs(_wedge(spring=True)[1]), abs(_wedge(spring=False)[1])
    # Statics leaves the bar level. In the first step the foot falls by g dt^2, which the bar feels over its lever.
    assert pushed < SUNK / 0.3
    assert sprung > 10 * SUNK / 0.3
