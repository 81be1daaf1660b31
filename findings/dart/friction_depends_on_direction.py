# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "trap"
# title = "By default friction is bounded along two axes apart: a push at 45 degrees stops 30 % early"
# seen = ["6.20.0"]
# documented = "The default solver is a boxed LCP (Dantzig), whose box bounds each direction of friction by itself; the conic solvers NSGS and FBF are offered beside it."
# sources = ["dartpy.constraint: DantzigBoxedLcpSolver, NsgsFrictionSolver, FbfFrictionSolver"]
# mend = "world.setCollisionDetector(CollisionDetectorType.DART) and world.getConstraintSolver().setBoxedLcpSolver(FbfFrictionSolver()); with other detectors NsgsFrictionSolver() is the cheaper one"
# cases = ["friction_isotropy", "friction_stop", "friction_threshold"]
# tracks = ["default"]
# cause = "friction as a box, not a cone"
# ///
"""Equal boxes pushed at 2 m/s, along an axis and at four angles, go equally far: v2/(2 mu g), but for a step's way or two (2 % each)."""

import math
import sys
import time

import dartpy
import numpy as np

G, DT, MU, SPEED = 9.81, 1 / 240, 0.5, 2.0
ANGLES = (0.0, 20.0, 45.0, 70.0, 90.0)


def measure(mended):
    """How far the boxes go [m], by angle, and the time of the steps [s]."""
    world = dartpy.simulation.World("w")
    world.setTimeStep(DT)
    world.setGravity([0, 0, -G])
    if mended:
        world.setCollisionDetector(dartpy.simulation.CollisionDetectorType.DART)
        world.getConstraintSolver().setBoxedLcpSolver(dartpy.constraint.FbfFrictionSolver())
    boxes = []
    flat = [0.2, 0.2, 0.05]
    for name, size, y, z, angle in (
        ("ground", [20.0, 20.0, 1.0], 0.0, -0.5, None),
        *((f"box {k}", flat, 2.0 * k, flat[2] / 2, math.radians(angle)) for k, angle in enumerate(ANGLES)),
    ):
        skeleton = dartpy.dynamics.Skeleton(name)
        joint, body = skeleton.createFreeJointAndBodyNodePair()
        x2, y2, z2 = np.square(size)
        body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.diag([y2 + z2, x2 + z2, x2 + y2]) / 12))
        node = body.createShapeNode(dartpy.dynamics.BoxShape(np.array(size)))
        node.createCollisionAspect()
        node.createDynamicsAspect()
        node.getDynamicsAspect().setFrictionCoeff(MU)
        pose = dartpy.math.Isometry3()
        pose.set_translation(np.array([0.0, y, z]))
        joint.setTransform(pose)
        if angle is None:
            skeleton.setMobile(False)
        else:
            joint.setLinearVelocity(SPEED * np.array([math.cos(angle), math.sin(angle), 0.0]))
            boxes.append((body, np.array([0.0, y, z])))
        world.addSkeleton(skeleton)
    begun = time.process_time()
    for _ in range(240):
        world.step()
    took = time.process_time() - begun
    return [float(np.linalg.norm((body.getWorldTransform().translation() - start)[:2])) for body, start in boxes], took


MENDED = "--mended" in sys.argv
distances, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if max(abs(distance / distances[0] - 1) for distance in distances) < 0.05 else 'stands' if MENDED else 'still there'}: "
    f"{', '.join(f'{distance:.3f}' for distance in distances)} m at {', '.join(f'{angle:g}' for angle in ANGLES)} degrees "
    f"({100 * (distances[2] / distances[0] - 1):+.0f} % at 45); {SPEED**2 / (2 * MU * G):.3f} m are due"
)
