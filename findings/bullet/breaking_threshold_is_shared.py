# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "contactBreakingThreshold of one client is that of the other clients of the process too"
# seen = ["3.2.7"]
# documented = "setPhysicsEngineParameter takes a physicsClientId, and clients are separate simulations. The source stores this one in a global variable, gContactBreakingThreshold."
# sources = [
#   "PyBullet Quickstart Guide, setPhysicsEngineParameter: contactBreakingThreshold, physicsClientId",
#   "sdist of pybullet 3.2.7, src/BulletCollision/NarrowPhaseCollision/btPersistentManifold.cpp: gContactBreakingThreshold; examples/SharedMemory/PhysicsServerCommandProcessor.cpp: processSendPhysicsParametersCommand",
# ]
# mend = "one process a simulation, or setPhysicsEngineParameter(contactBreakingThreshold=...) again before each step of each client"
# cases = []
# ///
"""A cube slides down an incline in a world of its own, equally far whether or not another client is told another threshold."""

import math
import sys
import time

import pybullet as p

G, SLOPE, THRESHOLD = 9.81, 0.5, 0.02


def slide(mended):
    """How far the cube gets in a second [m], in a new client with nothing set but gravity and friction; the time of its steps [s]."""
    client = p.connect(p.DIRECT)
    p.setGravity(G * math.sin(SLOPE), 0.0, -G * math.cos(SLOPE), physicsClientId=client)
    plane = p.createMultiBody(0.0, p.createCollisionShape(p.GEOM_PLANE, physicsClientId=client), physicsClientId=client)
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.1] * 3, physicsClientId=client)
    cube = p.createMultiBody(1.0, shape, basePosition=[0, 0, 0.1], physicsClientId=client)
    p.changeDynamics(plane, -1, lateralFriction=0.5, physicsClientId=client)
    p.changeDynamics(cube, -1, lateralFriction=1.0, physicsClientId=client)
    begun = time.process_time()
    for _ in range(240):
        if mended:
            p.setPhysicsEngineParameter(contactBreakingThreshold=THRESHOLD, physicsClientId=client)
        p.stepSimulation(physicsClientId=client)
    took = time.process_time() - begun
    end = p.getBasePositionAndOrientation(cube, physicsClientId=client)[0][0]
    p.disconnect(physicsClientId=client)
    return end, took


def measure(mended):
    """The cube's way before and after [m], and the time of its steps [s]."""
    other = p.connect(p.DIRECT)
    p.setPhysicsEngineParameter(contactBreakingThreshold=THRESHOLD, physicsClientId=other)
    before, first = slide(mended)
    p.setPhysicsEngineParameter(contactBreakingThreshold=0.001, physicsClientId=other)
    after, second = slide(mended)
    p.disconnect(physicsClientId=other)
    return before, after, first + second


MENDED = "--mended" in sys.argv
before, after, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if before == after else 'stands' if MENDED else 'still there'}: "
    f"the cube goes {before:.6f} m, and {after:.6f} m once another client has its threshold set"
)
