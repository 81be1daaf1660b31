# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "contactBreakingThreshold of one client is that of every client of the process"
# seen = ["3.2.7"]
# documented = "setPhysicsEngineParameter takes a physicsClientId, and clients are separate simulations. The source keeps this one in a global variable, gContactBreakingThreshold."
# sources = [
#   "PyBullet Quickstart Guide, setPhysicsEngineParameter: contactBreakingThreshold, physicsClientId",
#   "https://github.com/bulletphysics/bullet3/blob/master/src/BulletCollision/NarrowPhaseCollision/btPersistentManifold.cpp",
# ]
# mend = "one process a simulation, or the same threshold in all"
# cases = []
# ///
"""A cube slides down an incline in a world of its own, before and after another client is told another threshold."""

import math

import pybullet as p

G, SLOPE = 9.81, 0.5


def way():
    """How far the cube gets in a second [m], in a new client with nothing set but gravity and friction."""
    client = p.connect(p.DIRECT)
    p.setGravity(G * math.sin(SLOPE), 0.0, -G * math.cos(SLOPE), physicsClientId=client)
    plane = p.createMultiBody(0.0, p.createCollisionShape(p.GEOM_PLANE, physicsClientId=client), physicsClientId=client)
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.1] * 3, physicsClientId=client)
    cube = p.createMultiBody(1.0, shape, basePosition=[0, 0, 0.1], physicsClientId=client)
    p.changeDynamics(plane, -1, lateralFriction=0.5, physicsClientId=client)
    p.changeDynamics(cube, -1, lateralFriction=1.0, physicsClientId=client)
    for _ in range(240):
        p.stepSimulation(physicsClientId=client)
    end = p.getBasePositionAndOrientation(cube, physicsClientId=client)[0][0]
    p.disconnect(physicsClientId=client)
    return end


other = p.connect(p.DIRECT)
before = way()
p.setPhysicsEngineParameter(contactBreakingThreshold=0.001, physicsClientId=other)
after = way()
print(
    f"{'gone' if before == after else 'still there'}: the cube goes {before:.6f} m, and {after:.6f} m once another client has its threshold set"
)
