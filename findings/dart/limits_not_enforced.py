# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0"]
#
# [tool.finding]
# engine = "dart"
# kind = "trap"
# title = "The limits of a URDF are read and not enforced"
# seen = ["6.20.0"]
# documented = "Joint.setLimitEnforcement turns position limits on; off is the default."
# sources = ["dartpy.dynamics.Joint: setLimitEnforcement, areLimitsEnforced"]
# mend = "joint.setLimitEnforcement(True) for each joint after loading"
# cases = []
# ///
"""A pendulum falls from level for half a second; the file stops it at 0.1 rad, which a step of 1 ms may pass by the way of one: less than 0.01 rad."""

import sys
import tempfile
import time
from pathlib import Path

import dartpy

ROBOT = """<robot name="p"><link name="b"/>
<link name="l"><inertial><origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="j" type="revolute"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/><limit lower="-0.1" upper="0.1" effort="9" velocity="2"/></joint></robot>"""


def measure(mended):
    """The pendulum's angle and its limit [rad], and the time of the steps [s]."""
    loader, options = dartpy.utils.DartLoader(), dartpy.utils.DartLoaderOptions()
    options.mDefaultRootJointType = dartpy.utils.DartLoaderRootJointType.FIXED
    loader.setOptions(options)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.urdf"
        path.write_text(ROBOT)
        robot = loader.parseSkeleton(str(path))
    if mended:
        robot.getJoint("j").setLimitEnforcement(True)
    world = dartpy.simulation.World("w")
    world.setGravity([0, 0, -9.81])
    world.addSkeleton(robot)
    begun = time.process_time()
    for _ in range(500):
        world.step()
    took = time.process_time() - begun
    return float(robot.getPositions()[0]), robot.getJoint("j").getPositionUpperLimit(0), took


MENDED = "--mended" in sys.argv
angle, upper, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if angle < upper + 0.01 else 'stands' if MENDED else 'still there'}: "
    f"{angle:.3f} rad after 0.5 s; the joint's upper limit reads {upper:g} rad"
)
