# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "loadMJCF takes the angles of a file for radians unless it says degree"
# seen = ["3.2.7"]
# documented = "MJCF: compiler/angle is degree by default. The loader calls itself a basic import of MJCF files."
# sources = ["MuJoCo, XML Reference: compiler, angle", "PyBullet Quickstart Guide, loadMJCF"]
# mend = '<compiler angle="degree"/> or <compiler angle="radian"/> said in the file'
# cases = []
# ///
"""A hinge whose range is 90 degrees to either side, in a file that says nothing about its angles."""

import math
import tempfile
from pathlib import Path

import pybullet as p

p.connect(p.DIRECT)
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "hinge.xml"
    path.write_text(
        '<mujoco><worldbody><body name="l"><joint name="j" type="hinge" axis="0 1 0" limited="true" range="-90 90"/>'
        '<geom type="sphere" size="0.1"/></body></worldbody></mujoco>'
    )
    upper = p.getJointInfo(max(p.loadMJCF(str(path)), key=p.getNumJoints), 0)[9]
print(
    f"{'gone' if abs(upper - math.pi / 2) < 1e-6 else 'still there'}: an upper limit of {upper:g} rad, {math.pi / 2:.4f} are due"
)
