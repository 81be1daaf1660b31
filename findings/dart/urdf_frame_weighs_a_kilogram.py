# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "trap"
# title = "A URDF link without <inertial> gets 1 kg and 1 kg m²"
# seen = ["6.20.0"]
# documented = "A link without one is given DartLoaderOptions.mDefaultInertia, 1 kg and 1 kg m2 unless it is set. The format says that such a link has zero mass and zero inertia."
# sources = ["URDF, link element: inertial (optional: defaults to a zero mass and zero inertia if not specified)"]
# mend = "DartLoaderOptions.mDefaultInertia = Inertia(1e-9, zeros(3), 1e-9 * eye(3)), or fixed frames merged into their parent in the file"
# cases = []
# ///
"""A link of 2 kg and 0.1 kg m2, its centre 0.5 m from a hinge, with a bare frame fixed to it 1 m from the hinge: 0.6 kg m2 are due about the hinge."""

import sys
import tempfile
import time
from pathlib import Path

import dartpy
import numpy as np

ROBOT = """<robot name="p"><link name="b"/>
<link name="l"><inertial><origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="t"/>
<joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/></joint>
<joint name="f" type="fixed"><parent link="l"/><child link="t"/><origin xyz="1 0 0"/></joint></robot>"""
DUE = 0.1 + 2 * 0.5**2


def measure(mended):
    """The frame's mass [kg], the inertia about the hinge [kg m2] and the time of a thousand steps [s]."""
    loader, options = dartpy.utils.DartLoader(), dartpy.utils.DartLoaderOptions()
    options.mDefaultRootJointType = dartpy.utils.DartLoaderRootJointType.FIXED
    if mended:
        options.mDefaultInertia = dartpy.dynamics.Inertia(1e-9, np.zeros(3), 1e-9 * np.eye(3))
    loader.setOptions(options)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.urdf"
        path.write_text(ROBOT)
        robot = loader.parseSkeleton(str(path))
    world = dartpy.simulation.World("w")
    world.addSkeleton(robot)
    mass, about = robot.getBodyNode("t").getMass(), float(robot.getMassMatrix()[0, 0])
    begun = time.process_time()
    for _ in range(1000):
        world.step()
    return mass, about, time.process_time() - begun


MENDED = "--mended" in sys.argv
mass, about, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if abs(about - DUE) < 1e-6 else 'stands' if MENDED else 'still there'}: "
    f"the frame has {mass:g} kg; {about:.3f} kg m2 about the hinge, {DUE:g} are due"
)
