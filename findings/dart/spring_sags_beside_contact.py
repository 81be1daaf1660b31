# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "bug"
# title = "A joint spring in equilibrium sags where a contact bears its foot"
# seen = ["6.20.0"]
# documented = "setSpringStiffness and setRestPosition make a linear spring. Nothing says that contacts change it."
# sources = ["dartpy.dynamics.RevoluteJoint: setSpringStiffness, setRestPosition, setDampingCoefficient"]
# mend = "the same law as a torque by setForce in each step, with a step that it is stable at"
# cases = ["stand_quadruped", "stand_humanoid"]
# cause = "springs that sag beside a contact"
# ///
"""A slider stands on a box and carries, on a hinge, a bar that its spring holds level: statics leaves it level, whatever bears the slider."""

import dartpy
import numpy as np

G, DT, R, STIFFNESS, DAMPING, LEVER = 9.81, 1 / 240, 0.1, 200.0, 20.0, 0.3

world = dartpy.simulation.World("w")
world.setTimeStep(DT)
world.setGravity([0, 0, -G])
world.setCollisionDetector(dartpy.simulation.CollisionDetectorType.ODE)
ground = dartpy.dynamics.Skeleton("ground")
joint, body = ground.createWeldJointAndBodyNodePair()
pose = dartpy.math.Isometry3()
pose.set_translation(np.array([0.0, 0.0, -0.1]))
joint.setTransformFromParentBodyNode(pose)
machine = dartpy.dynamics.Skeleton("machine")
slider, foot = machine.createPrismaticJointAndBodyNodePair()
slider.setAxis(np.array([0.0, 0.0, 1.0]))
slider.setPosition(0, R - 1e-6)
foot.setInertia(dartpy.dynamics.Inertia(2.0, np.zeros(3), np.eye(3) / 10))
for owner, size in ((body, [1.0, 1.0, 0.2]), (foot, [2 * R] * 3)):
    node = owner.createShapeNode(dartpy.dynamics.BoxShape(np.array(size)))
    node.createCollisionAspect()
    node.createDynamicsAspect()
hinge, bar = machine.createRevoluteJointAndBodyNodePair(foot)
hinge.setAxis(np.array([0.0, 1.0, 0.0]))
bar.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 10))
aside = dartpy.math.Isometry3()
aside.set_translation(np.array([-LEVER, 0.0, 0.0]))
hinge.setTransformFromChildBodyNode(aside)
hinge.setSpringStiffness(0, STIFFNESS)
hinge.setRestPosition(0, -1.0 * G * LEVER / STIFFNESS)
hinge.setDampingCoefficient(0, DAMPING)
ground.setMobile(False)
world.addSkeleton(ground)
world.addSkeleton(machine)
for _ in range(240):
    world.step()
sag = abs(float(hinge.getPosition(0)))
# In the first step the foot falls by g dt2, which the bar feels over its lever; ten times that is no matter of the step.
print(
    f"{'gone' if sag < 10 * G * DT**2 / LEVER else 'still there'}: the bar hangs {sag:.4f} rad off after 1 s; it belongs level, a step's fall is {G * DT**2 / LEVER:.5f} rad"
)
