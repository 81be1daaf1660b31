"""What pybullet's URDF and MJCF loaders make of a robot, in pybullet's own words."""

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


def mjcf(world: World, path: Path, bodies: str) -> int:
    """The body of the most joints that loadMJCF makes."""
    path.write_text(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    return max(world.loadMJCF(str(path)), key=world.getNumJoints)


HINGE = '<joint name="j" type="hinge" axis="0 1 0"{0}/>'
BALL = '<geom type="sphere" size="0.1"{0}/>'


def test_geoms_of_mjcf_weigh_a_thousand_kilograms_a_cubic_metre(world: World, tmp_path: Path) -> None:
    """Whatever their mass or density says: 4/3 pi r3 1000, 4.19 kg for a ball of .1 m."""
    due = 4 / 3 * math.pi * 0.1**3 * 1000
    for k, words in enumerate(("", ' mass="2"', ' density="50"')):
        body = mjcf(world, tmp_path / f"{k}.xml", f'<body name="l">{HINGE.format("")}{BALL.format(words)}</body>')
        assert sum(world.getDynamicsInfo(body, j)[0] for j in range(world.getNumJoints(body))) == pytest.approx(due)


def test_the_tensor_of_an_inertial_of_mjcf_is_left_out(world: World, tmp_path: Path) -> None:
    """Its mass and centre are kept; .6 kg m2 are due about the hinge, m r2 and what a box about the shape has are there."""
    inertial = '<inertial pos="0.5 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>'
    body = mjcf(world, tmp_path / "p.xml", f'<body name="l">{HINGE.format("")}{inertial}{BALL.format("")}</body>')
    assert sum(world.getDynamicsInfo(body, j)[0] for j in range(world.getNumJoints(body))) == 2.0
    assert world.calculateMassMatrix(body, [0.0])[0][0] == pytest.approx(2 * 0.5**2 + 2 / 12 * 2 * 0.2**2)


def test_a_body_of_mjcf_without_a_joint_falls(world: World, tmp_path: Path) -> None:
    """MJCF welds it to the world."""
    path = tmp_path / "p.xml"
    path.write_text(f'<mujoco><worldbody><body name="l" pos="0 0 1">{BALL.format("")}</body></worldbody></mujoco>')
    (body,) = world.loadMJCF(str(path))
    world.setGravity(0, 0, -G)
    for _ in range(24):
        world.stepSimulation()
    assert world.getBasePositionAndOrientation(body)[0][2] < 0.96


def test_the_place_of_a_geom_does_not_count_for_the_centre_of_mass(world: World, tmp_path: Path) -> None:
    """A ball .3 m from its hinge: m r2 is due beside its own; without an <inertial> the centre is the body's origin."""
    ball = BALL.format(' pos="0.3 0 0"')
    body = mjcf(world, tmp_path / "p.xml", f'<body name="l">{HINGE.format("")}{ball}</body>')
    mass = 4 / 3 * math.pi * 0.1**3 * 1000
    assert world.calculateMassMatrix(body, [0.0])[0][0] == pytest.approx(mass / 12 * 2 * 0.2**2)


def test_damping_stiffness_dry_friction_and_armature_of_mjcf_are_dropped(world: World, tmp_path: Path) -> None:
    """A hinge at 1 rad/s keeps its rate to a thousandth for .1 s, and a rotor of 1 kg m2 is not in the mass matrix.

    By a damper of .5 N m s/rad on .03 kg m2 it would lose three quarters of it. What pybullet damps unless told not to is off.
    """
    words = ' damping="0.5" stiffness="3" armature="1" frictionloss="0.4"'
    body = mjcf(world, tmp_path / "p.xml", f'<body name="l">{HINGE.format(words)}{BALL.format("")}</body>')
    assert world.calculateMassMatrix(body, [0.0])[0][0] < 0.03
    assert world.getJointInfo(body, 0)[6:8] == (0.0, 0.0)
    world.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0)
    world.setJointMotorControl2(body, 0, pybullet.VELOCITY_CONTROL, force=0)
    world.resetJointState(body, 0, 0.0, 1.0)
    world.setGravity(0, 0, 0)
    for _ in range(24):
        world.stepSimulation()
    assert world.getJointState(body, 0)[1] == pytest.approx(1.0, abs=1e-3)


def limits(world: World, path: Path, compiler: str, words: str) -> tuple[float, float]:
    """The lower and the upper one of a hinge."""
    hinge = HINGE.format(f' {words} range="-57.29577951308232 57.29577951308232"')
    path.write_text(f'<mujoco>{compiler}<worldbody><body name="l">{hinge}{BALL.format("")}</body></worldbody></mujoco>')
    lower, upper = world.getJointInfo(max(world.loadMJCF(str(path)), key=world.getNumJoints), 0)[8:10]
    return lower, upper


def test_a_range_of_mjcf_counts_only_where_limited_is_said(world: World, tmp_path: Path) -> None:
    """`autolimits`, on unless a file says otherwise, came to MJCF after this loader; lower above upper is none."""
    lower, upper = limits(world, tmp_path / "a.xml", '<compiler angle="degree"/>', "")
    assert lower > upper
    assert limits(world, tmp_path / "b.xml", '<compiler angle="degree"/>', 'limited="true"') == pytest.approx((-1.0, 1.0))


def test_angles_of_mjcf_are_radians_unless_degrees_are_asked_for(world: World, tmp_path: Path) -> None:
    """MJCF counts in degrees unless it says otherwise."""
    assert limits(world, tmp_path / "a.xml", "", 'limited="true"')[1] == pytest.approx(57.29577951308232)
    assert limits(world, tmp_path / "b.xml", '<compiler angle="degree"/>', 'limited="true"')[1] == pytest.approx(1.0)


def test_freejoint_is_an_unknown_word_and_a_joint_of_type_free_is_none(world: World, tmp_path: Path) -> None:
    """Either falls, as it should: what hangs on the world by no joint is free here."""
    for k, joint in enumerate(("<freejoint/>", '<joint type="free"/>')):
        path = tmp_path / f"{k}.xml"
        path.write_text(f'<mujoco><worldbody><body name="l" pos="0 0 1">{joint}{BALL.format("")}</body></worldbody></mujoco>')
        (body,) = world.loadMJCF(str(path))
        assert world.getDynamicsInfo(body, -1)[0] > 0


TIED = (
    '<mujoco><compiler angle="radian"/><worldbody><body name="a"><joint name="a" type="hinge" axis="0 0 1"/><geom '
    'type="sphere" size="0.1" mass="1"/></body><body name="b" pos="1 0 0"><joint name="b" type="hinge" axis="0 0 1"/><geom '
    'type="sphere" size="0.1" mass="1"/></body></worldbody><equality><joint joint1="b" joint2="a" polycoef="0 0.5 0 0 0"/>'
    "</equality></mujoco>"
)
"""Of two hinges the second is to turn half as far as the first."""


def test_an_equality_between_joints_of_mjcf_is_left_out(world: World, tmp_path: Path) -> None:
    """While one is pushed the other stays where it is, to the bit."""
    path = tmp_path / "p.xml"
    path.write_text(TIED)
    bodies = {world.getJointInfo(body, 0)[1]: body for body in world.loadMJCF(str(path)) if world.getNumJoints(body)}
    for body in bodies.values():
        world.setJointMotorControl2(body, 0, pybullet.VELOCITY_CONTROL, force=0)
    world.setGravity(0, 0, 0)
    for _ in range(24):
        world.setJointMotorControl2(bodies[b"a"], 0, pybullet.TORQUE_CONTROL, force=1.0)
        world.stepSimulation()
    assert world.getJointState(bodies[b"a"], 0)[0] > 0.004
    assert world.getJointState(bodies[b"b"], 0)[0] == 0.0


def weighing(path: Path, mass: float) -> str:
    """A robot file of one link at a path."""
    path.parent.mkdir(exist_ok=True)
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    path.write_text(f'<robot name="r"><link name="l"><inertial><mass value="{mass}"/>{inertia}</inertial></link></robot>')
    return str(path)


def test_files_of_one_name_in_two_folders_are_two_and_a_rewritten_one_is_the_old_one_unless_caching_is_off(
    world: World, tmp_path: Path
) -> None:
    """`setPhysicsEngineParameter` has enableFileCaching, on by default: the guide warns of it under loadURDF."""
    one, two = weighing(tmp_path / "a" / "robot.urdf", 1.0), weighing(tmp_path / "b" / "robot.urdf", 2.0)
    assert [world.getDynamicsInfo(world.loadURDF(path), -1)[0] for path in (one, two)] == [1.0, 2.0]
    weighing(tmp_path / "a" / "robot.urdf", 5.0)
    assert world.getDynamicsInfo(world.loadURDF(one), -1)[0] == 1.0
    world.setPhysicsEngineParameter(enableFileCaching=0)
    assert world.getDynamicsInfo(world.loadURDF(one), -1)[0] == 5.0
    world.setPhysicsEngineParameter(enableFileCaching=1)
