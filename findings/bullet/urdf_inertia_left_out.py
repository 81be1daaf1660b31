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
"""A link of 0.1 kg m2, without a collision shape and with a ball of 0.1 m: the file's inertia is the link's."""

import sys
import tempfile
import time
from pathlib import Path

import pybullet as p

MOMENT = 0.1
BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'


def measure(mended):
    """The link's moment [kg m2] without and with a shape, and the time of the loading [s]."""
    p.connect(p.DIRECT)
    moments, took = [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        for k, shape in enumerate(("", BALL)):
            path = Path(folder) / f"{k}.urdf"
            path.write_text(f"""<robot name="p"><link name="b"/><link name="l"><inertial><mass value="2"/>
<inertia ixx="{MOMENT}" ixy="0" ixz="0" iyy="{MOMENT}" iyz="0" izz="{MOMENT}"/></inertial>{shape}</link>
<joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/></joint></robot>""")
            begun = time.process_time()
            robot = p.loadURDF(str(path), useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE if mended else 0)
            took += time.process_time() - begun
            moments.append(max(p.getDynamicsInfo(robot, 0)[2]))
    p.disconnect()
    return moments, took


MENDED = "--mended" in sys.argv
moments, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a loading")
print(
    f"{'gone' if max(abs(moment - MOMENT) for moment in moments) < 1e-9 else 'stands' if MENDED else 'still there'}: "
    f"{moments[0]:.3g} kg m2 of a link without a shape and {moments[1]:.3g} with one; the file gives {MOMENT:g}"
)
