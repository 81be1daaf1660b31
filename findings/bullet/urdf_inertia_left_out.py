# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "loadURDF leaves the file's inertia out unless a flag asks for it"
# seen = ["3.2.7"]
# documented = "loadURDF: the inertia is recomputed from mass and volume of the collision shape by default; URDF_USE_INERTIA_FROM_FILE takes the file's."
# sources = ["PyBullet Quickstart Guide, loadURDF: flags, URDF_USE_INERTIA_FROM_FILE"]
# mend = "flags=URDF_USE_INERTIA_FROM_FILE"
# cases = []
# ///
"""A link of 0.1 kg m2 without a collision shape."""

import tempfile
from pathlib import Path

import pybullet as p

MOMENT = 0.1
ROBOT = f"""<robot name="p"><link name="b"/><link name="l"><inertial><mass value="2"/>
<inertia ixx="{MOMENT}" ixy="0" ixz="0" iyy="{MOMENT}" iyz="0" izz="{MOMENT}"/></inertial></link>
<joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/></joint></robot>"""

p.connect(p.DIRECT)
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "inertia.urdf"
    path.write_text(ROBOT)
    moment = max(p.getDynamicsInfo(p.loadURDF(str(path), useFixedBase=True), 0)[2])
print(
    f"{'gone' if abs(moment - MOMENT) < 1e-9 else 'still there'}: {moment:.3g} kg m2 of a link that the file gives {MOMENT:g}"
)
