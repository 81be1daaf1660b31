# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "bug"
# title = "RevoluteJointConstraint turns an error of its axis the wrong way: it grows"
# seen = ["6.20.0"]
# documented = "The constraint holds two axes together. Its correction has the sign that drives them apart: an angle grows by about a hundredth a step."
# sources = ["dartpy.constraint.RevoluteJointConstraint"]
# mend = "a BallJointConstraint at each of two points of the axis"
# cases = []
# ///
"""A body hinged to the world, alone in space, with its axis 0.01 rad off as it starts: whatever holds it turns that back."""

import dartpy
import numpy as np

OFF, STEPS = 0.01, 200

world = dartpy.simulation.World("w")
world.setTimeStep(1e-3)
world.setGravity([0, 0, 0])
skeleton = dartpy.dynamics.Skeleton("body")
joint, body = skeleton.createFreeJointAndBodyNodePair()
body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 10))
world.addSkeleton(skeleton)
axis = np.array([0.0, 0.0, 1.0])
held = dartpy.constraint.RevoluteJointConstraint(body, np.zeros(3), axis)
world.getConstraintSolver().addConstraint(held)
pose = dartpy.math.Isometry3()
pose.set_rotation(dartpy.math.expMapRot(np.array([OFF, 0.0, 0.0])))
joint.setTransform(pose)
for _ in range(STEPS):
    world.step()
now = float(np.arccos(np.clip(body.getWorldTransform().rotation()[:, 2] @ axis, -1.0, 1.0)))
print(f"{'gone' if now < OFF else 'still there'}: an axis {OFF:g} rad off is {now:.4f} rad off after {STEPS} steps")
