# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "Every body is damped unless it is told not to be"
# seen = ["3.2.7"]
# documented = "changeDynamics: linearDamping and angularDamping are 0.04 by default."
# sources = ["PyBullet Quickstart Guide, changeDynamics: linearDamping, angularDamping"]
# mend = "changeDynamics(body, -1, linearDamping=0, angularDamping=0), once on the base of each multibody"
# cases = ["flight_projectile", "joint_pendulum", "joint_double_pendulum", "spin_asymmetric_top"]
# tracks = ["default"]
# effects = ["linear_damping", "angular_damping"]
# cause = "hidden damping of 0.04/s"
# ///
"""A ball thrown at 8.6 m/s lands elsewhere than its parabola says; a step errs by g dt t/2 = 0.04 m, the damping by more than a metre."""

import math

import pybullet as p

G, DT, START = 9.81, 1 / 240, (3.0, 1.0, 8.0)

p.connect(p.DIRECT)
p.setGravity(0, 0, -G)
ball = p.createMultiBody(baseMass=1.0)
p.resetBaseVelocity(ball, START)
for _ in range(480):
    p.stepSimulation()
t = 480 * DT
true = [v * t - (G * t * t / 2 if k == 2 else 0.0) for k, v in enumerate(START)]
off = math.dist(p.getBasePositionAndOrientation(ball)[0], true)
step = G * DT * t / 2
print(
    f"{'gone' if off < 2 * step else 'still there'}: {off:.3f} m from the parabola after {t:g} s; the time step accounts for {step:.3f} m"
)
