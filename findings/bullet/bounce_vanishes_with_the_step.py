# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "A bounce vanishes as the step shrinks: by default a ball of e 0.7 dropped from a metre stays down at 1/3840 s"
# seen = ["3.2.7"]
# documented = "Nothing is said of it. changeDynamics: contactProcessingThreshold, contacts with a distance below this threshold are processed by the constraint solver; for restitution the guide advises to set it to 0."
# sources = [
#   "PyBullet Quickstart Guide, changeDynamics: restitution, contactProcessingThreshold",
#   "sdist of pybullet 3.2.7, src/BulletDynamics/Featherstone/btMultiBodyConstraintSolver.cpp: setupMultiBodyContactConstraint; ConstraintSolver/btSequentialImpulseConstraintSolver.cpp: setupContactConstraint",
# ]
# mend = "changeDynamics(body, -1, contactProcessingThreshold=0) on both bodies, and setPhysicsEngineParameter(contactERP=0), without which the ball comes back up to a quarter too high"
# cases = ["impact_bounce"]
# ///
"""A ball without damping is dropped from a metre and comes back to e^2 of it. A step lets it fall by v dt more or less, 2 v dt/h of the height: 4 % at 1/240 s, and less below."""

import math
import sys
import time

import pybullet as p

G, R, SQUARED = 9.81, 0.1, 0.5
STEPS = (1 / 240, 1 / 960, 1 / 3840)


def apex(mended, dt, maximal=False):
    """How high [m] the ball comes back from a metre, and the time of the steps [s]."""
    p.connect(p.DIRECT)
    p.setGravity(0, 0, -G)
    p.setPhysicsEngineParameter(fixedTimeStep=dt, **({"contactERP": 0.0} if mended else {}))
    slab = p.createCollisionShape(p.GEOM_BOX, halfExtents=[5, 5, 0.5])
    ground = p.createMultiBody(0, slab, basePosition=[0, 0, -0.5], useMaximalCoordinates=maximal)
    shape = p.createCollisionShape(p.GEOM_SPHERE, radius=R)
    ball = p.createMultiBody(1.0, shape, basePosition=[0, 0, R + 1], useMaximalCoordinates=maximal)
    for body in (ground, ball):
        p.changeDynamics(body, -1, restitution=SQUARED**0.25)  # the pair's is the product
        if mended:
            p.changeDynamics(body, -1, contactProcessingThreshold=0.0)
    p.changeDynamics(ball, -1, linearDamping=0.0, angularDamping=0.0)
    highest, back, begun = 0.0, False, time.process_time()
    for _ in range(round(0.9 / dt)):
        p.stepSimulation()
        back = back or p.getBaseVelocity(ball)[0][2] > 0
        highest = max(highest, p.getBasePositionAndOrientation(ball)[0][2] - R) if back else 0.0
    took = time.process_time() - begun
    p.disconnect()
    return highest, took


def measure(mended):
    """The heights [m] at each step, and the time of the steps [s]."""
    runs = [apex(mended, dt) for dt in STEPS]
    return [height for height, _ in runs], sum(took for _, took in runs)


MENDED = "--mended" in sys.argv
heights, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if all(abs(height / SQUARED - 1) < 2 * math.sqrt(2 * G) * dt for height, dt in zip(heights, STEPS)) else 'stands' if MENDED else 'still there'}: "
    f"it comes back to {', '.join(f'{height:.3f}' for height in heights)} m at 1/240, 1/960 and 1/3840 s; in maximal coordinates to "
    f"{', '.join(f'{apex(MENDED, dt, True)[0]:.3f}' for dt in STEPS)} m; {SQUARED:g} m are due"
)
