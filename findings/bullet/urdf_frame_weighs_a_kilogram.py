# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "A URDF link without <inertial> gets 1 kg and 1 kg m²"
# seen = ["3.2.7"]
# documented = "The format says that such a link has zero mass and zero inertia. The loader prints 'No inertial data for link, using mass=1' on the console."
# sources = ["URDF, link element: inertial (optional: defaults to a zero mass and zero inertia if not specified)"]
# mend = "changeDynamics(robot, link, mass=0) after loading for each such link, or fixed frames merged into their parent in the file"
# cases = []
# ///
"""A link of 2 kg and 0.1 kg m2, its centre 0.5 m from a hinge, with a bare frame fixed to it 1 m from the hinge: 0.6 kg m2 are due about the hinge."""

import tempfile
from pathlib import Path

import pybullet as p

ROBOT = """<robot name="p"><link name="b"/>
<link name="l"><inertial><origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="t"/>
<joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/></joint>
<joint name="f" type="fixed"><parent link="l"/><child link="t"/><origin xyz="1 0 0"/></joint></robot>"""

p.connect(p.DIRECT)
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "frame.urdf"
    path.write_text(ROBOT)
    robot = p.loadURDF(str(path), useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
mass, about = p.getDynamicsInfo(robot, 1)[0], p.calculateMassMatrix(robot, [0.0])[0][0]
due = 0.1 + 2 * 0.5**2
print(
    f"{'gone' if abs(about - due) < 1e-6 else 'still there'}: the frame has {mass:g} kg; {about:.3f} kg m2 about the hinge, {due:g} are due"
)
