# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "getContactPoints(body) turns the normal of a contact round and leaves its friction, if the body is the second of the pair"
# seen = ["3.2.7"]
# documented = "getContactPoints: contactNormalOnB points towards A; lateralFriction1 is the friction in the direction lateralFrictionDir1. With bodyA given, A and B are exchanged where needed."
# sources = [
#   "PyBullet Quickstart Guide, getContactPoints",
#   "sdist of pybullet 3.2.7, examples/SharedMemory/PhysicsServerCommandProcessor.cpp: RequestFiltered, processRequestContactpointInformationCommand",
# ]
# mend = "ask for all contacts, getContactPoints(), and pick the body from the pair oneself"
# cases = []
# ///
"""A box of 1 kg is pulled along each of four directions by 3 N and stays: it gets 3 N of friction the other way, however one asks."""

import sys
import time

import pybullet as p

G, PULL = 9.81, 3.0


def friction(mended, pull):
    """The friction on the box [N, N], summed as the guide says, and the time of the readings [s]."""
    p.connect(p.DIRECT)
    p.setGravity(*pull, -G)
    slab = p.createCollisionShape(p.GEOM_BOX, halfExtents=[5, 5, 0.5])
    ground = p.createMultiBody(0.0, slab, basePosition=[0, 0, -0.5])
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.1, 0.1, 0.05])
    box = p.createMultiBody(1.0, shape, basePosition=[0, 0, 0.05])
    p.changeDynamics(ground, -1, lateralFriction=1.0)
    p.changeDynamics(box, -1, lateralFriction=0.5)
    for _ in range(100):
        p.stepSimulation()
    begun = time.process_time()
    for _ in range(100):
        points = p.getContactPoints() if mended else p.getContactPoints(box)
        total = [0.0, 0.0]
        for c in points:
            sign = 1 if c[1] == box else -1
            for k in (0, 1):
                total[k] += sign * (c[10] * c[11][k] + c[12] * c[13][k])
    took = time.process_time() - begun
    p.disconnect()
    return total, took


def measure(mended):
    """The friction against each pull [N], positive if it holds the box, and the time of the readings [s]."""
    against, took = [], 0.0
    for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        total, spent = friction(mended, (PULL * x, PULL * y))
        against.append(-(total[0] * x + total[1] * y))
        took += spent
    return against, took


MENDED = "--mended" in sys.argv
against, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a reading")
print(
    f"{'gone' if max(abs(value - PULL) for value in against) < 0.01 * PULL else 'stands' if MENDED else 'still there'}: "
    f"asked for the box, friction against the pull of {PULL:g} N is {', '.join(f'{value:+.2f}' for value in against)} N "
    "along x, -x, y and -y"
)
