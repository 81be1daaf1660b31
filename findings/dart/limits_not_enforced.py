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
"""A pendulum falls from level for half a second; the file stops it at 0.1 rad."""

import tempfile
from pathlib import Path

import dartpy

ROBOT = """<robot name="p"><link name="b"/>
<link name="l"><inertial><origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="j" type="revolute"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/><limit lower="-0.1" upper="0.1" effort="9" velocity="2"/></joint></robot>"""

loader, options = dartpy.utils.DartLoader(), dartpy.utils.DartLoaderOptions()
options.mDefaultRootJointType = dartpy.utils.DartLoaderRootJointType.FIXED
loader.setOptions(options)
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "limit.urdf"
    path.write_text(ROBOT)
    robot = loader.parseSkeleton(str(path))
world = dartpy.simulation.World("w")
world.setGravity([0, 0, -9.81])
world.addSkeleton(robot)
for _ in range(500):
    world.step()
angle, upper = float(robot.getPositions()[0]), robot.getJoint("j").getPositionUpperLimit(0)
print(f"{'gone' if angle < 0.2 else 'still there'}: {angle:.3f} rad after 0.5 s; the joint's upper limit reads {upper:g} rad")
