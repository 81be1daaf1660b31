# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "trap"
# title = "FCL, the default collision detector, takes a capsule for a sphere of 0.1 m"
# seen = ["6.20.0"]
# documented = "A line on the console says that the shape is not supported and that a sphere is used instead; nothing that a program could ask says so."
# sources = ["DART, dart/collision/fcl/FCLCollisionDetector.cpp: createFCLCollisionGeometry"]
# mend = "CollisionDetectorType.BULLET, or ODE for capsules that stand on end"
# cases = []
# ///
"""A capsule of 0.3 m and 0.05 m radius stands upright on a box: its centre belongs 0.2 m over it."""

import dartpy
import numpy as np

G, DT, R, LENGTH = 9.81, 1 / 240, 0.05, 0.3

world = dartpy.simulation.World("w")
world.setTimeStep(DT)
world.setGravity([0, 0, -G])
due = LENGTH / 2 + R
for name, shape, z, mobile in (
    ("ground", dartpy.dynamics.BoxShape(np.array([1.0, 1.0, 0.2])), -0.1, False),
    ("capsule", dartpy.dynamics.CapsuleShape(R, LENGTH), due, True),
):
    skeleton = dartpy.dynamics.Skeleton(name)
    joint, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 150))
    node = body.createShapeNode(shape)
    node.createCollisionAspect()
    node.createDynamicsAspect()
    pose = dartpy.math.Isometry3()
    pose.set_translation(np.array([0.0, 0.0, z]))
    joint.setTransform(pose)
    skeleton.setMobile(mobile)
    world.addSkeleton(skeleton)
# A tenth of a second: it has not had the time to tip over from upright.
for _ in range(24):
    world.step()
height = float(body.getWorldTransform().translation()[2])
fallen = due - G * 0.1**2 / 2
gone = abs(height - due) < abs(height - fallen)
print(
    f"{'gone' if gone else 'still there'}: after 0.1 s its centre is at {height:.3f} m; {due:g} m are due, a free fall has come to {fallen:.3f} m"
)
