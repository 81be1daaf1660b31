# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "loadMJCF takes the angles of a file without a <compiler> element for radians"
# seen = ["3.2.7"]
# documented = "MJCF: compiler/angle is degree by default. The loader calls itself a basic import of MJCF files; with a <compiler> element, an empty one too, it takes degrees."
# sources = [
#   "MuJoCo, XML Reference: compiler, angle",
#   "PyBullet Quickstart Guide, loadMJCF",
#   "sdist of pybullet 3.2.7, examples/Importers/ImportMJCFDemo/BulletMJCFImporter.cpp: parseCompiler, which alone sets m_angleUnits",
# ]
# mend = '<compiler/> in the file, or <compiler angle="degree"/>'
# cases = []
# ///
"""A hinge whose range is 90 degrees to either side, in a file that says nothing about its angles: its upper limit is pi/2."""

import math
import sys
import tempfile
import time
from pathlib import Path

import pybullet as p


def measure(mended):
    """The upper limit of the hinge [rad], and the time of the loading [s]."""
    p.connect(p.DIRECT)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hinge.xml"
        path.write_text(
            f'<mujoco>{"<compiler/>" * mended}<worldbody><body name="l"><joint name="j" type="hinge" axis="0 1 0" limited="true" '
            'range="-90 90"/><geom type="sphere" size="0.1"/></body></worldbody></mujoco>'
        )
        begun = time.process_time()
        body = max(p.loadMJCF(str(path)), key=p.getNumJoints)
        took = time.process_time() - begun
    upper = p.getJointInfo(body, 0)[9]
    p.disconnect()
    return upper, took


MENDED = "--mended" in sys.argv
upper, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a loading")
print(
    f"{'gone' if abs(upper - math.pi / 2) < 1e-6 else 'stands' if MENDED else 'still there'}: "
    f"an upper limit of {upper:g} rad, {math.pi / 2:.4f} are due"
)
