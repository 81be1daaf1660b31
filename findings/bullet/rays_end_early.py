# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "limit"
# title = "A ray that grazes a round solid ends millimetres before it"
# seen = ["3.2.7"]
# documented = "rayTest: the hit fraction and position of the closest hit. The source finds convex solids by an iterative cast with a fixed tolerance (btSubSimplexConvexCast)."
# sources = [
#   "PyBullet Quickstart Guide, rayTest",
#   "https://github.com/bulletphysics/bullet3/blob/master/src/BulletCollision/NarrowPhaseCollision/btSubSimplexConvexCast.cpp",
# ]
# mend = "closed forms for balls, capsules and cylinders; faces of boxes and planes are exact"
# cases = ["sensor_lidar_noise", "sensor_lidar_room"]
# cause = "rays that end early at grazing incidence"
# ///
"""A beam meets a cylinder of 0.35 m at 3.7 degrees, 2.3 m away; the true distance is the root of a quadratic."""

import math

import pybullet as p

EYE = (0.28603831252173834, -0.15258089247044446, 1.2265263498580048)
BEAM = (0.6283473981475582, -0.7450768287435723, 0.22369637125044153)
WHERE, AXIS, ANGLE, RADIUS = (1.7, -1.6, 1.1), (0.2, 1.0, 0.1), 0.5, 0.35

p.connect(p.DIRECT)
norm = math.hypot(*AXIS)
turn = [*(a / norm * math.sin(ANGLE / 2) for a in AXIS), math.cos(ANGLE / 2)]
shape = p.createCollisionShape(p.GEOM_CYLINDER, radius=RADIUS, height=1.4)
p.createMultiBody(0.0, shape, basePosition=WHERE, baseOrientation=turn)
back, aside = p.invertTransform(WHERE, turn)[1], p.invertTransform(WHERE, turn)[0]
start = p.multiplyTransforms(aside, back, EYE, [0, 0, 0, 1])[0]
way = p.multiplyTransforms([0, 0, 0], back, BEAM, [0, 0, 0, 1])[0]
a, b, c = (way[0] ** 2 + way[1] ** 2, start[0] * way[0] + start[1] * way[1], start[0] ** 2 + start[1] ** 2 - RADIUS**2)
true = (-b - math.sqrt(b * b - a * c)) / a
errors = []
for length in (2.5, 3.0, 5.0, 10.0, 15.0, 20.0, 40.0):
    share = p.rayTest(EYE, [e + length * d for e, d in zip(EYE, BEAM)])[0][2]
    errors.append(true - length * share)
worst = max(errors, key=abs)
# Eight roundings in single precision of such a room, at this incidence, are 0.3 mm.
print(
    f"{'gone' if abs(worst) < 3.3e-4 else 'still there'}: the ray ends {1e3 * worst:.2f} mm before the cylinder at {true:.3f} m"
)
