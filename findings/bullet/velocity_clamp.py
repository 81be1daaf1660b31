# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "In multibody coordinates, pybullet's default, each coordinate of a body's velocity is clamped at 100 m/s or 100 rad/s"
# seen = ["3.2.7"]
# documented = "changeDynamics: maxJointVelocity, 100 by default, is that of a joint. That it holds for each coordinate of a free body, its linear velocity included, is not said."
# sources = [
#   "PyBullet Quickstart Guide, changeDynamics: maxJointVelocity",
#   "sdist of pybullet 3.2.7, src/BulletDynamics/Featherstone/btMultiBody.h: btMultiBody::applyDeltaVeeMultiDof; btMultiBody.cpp: m_maxCoordinateVelocity(100.f)",
# ]
# mend = "changeDynamics(body, -1, maxJointVelocity=1e6), or createMultiBody(..., useMaximalCoordinates=1), which has no such bound"
# cases = ["tunnel_sphere_wall", "spin_fast"]
# tracks = ["default"]
# cause = "velocities clamped at 100 m/s and 100 rad/s in each coordinate"
# ///
"""Two balls alone in space, without damping, are sent off at 300 m/s and 300 rad/s, one along an axis and one along a diagonal: without a force they go on as fast (Newton's first law)."""

import math
import sys
import time

import pybullet as p

SPEED = 300.0
ALONG = [(1.0, 0.0, 0.0), (1 / math.sqrt(3),) * 3]


def measure(mended, maximal=False):
    """Speed and spin two steps later, along an axis and along a diagonal [m/s, rad/s], and the time of two hundred steps [s]."""
    p.connect(p.DIRECT)
    p.setTimeStep(1e-4)
    left = []
    for away, direction in enumerate(ALONG):
        ball = p.createMultiBody(baseMass=1.0, basePosition=[0, 9 * away, 0], useMaximalCoordinates=maximal)
        p.changeDynamics(ball, -1, mass=1.0, localInertiaDiagonal=[0.1] * 3)
        p.changeDynamics(ball, -1, linearDamping=0.0, angularDamping=0.0)
        if mended:
            p.changeDynamics(ball, -1, maxJointVelocity=1e6)
        p.resetBaseVelocity(ball, *[[SPEED * d for d in direction]] * 2)
    for _ in range(2):
        p.stepSimulation()
    for ball in range(p.getNumBodies()):
        left += [math.hypot(*velocity) for velocity in p.getBaseVelocity(ball)]
    begun = time.process_time()
    for _ in range(200):
        p.stepSimulation()
    took = time.process_time() - begun
    p.disconnect()
    return left, took


MENDED = "--mended" in sys.argv
left, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if max(abs(value - SPEED) for value in left) < 1e-6 else 'stands' if MENDED else 'still there'}: "
    f"of {SPEED:g} m/s and rad/s two steps leave {left[0]:.1f} and {left[1]:.1f} along an axis, {left[2]:.1f} and {left[3]:.1f} along a diagonal; "
    f"in maximal coordinates {min(measure(MENDED, True)[0]):.1f} at least; no force or torque acts"
)
