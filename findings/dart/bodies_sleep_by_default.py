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
"""A box that rests on the ground for two seconds is borne by m g, and a contact says so; at 1 ms, DART's own step, and at 1/240 s, where it does not fall asleep."""

import sys
import time

import dartpy
import numpy as np

G = 9.81


def place(world, name, shape, z, mobile, turn=(0.0, 0.0, 0.0)):
    """A body of 1 kg with its centre at a height [m], turned by a rotation vector [rad]."""
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
    return joint, body


def measure(mended, dt=1e-3):
    """The contacts, their force [N], and the time of the steps [s]."""
    world = dartpy.simulation.World("w")
    world.setTimeStep(dt)
    world.setGravity([0, 0, -G])
    if mended:
        options = world.getDeactivationOptions()
        options.mEnabled = False
        world.setDeactivationOptions(options)
    place(world, "ground", dartpy.dynamics.BoxShape(np.array([2.0, 2.0, 1.0])), -0.5, False)
    place(world, "box", dartpy.dynamics.BoxShape(np.array([0.2, 0.2, 0.2])), 0.1, True)
    begun = time.process_time()
    for _ in range(round(2 / dt)):
        world.step()
    took = time.process_time() - begun
    contacts = world.getLastCollisionResult().getContacts()
    return len(contacts), sum(abs(float(contact.force[2])) for contact in contacts), took


MENDED = "--mended" in sys.argv
count, force, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if abs(force - G) < 0.01 * G else 'stands' if MENDED else 'still there'}: "
    f"{count} contacts with {force:.2f} N under a box at rest, {measure(MENDED, 1 / 240)[1]:.2f} N at 1/240 s; {G:g} N are due"
)
