# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "A convex hull rests a millimetre above what bears it"
# seen = ["3.2.7"]
# documented = "The manual: the collision margin in general expands a shape and leaves a small gap, which boxes make up for by their size. The Quickstart Guide: collisionMargin may or may not pad a shape, by its type. That a hull is padded, and by 1 mm where nothing is said, stands in the source alone."
# sources = ["Bullet 2.83 Physics SDK Manual, Collision Margin", "PyBullet Quickstart Guide, changeDynamics: collisionMargin", "bullet3, PhysicsServerCommandProcessor.cpp: m_defaultCollisionMargin(0.001)"]
# mend = "changeDynamics(body, -1, collisionMargin=0.0) once the body is made (the manual warns of zero in general; it has no effect on hulls of links and of compounds), or vertices a millimetre further in"
# cases = []
# tracks = ["default"]
# ///
"""A cube of 0.2 m, once as a box, once as the hull of its corners, comes to rest on a box.

A tenth of the margin tells a gap from how deep contacts let bodies in, which the box shows: 0.01 mm.
"""

import pybullet as p

HALF = 0.1

p.connect(p.DIRECT)
p.setGravity(0, 0, -9.81)
p.createMultiBody(0, p.createCollisionShape(p.GEOM_BOX, halfExtents=[1, 1, 0.1]), basePosition=[0, 0, -0.1])
corners = [[x, y, z] for x in (-HALF, HALF) for y in (-HALF, HALF) for z in (-HALF, HALF)]
hull, bare = (p.createCollisionShape(p.GEOM_MESH, vertices=corners) for _ in range(2))
box = p.createCollisionShape(p.GEOM_BOX, halfExtents=[HALF] * 3)
cubes = [
    p.createMultiBody(1.0, shape, basePosition=[0, 0.5 * k - 0.5, HALF + 0.002]) for k, shape in enumerate((box, hull, bare))
]
p.changeDynamics(cubes[2], -1, collisionMargin=0.0)
for _ in range(480):
    p.stepSimulation()
above = [1e3 * (p.getBasePositionAndOrientation(cube)[0][2] - HALF) for cube in cubes]
figure = f"after 2 s the hull is {above[1]:.2f} mm above the box that bears it, with collisionMargin=0 {above[2]:.2f} mm, a box {above[0]:.2f} mm"
print(f"{'gone' if abs(above[1]) < 0.1 else 'still there'}: {figure}")
