# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "getContactPoints(body) turns the normal of a contact round and leaves its friction"
# seen = ["3.2.7"]
# documented = "getContactPoints: contactNormalOnB points towards A; lateralFriction1 is the friction in the direction lateralFrictionDir1. With bodyA given, A and B are exchanged where needed."
# sources = ["PyBullet Quickstart Guide, getContactPoints"]
# mend = "ask for all contacts, getContactPoints(), and pick the body from the pair oneself"
# cases = []
# ///
"""A box of 1 kg is pulled along x by 3 N and stays: it gets -3 N of friction from the ground, however one asks."""

import pybullet as p

G = 9.81

p.connect(p.DIRECT)
p.setGravity(3.0, 0.0, -G)
ground = p.createMultiBody(0.0, p.createCollisionShape(p.GEOM_BOX, halfExtents=[5, 5, 0.5]), basePosition=[0, 0, -0.5])
box = p.createMultiBody(1.0, p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.1, 0.1, 0.05]), basePosition=[0, 0, 0.05])
p.changeDynamics(ground, -1, lateralFriction=1.0)
p.changeDynamics(box, -1, lateralFriction=0.5)
for _ in range(100):
    p.stepSimulation()


def on_first(points):
    """The first body, and normal force and friction [N] on it, summed as the guide says."""
    return points[0][1], sum(c[9] * c[7][2] for c in points), sum(c[10] * c[11][0] + c[12] * c[13][0] for c in points)


first, normal, friction = on_first(p.getContactPoints())
asked, normal_asked, friction_asked = on_first(p.getContactPoints(box))
turned = first != asked
consistent = (friction_asked * friction < 0) == turned and (normal_asked * normal < 0) == turned
print(
    f"{'gone' if consistent else 'still there'}: told of all contacts, body {first} gets {normal:+.2f} N upwards and {friction:+.2f} N along x; "
    f"asked for body {asked}, that gets {normal_asked:+.2f} N and {friction_asked:+.2f} N"
)
