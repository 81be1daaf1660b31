"""What pybullet's URDF loader makes of a robot, in pybullet's own words."""

import math
from pathlib import Path

import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet

G, REACH, MASS, MOMENT = 9.81, 0.5, 2.0, 0.1


def pendulum(path: Path, axis: str, joint: str = "") -> str:
    """A link of 2 kg, its centre .5 m from a hinge, lying level; it has no shape."""
    inertia = f'<inertia ixx="{MOMENT}" ixy="0" ixz="0" iyy="{MOMENT}" iyz="0" izz="{MOMENT}"/>'
    path.write_text(
        f'<robot name="p"><link name="b"/><link name="l"><inertial><origin xyz="{REACH} 0 0"/><mass value="{MASS}"/>{inertia}'
        f'</inertial></link><joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="{axis}"/>{joint}'
        "</joint></robot>"
    )
    return str(path)


def first_acceleration(world: World, robot: int) -> float:
    """Of the hinge, its motor off, from one short step."""
    dt = 1e-4
    world.setGravity(0, 0, -G)
    world.setTimeStep(dt)
    world.changeDynamics(robot, -1, linearDamping=0.0, angularDamping=0.0)
    world.setJointMotorControl2(robot, 0, pybullet.VELOCITY_CONTROL, force=0)
    world.stepSimulation()
    return float(world.getJointState(robot, 0)[1]) / dt


def test_an_axis_of_length_two_halves_the_acceleration(world: World, tmp_path: Path) -> None:
    """The length of <axis> stays in the joint's rates and is left out of its poses: m g l / I with unit length, half with two.

    Other readers of URDF normalise it; the format asks for a unit vector. A step of 1e-4 s errs by less than 1e-4.
    """
    due = MASS * G * REACH / (MOMENT + MASS * REACH**2)
    for axis, share in (("0 1 0", 1.0), ("0 2 0", 0.5)):
        robot = world.loadURDF(
            pendulum(tmp_path / f"{share}.urdf", axis), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE
        )  # a file of its own: pybullet keeps the text of a name that it has read
        assert first_acceleration(world, robot) == pytest.approx(share * due, rel=1e-3)
        assert math.hypot(*world.getJointInfo(robot, 0)[13]) == pytest.approx(1 / share)
        world.removeBody(robot)


def test_the_inertia_of_the_file_is_left_out_by_default(world: World, tmp_path: Path) -> None:
    """A documented default: the tensor is that of the collision shape, here of none, unless the flag asks for the file's."""
    file = pendulum(tmp_path / "p.urdf", "0 1 0")
    by_default = world.loadURDF(file, useFixedBase=True)
    asked = world.loadURDF(file, useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
    assert max(world.getDynamicsInfo(by_default, 0)[2]) < 0.001 * MOMENT
    assert world.getDynamicsInfo(asked, 0)[2] == pytest.approx((MOMENT,) * 3)


def with_tip(path: Path, inside: str) -> str:
    """The pendulum with a link fixed to it, 1 m from the hinge."""
    text = Path(pendulum(path, "0 1 0")).read_text(encoding="utf-8")
    tip = f'<link name="t">{inside}</link><joint name="f" type="fixed"><parent link="l"/><child link="t"/><origin xyz="1 0 0"/>'
    path.write_text(text.replace("</robot>", f"{tip}</joint></robot>"), encoding="utf-8")
    return str(path)


def test_a_frame_without_an_inertial_weighs_a_kilogram(world: World, tmp_path: Path) -> None:
    """A link without <inertial>, as sensor frames are, is given 1 kg and 1 kg m2, told by a line on the console alone."""
    robot = world.loadURDF(with_tip(tmp_path / "p.urdf", ""), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
    assert world.getDynamicsInfo(robot, 1)[0] == 1.0
    bare = MOMENT + MASS * REACH**2
    assert world.calculateMassMatrix(robot, [0.0])[0][0] == pytest.approx(bare + 1.0 + 1.0 * 1.0**2)


def test_a_tensor_that_breaks_the_triangle_inequality_becomes_zero(world: World, tmp_path: Path) -> None:
    """Though asked for the file's: of moments .1, .1 and .3 none is left, told by a line on the console alone."""
    path = tmp_path / "p.urdf"
    path.write_text(Path(pendulum(path, "0 1 0")).read_text().replace(f'izz="{MOMENT}"', 'izz="0.3"'))
    robot = world.loadURDF(str(path), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
    assert world.getDynamicsInfo(robot, 0)[2] == (0.0, 0.0, 0.0)
    assert world.calculateMassMatrix(robot, [0.0])[0][0] == pytest.approx(MASS * REACH**2)


def test_limits_of_a_continuous_joint_are_told_and_not_applied(world: World, tmp_path: Path) -> None:
    """They are no part of such a joint: half a second of falling from level is past one radian, and the query says .1."""
    file = pendulum(tmp_path / "p.urdf", "0 1 0", '<limit lower="-0.1" upper="0.1" effort="1" velocity="1"/>')
    robot = world.loadURDF(file, useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
    assert world.getJointInfo(robot, 0)[8:10] == (-0.1, 0.1)
    world.setGravity(0, 0, -G)
    world.setJointMotorControl2(robot, 0, pybullet.VELOCITY_CONTROL, force=0)
    for _ in range(120):
        world.stepSimulation()
    assert world.getJointState(robot, 0)[0] > 1.0


def test_a_mimic_joint_moves_freely(world: World, tmp_path: Path) -> None:
    """A slide that is to follow another one stays where it is, to the bit, while the other is pushed."""
    inertia = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    limit = '<axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="9" velocity="9"/>'
    joints = "".join(
        f'<link name="{child}">{inertia}</link><joint name="j{child}" type="prismatic"><parent link="b"/>'
        f'<child link="{child}"/>'
        f"{limit}{mimic}</joint>"
        for child, mimic in (("l", ""), ("r", '<mimic joint="jl" multiplier="1"/>'))
    )
    path = tmp_path / "p.urdf"
    path.write_text(f'<robot name="p"><link name="b">{inertia}</link>{joints}</robot>')
    robot = world.loadURDF(str(path), useFixedBase=True)
    for joint in (0, 1):
        world.setJointMotorControl2(robot, joint, pybullet.VELOCITY_CONTROL, force=0)
    for _ in range(24):
        world.setJointMotorControl2(robot, 0, pybullet.TORQUE_CONTROL, force=1.0)
        world.stepSimulation()
    assert world.getJointState(robot, 0)[0] > 0.004
    assert world.getJointState(robot, 1)[0] == 0.0
