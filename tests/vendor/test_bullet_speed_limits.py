"""What pybullet's maxJointVelocity is, in its own words: a cut of a whole multibody, and no law of one joint."""

import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet

LIMIT = 2.0


def _two_hinges(world: World, base: float) -> int:
    """A base of that mass [kg], 0 for a fixed one, and two links on hinges about y through one point, undamped, motors off."""
    nothing, here, unturned = [-1, -1], [[0.0, 0.0, 0.0]] * 2, [[0.0, 0.0, 0.0, 1.0]] * 2
    body: int = world.createMultiBody(
        base, -1, linkMasses=[1.0, 1.0], linkCollisionShapeIndices=nothing, linkVisualShapeIndices=nothing,
        linkPositions=here, linkOrientations=unturned, linkInertialFramePositions=here,
        linkInertialFrameOrientations=unturned, linkParentIndices=[0, 1], linkJointTypes=[pybullet.JOINT_REVOLUTE] * 2,
        linkJointAxis=[[0.0, 1.0, 0.0]] * 2,
    )  # fmt: skip
    for link in (0, 1):
        world.changeDynamics(body, link, localInertiaDiagonal=[0.5] * 3)
        world.setJointMotorControl2(body, link, pybullet.VELOCITY_CONTROL, force=0.0)
    if base > 0:
        world.changeDynamics(body, -1, localInertiaDiagonal=[0.7] * 3)
    world.release(body, 0)
    world.setGravity(0.0, 0.0, 0.0)
    return body


def _momentum(world: World, body: int) -> float:
    base = world.getBaseVelocity(body)[1][1]
    first, second = (world.getJointState(body, link)[1] for link in (0, 1))
    return float(0.7 * base + 0.5 * (base + first) + 0.5 * (base + first + second))


def test_a_limit_told_of_one_link_cuts_the_others_too(world: World) -> None:
    body = _two_hinges(world, 0.0)
    world.changeDynamics(body, 1, maxJointVelocity=LIMIT)
    world.resetJointState(body, 0, 0.0, 5.0)
    world.stepSimulation()
    assert world.getJointState(body, 0)[1] == pytest.approx(LIMIT, abs=1e-6)


def test_a_cut_rate_makes_angular_momentum_out_of_nothing(world: World) -> None:
    """A motor between the two links, in space: their momenta cancel, until one of them is cut."""
    body = _two_hinges(world, 1.0)
    world.changeDynamics(body, 1, maxJointVelocity=LIMIT)
    for step in range(720):
        world.setJointMotorControl2(body, 1, pybullet.TORQUE_CONTROL, force=1.0)
        world.stepSimulation()
        if step == 60:
            assert _momentum(world, body) == pytest.approx(0.0, abs=1e-3)
    assert abs(_momentum(world, body)) > 0.5
