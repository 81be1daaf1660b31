# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "A contact point that has come apart goes on reporting the impulse of an earlier step"
# seen = ["3.2.7"]
# documented = "getContactPoints: normalForce is the normal force applied during the last stepSimulation."
# sources = ["PyBullet Quickstart Guide, getContactPoints: normalForce"]
# mend = "with contactProcessingThreshold=0 leave out points whose distance is above zero"
# cases = ["stand_hit", "impact_bounce"]
# ///
"""A ball of 2 kg bounces once: what acts is m (1 + e) v = 9 N s. Contacts wait until they touch, so that nothing acts over a gap."""

import math

import pybullet as p

DT, SPEED, MASS, E = 1e-3, 3.0, 2.0, 0.5

p.connect(p.DIRECT)
p.setPhysicsEngineParameter(fixedTimeStep=DT, contactSlop=0.0, useSplitImpulse=1, splitImpulsePenetrationThreshold=0.0)
slab = p.createCollisionShape(p.GEOM_BOX, halfExtents=[5, 5, 0.5])
ground = p.createMultiBody(0.0, slab, basePosition=[0, 0, -0.5], useMaximalCoordinates=1)
ball = p.createMultiBody(
    MASS, p.createCollisionShape(p.GEOM_SPHERE, radius=0.1), basePosition=[0, 0, 0.102], useMaximalCoordinates=1
)
for body in (ground, ball):
    p.changeDynamics(body, -1, restitution=math.sqrt(E), contactProcessingThreshold=0.0)
p.changeDynamics(ball, -1, linearDamping=0.0, angularDamping=0.0, activationState=p.ACTIVATION_STATE_DISABLE_SLEEPING)
p.resetBaseVelocity(ball, [0, 0, -SPEED])
reported = 0.0
for _ in range(40):
    p.stepSimulation()
    reported += sum(point[9] for point in p.getContactPoints()) * DT
due = MASS * (1 + E) * SPEED
print(
    f"{'gone' if abs(reported / due - 1) < 0.01 else 'still there'}: {reported:.2f} N s are reported of an impact of {due:.2f} N s"
)
