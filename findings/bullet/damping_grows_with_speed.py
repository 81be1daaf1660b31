# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "A damping of 0.04 acts as 0.04 (1 + |v|) a second in multibody coordinates"
# seen = ["3.2.7"]
# documented = "changeDynamics: linear damping of the link, 0.04 by default. A dependence on the speed is not mentioned; the source adds one of the same coefficient (DAMPING_K2_LINEAR, DAMPING_K2_ANGULAR)."
# sources = [
#   "PyBullet Quickstart Guide, changeDynamics: linearDamping",
#   "sdist of pybullet 3.2.7, src/BulletDynamics/Featherstone/btMultiBody.cpp: btMultiBody::computeAccelerationsArticulatedBodyAlgorithmMultiDof",
# ]
# mend = "changeDynamics(body, -1, linearDamping=0, angularDamping=0), and applyExternalForce of -m c v in each step if damping is wanted"
# cases = ["flight_projectile", "joint_pendulum", "joint_double_pendulum", "friction_stop"]
# tracks = ["default"]
# ///
"""A ball alone in space, 10 m/s fast, for a second: plain damping of c = 0.04 leaves v e^-c, c (1 + v) takes v/(1 + v) to e^-c of itself."""

import math
import sys
import time

import pybullet as p

SPEED, DAMPING, MASS = 10.0, 0.04, 1.0
PLAIN = SPEED * math.exp(-DAMPING)
SHARE = SPEED / (1 + SPEED) * math.exp(-DAMPING)
QUADRATIC = SHARE / (1 - SHARE)


def measure(mended):
    """The speed that is left after a second [m/s], and the time of its steps [s]."""
    p.connect(p.DIRECT)
    ball = p.createMultiBody(baseMass=MASS)
    if mended:
        p.changeDynamics(ball, -1, linearDamping=0.0, angularDamping=0.0)
    p.resetBaseVelocity(ball, [SPEED, 0, 0])
    begun = time.process_time()
    for _ in range(240):
        if mended:
            force = [-MASS * DAMPING * v for v in p.getBaseVelocity(ball)[0]]
            p.applyExternalForce(ball, -1, force, [0, 0, 0], p.LINK_FRAME)
        p.stepSimulation()
    took = time.process_time() - begun
    left = p.getBaseVelocity(ball)[0][0]
    p.disconnect()
    return left, took


MENDED = "--mended" in sys.argv
left, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if abs(left - PLAIN) < abs(left - QUADRATIC) else 'stands' if MENDED else 'still there'}: "
    f"{left:.3f} m/s are left of {SPEED:g} after 1 s; damping as documented leaves {PLAIN:.3f}, 0.04 (1 + |v|) leaves {QUADRATIC:.3f}"
)
