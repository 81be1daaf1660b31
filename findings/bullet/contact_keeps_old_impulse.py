# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "In maximal coordinates with contactProcessingThreshold=0, a contact point that has come apart reports the impulse of an earlier step"
# seen = ["3.2.7"]
# documented = "getContactPoints: normalForce is the normal force applied during the last stepSimulation."
# sources = [
#   "PyBullet Quickstart Guide, getContactPoints: normalForce",
#   "sdist of pybullet 3.2.7, src/BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.cpp: convertContact, which leaves out points beyond the threshold with their m_appliedImpulse",
# ]
# mend = "leave out points whose distance is above zero; the default threshold, and multibody coordinates, do not need it"
# cases = ["stand_hit", "impact_bounce"]
# ///
"""A ball of 2 kg bounces once: what is reported sums to the change of its momentum. Both coordinates, with the threshold as it comes and at 0."""

import math
import sys
import time

import pybullet as p

DT, SPEED, MASS, E = 1e-3, 3.0, 2.0, 0.5


def measure(mended, maximal=True, threshold=True):
    """The share of the change of momentum that is reported [1], and the time of steps and readings [s]."""
    p.connect(p.DIRECT)
    p.setPhysicsEngineParameter(fixedTimeStep=DT, contactSlop=0.0, useSplitImpulse=1, splitImpulsePenetrationThreshold=0.0)
    slab = p.createCollisionShape(p.GEOM_BOX, halfExtents=[5, 5, 0.5])
    ground = p.createMultiBody(0.0, slab, basePosition=[0, 0, -0.5], useMaximalCoordinates=maximal)
    shape = p.createCollisionShape(p.GEOM_SPHERE, radius=0.1)
    ball = p.createMultiBody(MASS, shape, basePosition=[0, 0, 0.102], useMaximalCoordinates=maximal)
    for body in (ground, ball):
        p.changeDynamics(body, -1, restitution=math.sqrt(E))
        if threshold:
            p.changeDynamics(body, -1, contactProcessingThreshold=0.0)
    p.changeDynamics(ball, -1, linearDamping=0.0, angularDamping=0.0, activationState=p.ACTIVATION_STATE_DISABLE_SLEEPING)
    p.resetBaseVelocity(ball, [0, 0, -SPEED])
    reported, begun = 0.0, time.process_time()
    for _ in range(40):
        p.stepSimulation()
        reported += sum(point[9] for point in p.getContactPoints() if not mended or point[8] <= 0) * DT
    took = time.process_time() - begun
    change = MASS * (p.getBaseVelocity(ball)[0][2] + SPEED)
    p.disconnect()
    return reported / change, took


MENDED = "--mended" in sys.argv
share, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if abs(share - 1) < 0.01 else 'stands' if MENDED else 'still there'}: "
    f"{share:.2f} times the change of momentum is reported; multibody {measure(MENDED, False)[0]:.2f}; "
    f"with the default threshold {measure(False, True, False)[0]:.2f} and {measure(False, False, False)[0]:.2f}"
)
