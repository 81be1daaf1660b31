# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "limit"
# title = "A bounce gives 100 m/s at most"
# seen = ["6.20.0"]
# documented = "Restitution is a coefficient of the dynamics aspect. The source bounds the speed that a bounce gives by DART_MAX_BOUNCING_VELOCITY, 1e2; dartpy offers nothing to change it."
# sources = [
#   "DART, dart/constraint/ContactConstraint.cpp: ContactConstraint::getInformation, DART_MAX_BOUNCING_VELOCITY (ContactSurface.hpp in later versions); the version that runs was not read",
# ]
# mend = "a unit of length in which the speed is below 100, such as 10 m: lengths and speeds a tenth"
# cases = []
# ///
"""A ball meets a wall at 50, 150 and 300 m/s, with e 1 and e 0.5, under three detectors, and parts at e times that; 1 % is granted."""

import sys
import time

import dartpy
import numpy as np

SPEEDS, E = (50.0, 150.0, 300.0), (1.0, 0.5)
KINDS = dartpy.simulation.CollisionDetectorType


def parted(speed, e, unit, kind):
    """The speed [m/s] after the blow, simulated in units of length of so many metres, and the time of the steps [s]."""
    dt, radius = 1e-4, 0.1 / unit
    world = dartpy.simulation.World("w")
    world.setTimeStep(dt)
    world.setGravity([0, 0, 0])
    world.setCollisionDetector(kind)
    wall = dartpy.dynamics.BoxShape(np.array([50.0, 50.0, 2.0]) / unit)
    for name, shape, z in (
        ("wall", wall, -1.0 / unit),
        ("ball", dartpy.dynamics.SphereShape(radius), radius + 10.3 * speed / unit * dt),
    ):
        skeleton = dartpy.dynamics.Skeleton(name)
        joint, body = skeleton.createFreeJointAndBodyNodePair()
        body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), 0.4 * radius**2 * np.eye(3)))
        node = body.createShapeNode(shape)
        node.createCollisionAspect()
        node.createDynamicsAspect()
        node.getDynamicsAspect().setRestitutionCoeff(1.0 if name == "wall" else e)
        pose = dartpy.math.Isometry3()
        pose.set_translation(np.array([0.0, 0.0, z]))
        joint.setTransform(pose)
        skeleton.setMobile(name == "ball")
        world.addSkeleton(skeleton)
    joint.setLinearVelocity(np.array([0.0, 0.0, -speed / unit]))
    begun = time.process_time()
    for _ in range(100):
        world.step()
    return unit * float(body.getLinearVelocity()[2]), time.process_time() - begun


def measure(mended):
    """The speeds after the blows [m/s], the largest error of them [1], and the time of the steps [s]."""
    runs = {
        (speed, e, kind): parted(speed, e, 10.0 if mended else 1.0, kind)
        for kind in (KINDS.FCL, KINDS.DART, KINDS.BULLET)
        for e in E
        for speed in SPEEDS
    }
    worst = max(abs(left / (speed * e) - 1) for (speed, e, _), (left, _) in runs.items())
    return [left for left, _ in runs.values()][:6], worst, sum(took for _, took in runs.values())


MENDED = "--mended" in sys.argv
left, worst, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if worst < 0.01 else 'stands' if MENDED else 'still there'}: "
    f"blows at 50, 150 and 300 m/s give {', '.join(f'{v:.1f}' for v in left[:3])} m/s with e 1 and {', '.join(f'{v:.1f}' for v in left[3:])} m/s with e 0.5; "
    f"the largest error under three detectors is {100 * worst:.1f} %"
)
