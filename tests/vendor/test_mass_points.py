"""What vendors make of a body without inertia, each in its own words."""

import numpy as np
import pytest


@pytest.mark.mujoco
def test_mujoco_compiles_no_free_body_without_inertia() -> None:
    from tests.vendor.mujoco_world import load

    inertial = '<inertial pos="0 0 0" mass="1" diaginertia="{0} {0} {0}"/>'
    with pytest.raises(ValueError, match="mass and inertia of moving bodies must be larger than mjMINVAL"):
        load(f"<body><freejoint/>{inertial.format(0)}</body>", 1e-3)
    load(f"<body><freejoint/>{inertial.format(1e-12)}</body>", 1e-3)


@pytest.mark.bullet
def test_pybullet_turns_no_body_without_inertia_however_it_is_twisted() -> None:
    """A moment of 0 has the inverse 0: an endless one, and no point."""
    from tests.vendor.bullet_world import World

    with World() as world:
        body = world.createMultiBody(1.0, -1, useMaximalCoordinates=1)
        world.changeDynamics(body, -1, mass=1.0, localInertiaDiagonal=[0.0] * 3)
        world.applyExternalTorque(body, -1, [1.0, 0.0, 0.0], 1)
        world.stepSimulation()
        assert world.getBaseVelocity(body)[1] == (0.0, 0.0, 0.0)


@pytest.mark.dart
def test_dart_warns_of_a_body_without_inertia_lets_it_fall_and_passes_over_a_torque(capfd: pytest.CaptureFixture[str]) -> None:
    """It falls by g t, while a torque, which nothing could answer, turns it by nothing and raises nothing."""
    from tests.vendor.dart_world import G, dartpy, make_world

    world, skeleton = make_world("ode", 1e-3), dartpy.dynamics.Skeleton("point")
    _, node = skeleton.createFreeJointAndBodyNodePair()
    node.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.zeros((3, 3))))
    world.addSkeleton(skeleton)
    for _ in range(100):
        node.addExtTorque(np.array([1.0, 0.0, 0.0]))
        world.step()
    assert float(node.getCOMLinearVelocity()[2]) == pytest.approx(-0.1 * G, abs=1e-9)
    assert np.array_equal(node.getAngularVelocity(), np.zeros(3))
    assert "Value should be positive" in "".join(capfd.readouterr())
