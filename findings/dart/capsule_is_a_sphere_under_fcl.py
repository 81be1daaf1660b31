# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "trap"
# title = "FCL, the default collision detector, takes a capsule for a sphere of 0.1 m"
# seen = ["6.20.0"]
# documented = "A line on the console says that the shape is not supported and that a sphere is used instead; nothing that a program could ask says so. FCL's meshes (FCLCollisionDetector.MESH) do it too."
# sources = [
#   "DART 6.20.0, dart/collision/fcl/FCLCollisionDetector.cpp: FCLCollisionDetector::createFCLCollisionGeometry, named by the console",
# ]
# mend = "CollisionDetectorType.BULLET, or ODE for capsules that stand on end"
# cases = []
# ///
"""Capsules of two radii stand upright on a box for a tenth of a second, too short to tip over: their centres belong where they started."""

import sys
import time

import dartpy
import numpy as np

G, DT, LENGTH, T = 9.81, 1 / 240, 0.3, 0.1
RADII = (0.05, 0.02)


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


def measure(mended):
    """How far the capsules have sunk [m], and the time of the steps [s]."""
    sunk, took = [], 0.0
    for radius in RADII:
        world = dartpy.simulation.World("w")
        world.setTimeStep(DT)
        world.setGravity([0, 0, -G])
        if mended:
            world.setCollisionDetector(dartpy.simulation.CollisionDetectorType.BULLET)
        due = LENGTH / 2 + radius
        place(world, "ground", dartpy.dynamics.BoxShape(np.array([1.0, 1.0, 0.2])), -0.1, False)
        _, body = place(world, "capsule", dartpy.dynamics.CapsuleShape(radius, LENGTH), due, True)
        begun = time.process_time()
        for _ in range(round(T / DT)):
            world.step()
        took += time.process_time() - begun
        sunk.append(due - float(body.getWorldTransform().translation()[2]))
    return sunk, took


MENDED = "--mended" in sys.argv
sunk, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
# Before a contact is found a body falls for one step.
print(
    f"{'gone' if max(map(abs, sunk)) < G * DT**2 else 'stands' if MENDED else 'still there'}: "
    f"after {T:g} s capsules of radius {RADII[0]:g} and {RADII[1]:g} m have sunk by {', '.join(f'{1e3 * s:.2f}' for s in sunk)} mm, "
    f"in free fall it would be {1e3 * G * T**2 / 2:.1f} mm; a step's fall is {1e3 * G * DT**2:.2f} mm"
)
