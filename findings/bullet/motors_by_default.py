# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "A joint has a motor of 1 N m s a step unless it is told not to"
# seen = ["3.2.7"]
# documented = "setJointMotorControl2: by default each revolute and prismatic joint is motorised with a velocity motor; force=0 disables it. That its size is an impulse a step, so that a finer step makes it stronger, is not said."
# sources = [
#   "PyBullet Quickstart Guide, setJointMotorControl2",
#   "sdist of pybullet 3.2.7, examples/SharedMemory/PhysicsServerCommandProcessor.cpp: createJointMotors, maxMotorImpulse",
# ]
# mend = "setJointMotorControl2(body, joint, VELOCITY_CONTROL, force=0) for each joint"
# cases = []
# ///
"""A pendulum of 1 kg let go from level falls; with its motor it hangs where it is. Both kinds of joints, two steps."""

import math
import sys
import time

import pybullet as p

G, ARM, MASS = 9.81, 1.0, 1.0


def fallen(mended, kind, dt):
    """How far [m] the weight has come in 0.2 s, and the time of the steps [s]."""
    p.connect(p.DIRECT)
    p.setPhysicsEngineParameter(fixedTimeStep=dt)
    p.setGravity(0, 0, -G)
    body = p.createMultiBody(
        baseMass=0.0,
        linkMasses=[MASS],
        linkCollisionShapeIndices=[-1],
        linkVisualShapeIndices=[-1],
        linkPositions=[[0, 0, 0]],
        linkOrientations=[[0, 0, 0, 1]],
        linkInertialFramePositions=[[ARM, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]],
        linkParentIndices=[0],
        linkJointTypes=[kind],
        linkJointAxis=[[0, 0, 1] if kind == p.JOINT_PRISMATIC else [0, 1, 0]],
    )
    p.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0)
    p.changeDynamics(body, 0, mass=MASS, localInertiaDiagonal=[1e-4] * 3)
    if mended:
        p.setJointMotorControl2(body, 0, p.VELOCITY_CONTROL, force=0)
    begun = time.process_time()
    for _ in range(round(0.2 / dt)):
        p.stepSimulation()
    took = time.process_time() - begun
    distance = math.dist(p.getLinkState(body, 0, computeForwardKinematics=1)[0], (ARM, 0, 0))
    p.disconnect()
    return distance, took


def measure(mended):
    """The least way [m] of four pendulums, and the time of their steps [s]."""
    runs = [fallen(mended, kind, dt) for kind in (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC) for dt in (1 / 240, 1e-3)]
    return min(distance for distance, _ in runs), sum(took for _, took in runs)


MENDED = "--mended" in sys.argv
distance, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if distance > 0.9 * G * 0.2**2 / 2 else 'stands' if MENDED else 'still there'}: "
    f"a hinge and a slider let 1 kg fall by {distance:.3f} m in 0.2 s, at 1/240 s and at 1 ms; {G * 0.2**2 / 2:.3f} m are due"
)
