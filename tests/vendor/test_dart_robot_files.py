"""What DART's URDF loader makes of a robot, in DART's own words."""

from pathlib import Path

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
