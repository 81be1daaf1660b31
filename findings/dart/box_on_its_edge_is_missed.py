# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "bug"
# title = "A box on its edge falls through a box under the ODE collision detector, if their edges are parallel"
# seen = ["6.20.0"]
# documented = "The detector supports boxes. ODE holds two boxes for apart where they are so along the cross product of two edges, also where that product is what rounding leaves of parallel ones."
# sources = [
#   "Open Dynamics Engine, ode/src/box.cpp: dBoxBox, which returns for |expr1| - expr2 > 0 before it looks at the length of the axis",
#   "https://github.com/bepu/bepuphysics1/issues/13",
# ]
# mend = "CollisionDetectorType.BULLET, FCL or DART; or turn each box's shape by an angle of its own of 1e-12 rad"
# cases = []
# ///
"""A cube on its edge, parallel to an edge of the box below it, is let go in two hundred directions of that edge: after a tenth
of a second it stands on the edge, and has not fallen half as far as it would without the box. Along the axes of the world the
cross product is exactly nought, and nothing is missed.
"""

import sys
import time

import dartpy
import numpy as np

G, DT, STEPS, HALF = 9.81, 1 / 240, 24, 0.1
KINDS = dartpy.simulation.CollisionDetectorType
YAWS = np.random.default_rng(0).uniform(0.0, 2 * np.pi, 200)


def place(world, name, half, pose, mobile):
    """A box of 1 kg of these half extents [m] at a pose."""
    skeleton = dartpy.dynamics.Skeleton(name)
    joint, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 150))
    node = body.createShapeNode(dartpy.dynamics.BoxShape(2 * np.array(half)))
    node.createCollisionAspect()
    node.createDynamicsAspect()
    joint.setTransform(pose)
    skeleton.setMobile(mobile)
    world.addSkeleton(skeleton)
    return body


def turned(yaw, tilt, z):
    """The pose at a height [m], tilted about y and then turned about z [rad]."""
    pose = dartpy.math.Isometry3()
    about_z, about_y = (dartpy.math.expMapRot(np.array(v)) for v in ((0.0, 0.0, yaw), (0.0, tilt, 0.0)))
    pose.set_rotation(about_z @ about_y)
    pose.set_translation(np.array([0.0, 0.0, z]))
    return pose


def measure(detector):
    """In how many of the directions the cube fell through, and the time of the steps [s]."""
    missed, took = 0, 0.0
    for yaw in YAWS:
        world = dartpy.simulation.World("w")
        world.setTimeStep(DT)
        world.setGravity([0, 0, -G])
        world.setCollisionDetector(detector)
        place(world, "ground", (1.0, 1.0, 0.1), turned(yaw, 0.0, -0.1), False)
        high = np.sqrt(2) * HALF
        cube = place(world, "cube", (HALF, HALF, HALF), turned(yaw, np.pi / 4, high - 1e-6), True)
        begun = time.process_time()
        for _ in range(STEPS):
            world.step()
        took += time.process_time() - begun
        fallen = high - float(cube.getWorldTransform().translation()[2])
        missed += fallen > G * (STEPS * DT) ** 2 / 4
    return missed, took


MENDED = "--mended" in sys.argv
missed, _ = measure(KINDS.BULLET if MENDED else KINDS.ODE)
if MENDED:
    plain, mended = (min(measure(kind)[-1] for _ in range(3)) for kind in (KINDS.ODE, KINDS.BULLET))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if missed == 0 else 'stands' if MENDED else 'still there'}: "
    f"the cube fell through in {missed} of {len(YAWS)} directions, under the DART detector in {measure(KINDS.DART)[0]}, "
    f"under FCL in {measure(KINDS.FCL)[0]}"
)
