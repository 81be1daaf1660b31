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
# mend = "world.getConstraintSolver().setBoxedLcpSolver(dartpy.constraint.NsgsFrictionSolver()), which costs several times as much"
# cases = ["friction_isotropy", "friction_stop", "friction_threshold"]
# tracks = ["default"]
# cause = "friction as a box, not a cone"
# ///
"""Two equal boxes pushed at 2 m/s, along an axis and at 45 degrees, go equally far: v2/(2 mu g), but for a step's way or two (2 % each)."""

import math

import dartpy
import numpy as np

G, DT, MU, SPEED = 9.81, 1 / 240, 0.5, 2.0

world = dartpy.simulation.World("w")
world.setTimeStep(DT)
world.setGravity([0, 0, -G])
world.setCollisionDetector(dartpy.simulation.CollisionDetectorType.ODE)
boxes = []
for name, size, y, z, angle in (
    ("ground", [20.0, 20.0, 1.0], 0.0, -0.5, None),
    ("a", [0.2, 0.2, 0.05], 0.0, 0.025, 0.0),
    ("b", [0.2, 0.2, 0.05], 2.0, 0.025, 45.0),
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
        a = math.radians(angle)
        joint.setLinearVelocity(SPEED * np.array([math.cos(a), math.sin(a), 0.0]))
        boxes.append((body, np.array([0.0, y, z])))
    world.addSkeleton(skeleton)
for _ in range(240):
    world.step()
straight, askew = (float(np.linalg.norm((body.getWorldTransform().translation() - start)[:2])) for body, start in boxes)
print(
    f"{'gone' if abs(askew / straight - 1) < 0.05 else 'still there'}: {straight:.3f} m along an axis, {askew:.3f} m at 45 degrees "
    f"({100 * (askew / straight - 1):+.0f} %); {SPEED**2 / (2 * MU * G):.3f} m are due"
)
