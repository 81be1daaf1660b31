# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "In multibody coordinates, pybullet's default, a body is damped by 0.04 unless it is told not to be"
# seen = ["3.2.7"]
# documented = "changeDynamics: linearDamping and angularDamping are 0.04 by default. That a body with useMaximalCoordinates=1 has none is not said; getDynamicsInfo shows neither."
# sources = [
#   "PyBullet Quickstart Guide, changeDynamics: linearDamping, angularDamping",
#   "sdist of pybullet 3.2.7, src/BulletDynamics/Featherstone/btMultiBody.cpp: btMultiBody::btMultiBody, m_linearDamping(0.04f)",
# ]
# mend = "changeDynamics(body, -1, linearDamping=0, angularDamping=0), once on the base of each multibody"
# cases = ["flight_projectile", "joint_pendulum", "joint_double_pendulum", "spin_asymmetric_top"]
# tracks = ["default"]
# effects = ["linear_damping", "angular_damping"]
# cause = "hidden damping of 0.04/s"
# ///
"""A ball thrown at 8.6 m/s lands elsewhere than its parabola says; a step errs by g dt t/2 = 0.04 m, the damping by more than a metre."""

import math
import sys
import time

import pybullet as p

G, DT, START, T = 9.81, 1 / 240, (3.0, 1.0, 8.0), 2.0
STEP = G * DT * T / 2


def measure(mended, maximal=False):
    """How far from the parabola the ball ends [m], and the time of its steps [s]."""
    p.connect(p.DIRECT)
    p.setGravity(0, 0, -G)
    ball = p.createMultiBody(baseMass=1.0, useMaximalCoordinates=maximal)
    if mended:
        p.changeDynamics(ball, -1, linearDamping=0.0, angularDamping=0.0)
    p.resetBaseVelocity(ball, START)
    begun = time.process_time()
    for _ in range(round(T / DT)):
        p.stepSimulation()
    took = time.process_time() - begun
    true = [v * T - (G * T * T / 2 if k == 2 else 0.0) for k, v in enumerate(START)]
    off = math.dist(p.getBasePositionAndOrientation(ball)[0], true)
    p.disconnect()
    return off, took


MENDED = "--mended" in sys.argv
off, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if off < 2 * STEP else 'stands' if MENDED else 'still there'}: "
    f"{off:.3f} m from the parabola after {T:g} s; in maximal coordinates {measure(MENDED, True)[0]:.3f} m; the time step accounts for {STEP:.3f} m"
)
