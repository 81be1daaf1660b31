# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "With a URDF axis of length 2, a joint and the pose of its link lag by half"
# seen = ["3.2.7"]
# documented = "The format asks for a normalized vector. Other readers of URDF normalise what they get; this one divides the joint's rates by the length, poses follow them, and nothing is printed."
# sources = ["URDF, joint element: axis (the vector should be normalized)"]
# mend = "axes of unit length in the file"
# cases = []
# ///
"""A pendulum let go from level falls by m g l t^2/(2 I) within a tenth of a second, whatever the length of the vector that its axis is told by."""

import math
import sys
import tempfile
import time
from pathlib import Path

import pybullet as p

G, MASS, REACH, MOMENT, DT = 9.81, 2.0, 0.5, 0.1, 1e-4
INERTIAL = (
    f'<inertial><origin xyz="{REACH} 0 0"/><mass value="{MASS}"/>'
    f'<inertia ixx="{MOMENT}" ixy="0" ixz="0" iyy="{MOMENT}" iyz="0" izz="{MOMENT}"/></inertial>'
)


def swing(length):
    """The pendulum's angle by its joint and by its pose after 0.1 s [rad], and the time of its steps [s]."""
    p.connect(p.DIRECT)
    p.setGravity(0, 0, -G)
    p.setTimeStep(DT)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pendulum.urdf"
        path.write_text(
            f'<robot name="p"><link name="b"/><link name="l">{INERTIAL}</link><joint name="j" type="continuous"><parent link="b"/>'
            f'<child link="l"/><axis xyz="0 {length} 0"/></joint></robot>'
        )
        robot = p.loadURDF(str(path), useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
    p.changeDynamics(robot, -1, linearDamping=0.0, angularDamping=0.0)
    p.setJointMotorControl2(robot, 0, p.VELOCITY_CONTROL, force=0)
    begun = time.process_time()
    for _ in range(1000):
        p.stepSimulation()
    took = time.process_time() - begun
    x, _, z = p.getLinkState(robot, 0, computeForwardKinematics=1)[0]
    angle = p.getJointState(robot, 0)[0]
    p.disconnect()
    return angle, math.atan2(-z, x), took


def measure(mended):
    """Angles by joint and by pose [rad], of a pendulum by a longer axis over those of one by a unit axis; the time of steps [s]."""
    unit, longer = swing(1.0), swing(1.0 if mended else 2.0)
    return longer[0] / unit[0], longer[1] / unit[1], longer[2]


MENDED = "--mended" in sys.argv
joint, pose, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if abs(pose - 1) < 0.01 else 'stands' if MENDED else 'still there'}: "
    f"an axis of length {1 if MENDED else 2} takes the joint {joint:.3f} times as far as one of length 1, and the link {pose:.3f} times"
)
