# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "loadMJCF gives every geom 1000 kg/m³, whatever its mass or density"
# seen = ["3.2.7"]
# documented = "MJCF: geom/mass and geom/density set a geom's mass; 1000 kg/m3 is the default density. The loader calls itself a basic import of MJCF files."
# sources = ["MuJoCo, XML Reference: geom, mass and density", "PyBullet Quickstart Guide, loadMJCF"]
# mend = "changeDynamics(body, link, mass=...) after loading, or a URDF"
# cases = []
# ///
"""A ball of 0.1 m radius that the file gives 2 kg."""

import math
import tempfile
from pathlib import Path

import pybullet as p

p.connect(p.DIRECT)
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "ball.xml"
    path.write_text(
        '<mujoco><worldbody><body name="l"><joint name="j" type="hinge" axis="0 1 0"/><geom type="sphere" size="0.1" mass="2"/>'
        "</body></worldbody></mujoco>"
    )
    body = max(p.loadMJCF(str(path)), key=p.getNumJoints)
mass = sum(p.getDynamicsInfo(body, joint)[0] for joint in range(p.getNumJoints(body)))
water = 4 / 3 * math.pi * 0.1**3 * 1000
print(
    f"{'gone' if abs(mass - 2) < 1e-6 else 'still there'}: {mass:.3f} kg of a ball that the file gives 2 kg; of water it would have {water:.3f} kg"
)
