"""What DART's URDF and MJCF loaders make of a robot, in DART's own words."""

from pathlib import Path
from typing import Any

import pytest

from tests.vendor.dart_world import dartpy

pytestmark = pytest.mark.dart


def test_a_frame_without_an_inertial_weighs_a_kilogram(tmp_path: Path) -> None:
    """A link without <inertial>, as sensor frames are, is given 1 kg and 1 kg m2.

    A link of 2 kg, its centre .5 m from a hinge and .1 kg m2, has .6 kg m2 about it; with the frame 1 m from the hinge 2.6.
    """
    path = tmp_path / "p.urdf"
    path.write_text(
        '<robot name="p"><link name="b"/><link name="l"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>'
        '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link><link name="t"/>'
        '<joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/></joint>'
        '<joint name="f" type="fixed"><parent link="l"/><child link="t"/><origin xyz="1 0 0"/></joint></robot>'
    )
    loader, options = dartpy.utils.DartLoader(), dartpy.utils.DartLoaderOptions()
    options.mDefaultRootJointType = dartpy.utils.DartLoaderRootJointType.FIXED
    loader.setOptions(options)
    skeleton = loader.parseSkeleton(str(path))
    assert skeleton.getBodyNode("t").getMass() == 1.0
    assert skeleton.getMassMatrix()[0, 0] == pytest.approx(0.6 + 1.0 + 1.0)


def test_limits_are_read_and_not_enforced_unless_they_are_told_to_be(tmp_path: Path) -> None:
    """A documented default: half a second of falling from level is past one radian, and stops at .1 once they are."""
    path = tmp_path / "p.urdf"
    path.write_text(
        '<robot name="p"><link name="b"/><link name="l"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>'
        '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>'
        '<joint name="j" type="revolute"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/>'
        '<limit lower="-0.1" upper="0.1" effort="9" velocity="2"/></joint></robot>'
    )
    ends = []
    for told in (False, True):
        loader, options = dartpy.utils.DartLoader(), dartpy.utils.DartLoaderOptions()
        options.mDefaultRootJointType = dartpy.utils.DartLoaderRootJointType.FIXED
        loader.setOptions(options)
        skeleton = loader.parseSkeleton(str(path))
        joint = skeleton.getJoint("j")
        assert (joint.getPositionLowerLimit(0), joint.getPositionUpperLimit(0)) == (-0.1, 0.1)
        assert not joint.areLimitsEnforced()
        joint.setLimitEnforcement(told)
        world = dartpy.simulation.World()
        world.setGravity([0, 0, -9.81])
        world.addSkeleton(skeleton)
        for _ in range(500):
            world.step()
        ends.append(float(skeleton.getPositions()[0]))
    assert ends[0] > 1.0
    assert ends[1] == pytest.approx(0.1, abs=0.01)


def skeletons(path: Path, bodies: str, more: str = "") -> dict[str, Any]:
    """By name, what the MJCF parser makes of bodies."""
    path.write_text(f"<mujoco><compiler{more}/><worldbody>{bodies}</worldbody></mujoco>")
    world = dartpy.utils.MjcfParser.readWorld(str(path))
    found = [world.getSkeleton(k) for k in range(world.getNumSkeletons())]
    return {skeleton.getName(): skeleton for skeleton in found}


HINGE = '<joint name="j" type="hinge" axis="0 1 0"{0}/>'


def test_a_tensor_of_mjcf_becomes_a_unit_tensor_and_is_left_out_whole_without_geoms(tmp_path: Path) -> None:
    """Of .1 kg m2 about the centre, 2 kg and .5 m, .6 kg m2 about the hinge are due.

    With a geom, whose mass does not count beside it, 1.5 are there; without one 1 kg at the hinge with 1 kg m2.
    """
    inertial = '<inertial pos="0.5 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>'
    for geom, mass, moment in (('<geom type="sphere" size="0.1"/>', 2.0, 1.0 + 2 * 0.5**2), ("", 1.0, 1.0)):
        made = skeletons(tmp_path / "p.xml", f'<body name="l">{HINGE.format("")}{inertial}{geom}</body>')["l"]
        assert made.getMass() == mass
        assert made.getMassMatrix()[0, 0] == pytest.approx(moment)


def test_so_does_that_of_a_geom_and_of_two_geoms_one_weighs_nothing(tmp_path: Path) -> None:
    """Two balls of 3 kg, 1 m to either side: 6 kg in the middle are due, one ball alone is there."""
    balls = "".join(f'<geom type="sphere" size="0.1" mass="3" pos="{x} 0 0"/>' for x in (-1, 1))
    made = skeletons(tmp_path / "p.xml", f'<body name="l">{HINGE.format("")}{balls}</body>')["l"]
    assert made.getMass() == 3.0
    assert made.getMassMatrix()[0, 0] == pytest.approx(1.0 + 3 * 1.0**2)


def test_stiffness_armature_and_dry_friction_of_mjcf_are_dropped_and_damping_is_kept(tmp_path: Path) -> None:
    words = ' stiffness="3" armature="0.4" damping="0.2" frictionloss="0.1"'
    ball = '<geom type="sphere" size="0.1" mass="3"/>'
    made = skeletons(tmp_path / "p.xml", f'<body name="l">{HINGE.format(words)}{ball}</body>')["l"]
    joint = made.getJoint("j")
    assert (joint.getSpringStiffness(0), joint.getCoulombFriction(0), joint.getDampingCoefficient(0)) == (0.0, 0.0, 0.2)
    assert made.getMassMatrix()[0, 0] == pytest.approx(1.0)  # the unit tensor alone, and no rotor


def test_a_range_in_degrees_is_taken_for_radians(tmp_path: Path) -> None:
    """MJCF counts in degrees unless it says otherwise."""
    ball = '<geom type="sphere" size="0.1" mass="3"/>'
    hinge = HINGE.format(' limited="true" range="-90 90"')
    for more, upper in (("", 90.0), (' angle="degree"', 90.0), (' angle="radian"', 90.0)):
        made = skeletons(tmp_path / "p.xml", f'<body name="l">{hinge}{ball}</body>', more)["l"]
        assert made.getJoint("j").getPositionUpperLimit(0) == pytest.approx(upper)


def test_a_free_joint_of_mjcf_becomes_a_weld(tmp_path: Path) -> None:
    """A ball with <freejoint/> stays where it is; one with a joint of type free falls."""
    ball = '<geom type="sphere" size="0.1" mass="3"/>'
    for joint, kind, freedoms in (("<freejoint/>", "WeldJoint", 0), ('<joint type="free"/>', "FreeJoint", 6)):
        made = skeletons(tmp_path / "p.xml", f'<body name="l" pos="0 0 1">{joint}{ball}</body>')["l"]
        assert (made.getJoint(0).getType(), made.getNumDofs()) == (kind, freedoms)


TIED = (
    '<mujoco><compiler angle="radian"/><worldbody><body name="a"><joint name="a" type="hinge" axis="0 0 1"/><geom '
    'type="sphere" size="0.1" mass="1"/></body><body name="b" pos="1 0 0"><joint name="b" type="hinge" axis="0 0 1"/><geom '
    'type="sphere" size="0.1" mass="1"/></body></worldbody><equality><joint joint1="b" joint2="a" polycoef="0 0.5 0 0 0"/>'
    "</equality></mujoco>"
)
"""Of two hinges the second is to turn half as far as the first."""


def test_an_equality_between_joints_of_mjcf_is_left_out(tmp_path: Path) -> None:
    """While one is pushed the other stays where it is, to the bit."""
    path = tmp_path / "p.xml"
    path.write_text(TIED)
    world = dartpy.utils.MjcfParser.readWorld(str(path))
    world.setGravity([0, 0, 0])
    joints = [world.getSkeleton(k).getJoint(0) for k in range(world.getNumSkeletons())]
    pushed, other = (next(joint for joint in joints if joint.getName() == name) for name in "ab")
    for _ in range(100):
        pushed.setForce(0, 1.0)
        world.step()
    assert pushed.getPosition(0) > 0.004
    assert other.getPosition(0) == 0.0
