"""A fast top in Bullet, on a link and on a constraint, in one step and in sub-steps, in pybullet's own words.

A tenth of the stem counts as lost; a top that lies down is two stems away.
"""

import math

import numpy as np
import pytest

from tests.vendor import spinning
from tests.vendor.bullet_world import MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet


def lean(world: World, joint: str, speed: float, dt: float = 1 / 240, substeps: int = 1, damped: bool = False) -> float:
    """How far [m] a top of this speed [rad/s] gets from its way within 2 s: a ball link, or a free body on a constraint."""
    at, w = spinning.centre(speed, 0.0), spinning.top_rate(speed)
    world.setPhysicsEngineParameter(fixedTimeStep=dt, numSubSteps=substeps if substeps > 1 else 0)
    world.setPhysicsEngineParameter(numSolverIterations=200, solverResidualThreshold=0.0)
    world.setGravity(0, 0, -spinning.G)
    turn = pybullet.getQuaternionFromEuler([0, spinning.TILT, 0])
    if joint == "link":
        top = world.createMultiBody(
            baseMass=0.0,
            linkMasses=[1.0],
            linkCollisionShapeIndices=[-1],
            linkVisualShapeIndices=[-1],
            linkPositions=[[0, 0, 0]],
            linkOrientations=[turn],
            linkInertialFramePositions=[[0, 0, spinning.STEM]],
            linkInertialFrameOrientations=[[0, 0, 0, 1]],
            linkParentIndices=[0],
            linkJointTypes=[pybullet.JOINT_SPHERICAL],
            linkJointAxis=[[0, 0, 1]],
        )
        # The motor that pybullet puts on every ball joint is off.
        off = {"targetPosition": [0, 0, 0, 1], "positionGain": 0, "velocityGain": 0, "force": [0, 0, 0]}
        world.setJointMotorControlMultiDof(top, 0, pybullet.POSITION_CONTROL, **off)
        R = np.array(world.getMatrixFromQuaternion(turn)).reshape(3, 3)
        world.resetJointStateMultiDof(top, 0, [0, 0, 0, 1], (R.T @ w).tolist())
    else:
        top = world.createMultiBody(1.0, basePosition=at.tolist(), baseOrientation=turn)
        tip = world.createConstraint(top, -1, -1, -1, pybullet.JOINT_POINT2POINT, [0, 0, 0], [0, 0, -spinning.STEM], [0, 0, 0])
        world.changeConstraint(tip, maxForce=1e12)
        world.resetBaseVelocity(top, np.cross(w, at).tolist(), w.tolist())
    world.changeDynamics(top, 0 if joint == "link" else -1, localInertiaDiagonal=list(spinning.TOP))
    if not damped:
        world.release(top, MULTIBODY)
    lost = 0.0
    for n in range(1, round(2 / dt) + 1):
        world.stepSimulation()
        if joint == "link":
            here = world.getLinkState(top, 0, computeForwardKinematics=1)[0]
        else:
            here = world.getBasePositionAndOrientation(top)[0]
        off_way = float(np.linalg.norm(np.array(here) - spinning.centre(speed, n * dt)))
        lost = max(lost, off_way if math.isfinite(off_way) else math.inf)
    return lost


@pytest.mark.parametrize("speed", [100.0, 200.0, 800.0, 5000.0])
def test_on_a_reduced_coordinate_ball_joint_it_is_lost_in_one_step_of_a_240th(world: World, speed: float) -> None:
    # Farther from its place than its distance from the pivot.
    assert lean(world, "link", speed) > spinning.STEM


@pytest.mark.parametrize("speed", [100.0, 400.0, 800.0])
def test_on_a_point_to_point_constraint_it_is_bounded_in_one_step(world: World, speed: float) -> None:
    # The axis answers gravity's torque a step late: g sin(tilt) acts on the tip for dt, and the circle of the nutation that it
    # sets going is as wide as twice its speed over the rate of nutation, I3 w3/I1; Bullet's own figure is 18 to 28 mm.
    assert lean(world, "constraint", speed) < 0.3 * spinning.STEM


def test_a_free_body_on_a_point_to_point_constraint_keeps_its_way_with_sub_steps_alone(world: World) -> None:
    assert lean(world, "constraint", 100.0) == pytest.approx(0.028, abs=1e-3)
    world.resetSimulation()
    assert lean(world, "constraint", 100.0, substeps=4) == pytest.approx(0.006, abs=1e-3)


@pytest.mark.parametrize("speed", [100.0, 200.0, 800.0, 1600.0, 5000.0])
def test_four_sub_steps_carry_it_on_a_constraint_to_5000_rad_per_second(world: World, speed: float) -> None:
    # A fourth of the step, and a fourth of 28 mm with it.
    assert lean(world, "constraint", speed, substeps=4) < 7e-3


def test_a_point_to_point_constraint_errs_by_the_first_order_in_the_step() -> None:
    errors = []
    for dt in (1 / 960, 1 / 1920, 1 / 3840):
        with World() as world:
            errors.append(lean(world, "constraint", 200.0, dt))
    # The second-order term is a twentieth of the first at the coarsest of these.
    assert [errors[0] / errors[1], errors[1] / errors[2]] == pytest.approx([2.0, 2.0], rel=0.05)


@pytest.mark.parametrize("joint", ["link", "constraint"])
def test_as_it_comes_damping_brings_it_down_on_any_joint(world: World, joint: str) -> None:
    assert lean(world, joint, 100.0, substeps=4, damped=True) > spinning.STEM
