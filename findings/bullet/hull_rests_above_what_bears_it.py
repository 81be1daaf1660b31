# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "By default a convex hull rests a millimetre above what bears it"
# seen = ["3.2.7"]
# documented = "The manual: the collision margin in general expands a shape and leaves a small gap, which boxes make up for by their size. The Quickstart Guide: collisionMargin may or may not pad a shape, by its type. That a hull is padded, and by 1 mm where nothing is said, stands in the source alone."
# sources = [
#   "Bullet 2.83 Physics SDK Manual, Collision Margin",
#   "PyBullet Quickstart Guide, changeDynamics: collisionMargin",
#   "sdist of pybullet 3.2.7, examples/SharedMemory/PhysicsServerCommandProcessor.cpp: m_defaultCollisionMargin(0.001)",
# ]
# mend = "changeDynamics(body, -1, collisionMargin=0.0) once the body is made (the manual warns of zero in general; it has no effect on hulls of links and of compounds), or vertices a millimetre further in"
# cases = []
# tracks = ["default"]
# ///
"""Cubes as hulls of their corners come to rest on a box: three sizes, both coordinates: their centres belong half an edge above it. A tenth of the margin tells a gap from how deep contacts let bodies in: 0.1 mm."""

import sys
import time

import pybullet as p

SIZES = (0.03, 0.1, 0.3)


def measure(mended):
    """The gaps below the hulls [mm], by coordinates and sizes, and the time of the steps [s]."""
    gaps, took = [], 0.0
    for maximal in (False, True):
        p.connect(p.DIRECT)
        p.setGravity(0, 0, -9.81)
        slab = p.createCollisionShape(p.GEOM_BOX, halfExtents=[3, 3, 0.1])
        p.createMultiBody(0, slab, basePosition=[0, 0, -0.1], useMaximalCoordinates=maximal)
        hulls = []
        for k, half in enumerate(SIZES):
            corners = [[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)]
            shape = p.createCollisionShape(p.GEOM_MESH, vertices=corners)
            hulls.append(p.createMultiBody(1.0, shape, basePosition=[0, k - 1.0, half + 0.002], useMaximalCoordinates=maximal))
            if mended:
                p.changeDynamics(hulls[-1], -1, collisionMargin=0.0)
        begun = time.process_time()
        for _ in range(480):
            p.stepSimulation()
        took += time.process_time() - begun
        gaps += [1e3 * (p.getBasePositionAndOrientation(hull)[0][2] - half) for hull, half in zip(hulls, SIZES)]
        p.disconnect()
    return gaps, took


MENDED = "--mended" in sys.argv
gaps, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if max(map(abs, gaps)) < 0.1 else 'stands' if MENDED else 'still there'}: "
    f"after 2 s hulls of {', '.join(f'{2 * half:g}' for half in SIZES)} m are {min(gaps):.2f} to {max(gaps):.2f} mm above the box that bears them"
)
