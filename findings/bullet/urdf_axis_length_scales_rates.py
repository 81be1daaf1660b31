# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "The length of a URDF joint's axis scales its accelerations and not its angles"
# seen = ["3.2.7"]
# documented = "The format asks for a normalized vector. Other readers of URDF normalise what they get; this one keeps the length in the joint's rates without a word."
# sources = ["URDF, joint element: axis (the vector should be normalized)"]
# mend = "axes of unit length in the file"
# cases = []
# ///
"""A pendulum let go from level accelerates by m g l / I, whatever the length of the vector that its axis is told by."""

import tempfile
from pathlib import Path

import pybullet as p

G, MASS, REACH, MOMENT, DT = 9.81, 2.0, 0.5, 0.1, 1e-4
INERTIAL = f'<inertial><origin xyz="{REACH} 0 0"/><mass value="{MASS}"/><inertia ixx="{MOMENT}" ixy="0" ixz="0" iyy="{MOMENT}" iyz="0" izz="{MOMENT}"/></inertial>'

p.connect(p.DIRECT)
p.setGravity(0, 0, -G)
p.setTimeStep(DT)
found = []
for axis in ("0 1 0", "0 2 0"):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"axis_{axis.replace(' ', '_')}.urdf"
        path.write_text(
            f'<robot name="p"><link name="b"/><link name="l">{INERTIAL}</link><joint name="j" type="continuous"><parent link="b"/>'
            f'<child link="l"/><axis xyz="{axis}"/></joint></robot>'
        )
        robot = p.loadURDF(str(path), useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
    p.changeDynamics(robot, -1, linearDamping=0.0, angularDamping=0.0)
    p.setJointMotorControl2(robot, 0, p.VELOCITY_CONTROL, force=0)
    p.stepSimulation()
    found.append(p.getJointState(robot, 0)[1] / DT)
    p.removeBody(robot)
print(
    f"{'gone' if abs(found[1] / found[0] - 1) < 0.01 else 'still there'}: {found[0]:.2f} rad/s2 with an axis of length 1, {found[1]:.2f} with length 2"
)
