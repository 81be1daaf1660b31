# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "trap"
# title = "Bodies fall asleep by default, and one that sleeps reports neither contacts nor forces"
# seen = ["6.20.0"]
# documented = "Deactivation is on by default (DeactivationOptions.mEnabled). That contacts are no longer told is not said."
# sources = ["dartpy.simulation.World: getDeactivationOptions, setDeactivationOptions"]
# mend = "options = world.getDeactivationOptions(); options.mEnabled = False; world.setDeactivationOptions(options)"
# cases = []
# ///
"""A box that rests on the ground for two seconds is borne by m g, and a contact says so."""

import dartpy
import numpy as np

world = dartpy.simulation.World("w")
world.setTimeStep(1e-3)
world.setGravity([0, 0, -9.81])
for name, size, z, mobile in (("ground", [2.0, 2.0, 1.0], -0.5, False), ("box", [0.2, 0.2, 0.2], 0.1, True)):
    skeleton = dartpy.dynamics.Skeleton(name)
    joint, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 150))
    node = body.createShapeNode(dartpy.dynamics.BoxShape(np.array(size)))
    node.createCollisionAspect()
    node.createDynamicsAspect()
    pose = dartpy.math.Isometry3()
    pose.set_translation(np.array([0.0, 0.0, z]))
    joint.setTransform(pose)
    skeleton.setMobile(mobile)
    world.addSkeleton(skeleton)
for _ in range(2000):
    world.step()
contacts = world.getLastCollisionResult().getContacts()
force = sum(abs(float(contact.force[2])) for contact in contacts)
print(
    f"{'gone' if abs(force - 9.81) < 0.1 else 'still there'}: {len(contacts)} contacts with {force:.2f} N under a box at rest; 9.81 N are due"
)
