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
"""A body hinged to the world, alone in space, with its axis 0.01 rad off as it starts, to either side and at two steps: whatever holds it turns that back."""

import sys
import time

import dartpy
import numpy as np

STEPS = 200


def hinged(mended, off, dt):
    """The axis' angle after the steps [rad], and the time of these [s]."""
    world = dartpy.simulation.World("w")
    world.setTimeStep(dt)
    world.setGravity([0, 0, 0])
    skeleton = dartpy.dynamics.Skeleton("body")
    joint, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 10))
    world.addSkeleton(skeleton)
    axis = np.array([0.0, 0.0, 1.0])
    if mended:
        held = [dartpy.constraint.BallJointConstraint(body, z * axis) for z in (-0.5, 0.5)]
    else:
        held = [dartpy.constraint.RevoluteJointConstraint(body, np.zeros(3), axis)]
    for constraint in held:
        world.getConstraintSolver().addConstraint(constraint)
    pose = dartpy.math.Isometry3()
    pose.set_rotation(dartpy.math.expMapRot(np.array([off, 0.0, 0.0])))
    joint.setTransform(pose)
    begun = time.process_time()
    for _ in range(STEPS):
        world.step()
    took = time.process_time() - begun
    return float(np.arccos(np.clip(body.getWorldTransform().rotation()[:, 2] @ axis, -1.0, 1.0))), took


def measure(mended):
    """The angles after the steps [rad], and the time of these [s]."""
    runs = [hinged(mended, off, dt) for off in (0.01, -0.01) for dt in (1e-3, 1 / 240)]
    return [angle for angle, _ in runs], sum(took for _, took in runs)


MENDED = "--mended" in sys.argv
angles, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if max(angles) < 0.01 else 'stands' if MENDED else 'still there'}: "
    f"axes 0.01 rad off are {', '.join(f'{angle:.4f}' for angle in angles)} rad off after {STEPS} steps"
)
