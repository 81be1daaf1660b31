# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "limit"
# title = "A capsule at rest on a flat box rolls off, in some directions of its axis"
# seen = ["3.2.7"]
# documented = "Nothing is said of it. changeDynamics offers rollingFriction, and says to leave it near 0."
# sources = ["PyBullet Quickstart Guide, changeDynamics: rollingFriction"]
# mend = "changeDynamics(body, -1, rollingFriction=0.001) on both bodies"
# cases = []
# ///
"""A capsule of 0.1 m is laid on a box for ten seconds and nothing pushes it. Four directions, both coordinates; a millimetre is granted. Finer steps do not hold it."""

import math
import sys
import time

import pybullet as p

G, R = 9.81, 0.1
YAWS = (0.0, 0.3, 1.0, 2.5)


def rolled(mended, yaw, maximal=False, dt=1 / 240):
    """How far [mm] the capsule has come in 10 s, and the time of the steps [s]."""
    p.connect(p.DIRECT)
    p.setGravity(0, 0, -G)
    p.setPhysicsEngineParameter(fixedTimeStep=dt)
    slab = p.createCollisionShape(p.GEOM_BOX, halfExtents=[5, 5, 0.5])
    ground = p.createMultiBody(0, slab, basePosition=[0, 0, -0.5], useMaximalCoordinates=maximal)
    laid = p.getQuaternionFromEuler([0, math.pi / 2, yaw])
    shape = p.createCollisionShape(p.GEOM_CAPSULE, radius=R, height=0.4)
    capsule = p.createMultiBody(1.0, shape, basePosition=[0, 0, R], baseOrientation=laid, useMaximalCoordinates=maximal)
    for body in (ground, capsule) if mended else ():
        p.changeDynamics(body, -1, rollingFriction=0.001)
    begun = time.process_time()
    for _ in range(round(10 / dt)):
        p.stepSimulation()
    took = time.process_time() - begun
    x, y, _ = p.getBasePositionAndOrientation(capsule)[0]
    p.disconnect()
    return 1e3 * math.hypot(x, y), took


def measure(mended):
    """The ways of the capsules [mm], by their directions, and the time of the steps [s]."""
    runs = [rolled(mended, yaw) for yaw in YAWS]
    return [distance for distance, _ in runs], sum(took for _, took in runs)


MENDED = "--mended" in sys.argv
distances, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if max(distances) < 1 else 'stands' if MENDED else 'still there'}: "
    f"{', '.join(f'{distance:.1f}' for distance in distances)} mm in 10 s, by directions; in maximal coordinates up to "
    f"{max(rolled(MENDED, yaw, True)[0] for yaw in YAWS):.1f} mm, at 1/960 s {max(rolled(MENDED, yaw, dt=1 / 960)[0] for yaw in YAWS):.1f} mm"
)
