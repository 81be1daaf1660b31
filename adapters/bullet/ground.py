"""The ground: on a static plane round bodies stand as it is, and bodies with faces on a box below it."""

import math
from collections.abc import Iterator

from plumbline.adapters.bullet.frames import plus
from plumbline.adapters.bullet.plan import Plan
from plumbline.adapters.bullet.shapes import Placed
from plumbline.harness.scene import Body, Box, ConvexHull, Plane, Scene, TriangleMesh, Vector3, multiply, outer_radius, rotate

REACH = 1000.0
"""How far [m] the box that stands for a plane goes on to the sides and down beyond all that moves at the start."""


def faced(body: Body) -> bool:
    """Has the body faces? Bullet finds them on a box at up to four points at once, and on a plane at one more point a step.

    What is round touches a plane at points of a closed form, and a box at iterated ones; a mesh of triangles falls through a
    plane.
    """
    return any(isinstance(placed.shape, Box | ConvexHull | TriangleMesh) for placed in body.collision)


def static_parts(plan: Plan, place: int) -> Iterator[tuple[list[Placed], bool | None]]:
    """The shapes of a static body, apart by what may meet them: what has faces (True), what has none (False), both (None)."""
    shapes = plan.placed(place, (0.0, 0.0, 0.0))
    planes = [each for each in shapes if isinstance(each[0], Plane)]
    if len(planes) < len(shapes):
        yield [each for each in shapes if each not in planes], None
    solids = {faced(body) for body in plan.scene.bodies if body.movable and body.collision}
    if planes and True in solids:
        half = _half_edge(plan.scene, plan.scene.bodies[place].p_WB)
        yield [_box_below(each, half) for each in planes], True
    if planes and solids != {True}:
        yield planes, False


def _half_edge(scene: Scene, p_WB: Vector3) -> float:
    """Half the edge [m] of a box about the ground's place that ends REACH beyond all that moves."""
    moving = [body for body in scene.bodies if body.movable]
    return REACH + max(
        math.dist(p_WB, body.p_WB) + math.hypot(*placed.p_BS) + outer_radius(placed.shape)
        for body in moving
        for placed in body.collision
    )


def _box_below(plane: Placed, half: float) -> Placed:
    """A cube of that half edge whose upper face lies in the plane."""
    shape, p, q = plane
    assert isinstance(shape, Plane)
    x, y, z = shape.normal
    # The shortest turn from z to the normal; half a turn about x where they are opposite.
    turn = (1.0 + z, -y, x, 0.0) if z > -1.0 else (0.0, 1.0, 0.0, 0.0)
    w, i, j, k = (part / math.hypot(*turn) for part in turn)
    centre = rotate(q, (-half * x, -half * y, -half * z))
    return Box(half_extents=(half, half, half)), plus(p, centre), multiply(q, (w, i, j, k))
