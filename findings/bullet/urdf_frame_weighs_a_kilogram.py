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
# sources = [
#   "URDF, link element: inertial (optional: defaults to a zero mass and zero inertia if not specified)",
#   "sdist of pybullet 3.2.7, examples/Importers/ImportURDFDemo/BulletUrdfImporter.cpp: getMassAndInertia2, getMassAndInertia",
# ]
# mend = "changeDynamics(robot, link, mass=0) after loading for each such link, or fixed frames merged into their parent in the file; URDF_MERGE_FIXED_LINKS adds the kilogram to the parent"
# cases = []
# ///
"""A link of 2 kg and 0.1 kg m2, its centre 0.5 m from a hinge, with a bare frame fixed to it 1 m from the hinge: 0.6 kg m2 are due about the hinge."""

import sys
import tempfile
import time
from pathlib import Path

import pybullet as p

ROBOT = """<robot name="p"><link name="b"/>
<link name="l"><inertial><origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="t"/>
<joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/></joint>
<joint name="f" type="fixed"><parent link="l"/><child link="t"/><origin xyz="1 0 0"/></joint></robot>"""
DUE = 0.1 + 2 * 0.5**2


def measure(mended):
    """The frame's mass [kg], the inertia about the hinge [kg m2] and the time of a thousand steps [s]."""
    p.connect(p.DIRECT)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frame.urdf"
        path.write_text(ROBOT)
        robot = p.loadURDF(str(path), useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
    if mended:
        p.changeDynamics(robot, 1, mass=0.0)
    mass, about = p.getDynamicsInfo(robot, 1)[0], p.calculateMassMatrix(robot, [0.0])[0][0]
    begun = time.process_time()
    for _ in range(1000):
        p.stepSimulation()
    took = time.process_time() - begun
    p.disconnect()
    return mass, about, took


MENDED = "--mended" in sys.argv
mass, about, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if abs(about - DUE) < 1e-6 else 'stands' if MENDED else 'still there'}: "
    f"the frame has {mass:g} kg; {about:.3f} kg m2 about the hinge, {DUE:g} are due"
)
