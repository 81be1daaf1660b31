# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "Bodies made by createMultiBody go no faster than 100 m/s and turn no faster than 100 rad/s"
# seen = ["3.2.7"]
# documented = "changeDynamics: maxJointVelocity, 100 by default, is that of a joint. That it holds for a free body without a joint, its linear velocity included, is not said."
# sources = ["PyBullet Quickstart Guide, changeDynamics: maxJointVelocity"]
# mend = "changeDynamics(body, -1, maxJointVelocity=1e6), or createMultiBody(..., useMaximalCoordinates=1), which has no such bound"
# cases = ["tunnel_sphere_wall", "spin_fast"]
# tracks = ["default"]
# cause = "velocities clamped at 100 m/s and 100 rad/s"
# ///
"""A ball alone in space, without damping, is sent off at 300 m/s, and another is spun at 300 rad/s."""

import pybullet as p

p.connect(p.DIRECT)
p.setTimeStep(1e-4)
thrown, spun = p.createMultiBody(baseMass=1.0), p.createMultiBody(baseMass=1.0, basePosition=[0, 9, 0])
for ball in (thrown, spun):
    p.changeDynamics(ball, -1, localInertiaDiagonal=[0.1] * 3)
    p.changeDynamics(ball, -1, linearDamping=0.0, angularDamping=0.0)
p.resetBaseVelocity(thrown, [300.0, 0, 0])
p.resetBaseVelocity(spun, [0, 0, 0], [0, 0, 300.0])
for _ in range(2):
    p.stepSimulation()
speed, spin = p.getBaseVelocity(thrown)[0][0], p.getBaseVelocity(spun)[1][2]
kept = abs(speed - 300) < 1e-6 and abs(spin - 300) < 1e-6
figure = f"{speed:g} m/s two steps after it was sent off at 300 m/s, {spin:g} rad/s of 300, with no force or torque on either"
print(f"{'gone' if kept else 'still there'}: {figure}")
