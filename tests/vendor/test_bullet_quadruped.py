"""A quadruped on Bullet's own motors, and on torques of one's own, in pybullet's own words."""

import numpy as np
import pytest

from tests.vendor import quadruped
from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet

G, PRESSED = 9.81, 1e-6
"""How deep [m] the feet start in the ground."""


def build(world: World) -> int:
    """The machine in its pose on a slab, without damping, its motors off."""
    world.setGravity(0, 0, -G)
    slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[5, 5, 0.5])
    ground = world.createMultiBody(0.0, slab, basePosition=[0, 0, PRESSED - 0.5])
    world.changeDynamics(ground, -1, lateralFriction=1.0)
    parts = list(quadruped.hinges())
    place = {part.name: k for k, part in enumerate(parts)} | {"": -1}
    foot = world.createCollisionShape(
        pybullet.GEOM_SPHERE, radius=quadruped.FOOT, collisionFramePosition=[0, 0, -quadruped.LEG]
    )
    trunk = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=quadruped.TRUNK_HALF)
    machine: int = world.createMultiBody(
        baseMass=quadruped.TRUNK_MASS,
        baseCollisionShapeIndex=trunk,
        basePosition=[0, 0, quadruped.HEIGHT],
        linkMasses=[part.mass for part in parts],
        linkCollisionShapeIndices=[foot if part.foot else -1 for part in parts],
        linkVisualShapeIndices=[-1] * len(parts),
        linkPositions=[part.at for part in parts],
        linkOrientations=[[0, 0, 0, 1]] * len(parts),
        linkInertialFramePositions=[part.centre for part in parts],
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * len(parts),
        linkParentIndices=[place[part.above] + 1 for part in parts],
        linkJointTypes=[pybullet.JOINT_REVOLUTE] * len(parts),
        linkJointAxis=[part.axis for part in parts],
    )
    world.changeDynamics(machine, -1, lateralFriction=0.8, linearDamping=0.0, angularDamping=0.0)
    for k, part in enumerate(parts):
        world.changeDynamics(machine, k, localInertiaDiagonal=part.inertia, lateralFriction=0.8, jointDamping=0.0)
        world.setJointMotorControl2(machine, k, pybullet.VELOCITY_CONTROL, force=0)
        world.resetJointState(machine, k, part.angle, 0.0)
    return machine


def stand(world: World, dt: float, drive: str) -> tuple[float, float]:
    """The greatest angle [rad] of a hinge off its place within 3 s, and how far [m] the trunk then is off its height.

    Args: drive: "motor" is the position motor as it comes; "stiff motor" has the gains that turn a hinge as its spring and
        damper alone would, k dt/(d + k dt) of the way a step; "torque" is spring and damper of the step's start.
    """
    world.setPhysicsEngineParameter(fixedTimeStep=dt, numSolverIterations=200, solverResidualThreshold=0.0)
    machine, parts = build(world), list(quadruped.hinges())
    angles, rests = np.array([part.angle for part in parts]), np.array([part.target for part in parts])
    links, greatest, count = list(range(len(parts))), 0.0, len(parts)
    way = dt * quadruped.STIFFNESS
    stiff = {
        "positionGains": [way / (quadruped.DAMPING + way)] * count,
        "velocityGains": [1.0] * count,
        "forces": [1e9] * count,
    }
    for _ in range(round(3 / dt)):
        states = np.array([state[:2] for state in world.getJointStates(machine, links)])
        greatest = max(greatest, float(np.abs(states[:, 0] - angles).max()))
        if drive == "torque":
            torques = quadruped.STIFFNESS * (rests - states[:, 0]) - quadruped.DAMPING * states[:, 1]
            world.setJointMotorControlArray(machine, links, pybullet.TORQUE_CONTROL, forces=torques.tolist())
        else:
            gains = stiff if drive == "stiff motor" else {}
            world.setJointMotorControlArray(machine, links, pybullet.POSITION_CONTROL, targetPositions=angles.tolist(), **gains)
        world.stepSimulation()
    return greatest, abs(float(world.getBasePositionAndOrientation(machine)[0][2]) - quadruped.HEIGHT)


COARSE = pytest.mark.parametrize("dt", [1 / 60, 1 / 120])


@COARSE
def test_on_torques_of_its_own_it_flails_at_coarse_steps(world: World, dt: float) -> None:
    """A damper of the start of the step, d dt against the inertia that a hinge moves, turns a rate round and makes it grow."""
    assert stand(world, dt, "torque")[0] > 0.5


def test_on_torques_of_its_own_it_stands_at_1_240_s(world: World) -> None:
    assert stand(world, 1 / 240, "torque")[0] < 1e-3


@COARSE
def test_on_bullets_own_motor_it_stands_at_coarse_steps(world: World, dt: float) -> None:
    """A velocity constraint, solved with the contacts: its default gain of 0.1 sags by 0.2 rad at 1/60 s; half a radian off
    is what counts as lost."""
    assert stand(world, dt, "motor")[0] < 0.5


@pytest.mark.parametrize("rate", [60, 120, 240])
def test_on_a_motor_of_a_spring_s_gains_it_gives_way_by_nothing_at_any_step(world: World, rate: int) -> None:
    bent, sunk = stand(world, 1 / rate, "stiff motor")
    # A motor yields to nothing: what a leg turns by is what the trunk falls in the step before contacts bear it.
    assert bent < G / rate**2 / quadruped.LEG
    # In the end, where ERP and slop leave each foot a tenth of a millimetre.
    assert sunk < 1e-3
