"""May something slide? Where friction bears nothing, how it is bounded does not matter."""

import math
from collections.abc import Sequence

import numpy as np

from plumbline.harness.scene import Box, Capsule, Effect, Plane, Quaternion, Scene, Shape, Sphere, Vector3, multiply, rotate
from plumbline.harness.trajectory import Floats

SLOPE = 1e-6
"""The least cosine between a direction and gravity, and between it and the horizontal, that counts as a slope."""
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def may_slide(scene: Scene) -> bool:
    """Does friction act where something moves at the start, or where a face slopes?

    A ball that lies on level faces rolls and does not slide. Hulls and meshes, and round shapes that stand still, are taken to
    have faces that slope; so are cylinders, which maximal coordinates brake too much on a box whatever pushes them later: their
    points are found one a step.
    """
    if Effect.FRICTION not in scene.effects or Effect.CONTACT not in scene.effects:
        return False
    if any(any(body.v_WB) or any(body.w_WB) or body.motion == "kinematic" for body in scene.bodies):
        return True
    pull = np.asarray(scene.gravity if Effect.GRAVITY in scene.effects else (0.0, 0.0, 0.0))
    down = pull / max(float(np.linalg.norm(pull)), 1e-300)
    return any(
        _slopes(_directions(placed.shape, body.movable), multiply(body.q_WB, placed.q_BS), down)
        for body in scene.bodies
        for placed in body.collision
    )


def _directions(shape: Shape, movable: bool) -> Sequence[Vector3] | None:
    """The directions in S that have to be level or upright for the shape to stand or lie flat; None: it has others."""
    match shape:
        case Plane():
            return (shape.normal,)
        case Box():
            return AXES
        case Capsule() if movable:
            return AXES[2:]
        case Sphere() if movable:
            return ()
        case _:
            return None


def _slopes(directions: Sequence[Vector3] | None, q_WS: Quaternion, down: Floats) -> bool:
    """Is one of these directions, or of those that are not told, neither along gravity nor across it?"""
    if directions is None:
        return True
    along = (abs(float(down @ rotate(q_WS, direction))) for direction in directions)
    return any(SLOPE < cosine < math.sqrt(1 - SLOPE**2) for cosine in along)
