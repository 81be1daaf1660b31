# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "limit"
# title = "A damped joint spring beside a contact comes to rest off its equilibrium, by an angle in proportion to the step"
# seen = ["6.20.0"]
# documented = "setSpringStiffness, setRestPosition and setDampingCoefficient make a linear spring and damper. Nothing says that contacts change where it rests."
# sources = ["dartpy.dynamics.RevoluteJoint: setSpringStiffness, setRestPosition, setDampingCoefficient"]
# mend = "the same law as a torque by setForce in each step, at a step that it is stable at; or a finer step"
# cases = ["stand_quadruped", "stand_humanoid"]
# cause = "springs that sag beside a contact"
# ///
"""A slider stands on a box and carries, on a hinge, a bar that its spring holds level: statics leaves it level, whatever the step; a milliradian is granted."""

import sys
import time

import dartpy
import numpy as np

G, R, STIFFNESS, LEVER, GRANTED = 9.81, 0.1, 200.0, 0.3, 1e-3


def rest(mended, dt=1 / 240, damping=20.0, contact=True):
    """The bar's angle after a second [rad], and the time of its steps [s]."""
    world = dartpy.simulation.World("w")
    world.setTimeStep(dt)
    world.setGravity([0, 0, -G])
    world.setCollisionDetector(dartpy.simulation.CollisionDetectorType.ODE)
    ground = dartpy.dynamics.Skeleton("ground")
    joint, body = ground.createWeldJointAndBodyNodePair()
    pose = dartpy.math.Isometry3()
    pose.set_translation(np.array([0.0, 0.0, -0.1]))
    joint.setTransformFromParentBodyNode(pose)
    machine = dartpy.dynamics.Skeleton("machine")
    if contact:
        slider, foot = machine.createPrismaticJointAndBodyNodePair()
        slider.setAxis(np.array([0.0, 0.0, 1.0]))
        slider.setPosition(0, R - 1e-6)
    else:
        _, foot = machine.createWeldJointAndBodyNodePair()
    foot.setInertia(dartpy.dynamics.Inertia(2.0, np.zeros(3), np.eye(3) / 10))
    for owner, size in ((body, [1.0, 1.0, 0.2]), (foot, [2 * R] * 3)) if contact else ():
        node = owner.createShapeNode(dartpy.dynamics.BoxShape(np.array(size)))
        node.createCollisionAspect()
        node.createDynamicsAspect()
    hinge, bar = machine.createRevoluteJointAndBodyNodePair(foot)
    hinge.setAxis(np.array([0.0, 1.0, 0.0]))
    bar.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 10))
    aside = dartpy.math.Isometry3()
    aside.set_translation(np.array([-LEVER, 0.0, 0.0]))
    hinge.setTransformFromChildBodyNode(aside)
    centre = -1.0 * G * LEVER / STIFFNESS
    if not mended:
        hinge.setSpringStiffness(0, STIFFNESS)
        hinge.setRestPosition(0, centre)
        hinge.setDampingCoefficient(0, damping)
    ground.setMobile(False)
    world.addSkeleton(ground)
    world.addSkeleton(machine)
    begun = time.process_time()
    for _ in range(round(1 / dt)):
        if mended:
            hinge.setForce(0, -STIFFNESS * (hinge.getPosition(0) - centre) - damping * hinge.getVelocity(0))
        world.step()
    return abs(float(hinge.getPosition(0))), time.process_time() - begun


def measure(mended):
    """The bar's angle at 1/240 s [rad], and the time of its steps [s]."""
    return rest(mended)


MENDED = "--mended" in sys.argv
sag, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if sag < GRANTED else 'stands' if MENDED else 'still there'}: "
    f"the bar rests {sag:.1e} rad off at 1/240 s, {rest(MENDED, 1 / 960)[0]:.1e} at 1/960 s, {rest(MENDED, damping=0.0)[0]:.1e} undamped, "
    f"{rest(MENDED, contact=False)[0]:.1e} without a contact; it belongs level"
)
