# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "A damping of 0.04 acts as 0.04 (1 + |v|) a second in multibody coordinates"
# seen = ["3.2.7"]
# documented = "changeDynamics: linear damping of the link, 0.04 by default. A dependence on the speed is not mentioned; the source adds one of the same coefficient (DAMPING_K2)."
# sources = [
#   "PyBullet Quickstart Guide, changeDynamics: linearDamping",
#   "https://github.com/bulletphysics/bullet3/blob/master/src/BulletDynamics/Featherstone/btMultiBody.cpp",
# ]
# mend = "changeDynamics(body, -1, linearDamping=0, angularDamping=0), and damping as a force of one's own where it is wanted"
# cases = ["flight_projectile", "joint_pendulum", "joint_double_pendulum", "friction_stop"]
# tracks = ["default"]
# ///
"""A ball alone in space, 10 m/s fast, for a second: plain damping of c = 0.04 leaves v e^-c, c (1 + v) takes v/(1 + v) to e^-c of itself."""

import math

import pybullet as p

SPEED, DAMPING = 10.0, 0.04

p.connect(p.DIRECT)
ball = p.createMultiBody(baseMass=1.0)
p.resetBaseVelocity(ball, [SPEED, 0, 0])
for _ in range(240):
    p.stepSimulation()
left = p.getBaseVelocity(ball)[0][0]
plain = SPEED * math.exp(-DAMPING)
share = SPEED / (1 + SPEED) * math.exp(-DAMPING)
quadratic = share / (1 - share)
figure = f"{left:.3f} m/s are left of {SPEED:g} after 1 s; damping as documented leaves {plain:.3f}, 0.04 (1 + |v|) leaves {quadratic:.3f}"
print(f"{'gone' if abs(left - plain) < abs(left - quadratic) else 'still there'}: {figure}")
