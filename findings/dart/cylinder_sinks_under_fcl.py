# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "bug"
# title = "A cylinder on its side sinks into a box under FCL, the default collision detector"
# seen = ["6.20.0"]
# documented = "FCL is the default detector and takes cylinders. The console warns that its primitive shapes are not complete."
# sources = ["https://github.com/dartsim/dart/pull/405", "https://github.com/gazebosim/gz-physics/issues/692"]
# mend = "CollisionDetectorType.BULLET holds all pairs of round and flat shapes"
# cases = []
# ///
"""A cylinder of 0.1 m is laid on a box for three seconds: its centre stays at 0.1 m but for what it falls in the step before a contact is found."""

import dartpy
import numpy as np

G, DT, R = 9.81, 1 / 240, 0.1

world = dartpy.simulation.World("w")
world.setTimeStep(DT)
world.setGravity([0, 0, -G])
for name, shape, turn, z, mobile in (
    ("ground", dartpy.dynamics.BoxShape(np.array([1.0, 1.0, 0.2])), [0.0, 0.0, 0.0], -0.1, False),
    ("cylinder", dartpy.dynamics.CylinderShape(R, 0.3), [np.pi / 2, 0.0, 0.0], R, True),
):
    skeleton = dartpy.dynamics.Skeleton(name)
    joint, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 150))
    node = body.createShapeNode(shape)
    node.createCollisionAspect()
    node.createDynamicsAspect()
    pose = dartpy.math.Isometry3()
    pose.set_rotation(dartpy.math.expMapRot(np.array(turn)))
    pose.set_translation(np.array([0.0, 0.0, z]))
    joint.setTransform(pose)
    skeleton.setMobile(mobile)
    world.addSkeleton(skeleton)
for _ in range(720):
    world.step()
lost = R - float(body.getWorldTransform().translation()[2])
print(
    f"{'gone' if lost < G * DT**2 else 'still there'}: the cylinder has sunk by {1e3 * lost:.1f} mm in 3 s; its radius is {1e3 * R:g} mm"
)
