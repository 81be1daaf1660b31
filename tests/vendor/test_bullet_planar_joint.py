"""pybullet reads a URDF's planar joint, which moves in its plane, and tells no axis of it."""

from pathlib import Path

import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet
BOX = (
    '<robot name="b"><link name="base"/><link name="arm"><inertial><mass value="1"/>'
    '<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="j" type="planar"><parent link="base"/><child link="arm"/><axis xyz="{}"/></joint></robot>'
)


@pytest.mark.parametrize("axis", ["1 0 0", "0 1 0", "0 0 1"])
def test_the_queries_tell_the_same_of_a_planar_joint_whatever_its_plane(world: World, axis: str, tmp_path: Path) -> None:
    path = tmp_path / f"{axis.replace(' ', '')}.urdf"
    path.write_text(BOX.format(axis))
    body = world.loadURDF(str(path), useFixedBase=True)
    joint = world.getJointInfo(body, 0)
    assert joint[2] == pybullet.JOINT_PLANAR
    assert joint[13] == (0.0, 0.0, 0.0)
