"""Is friction right in multibody coordinates for what has faces? There it depends on the way, by Bullet's two directions."""

import math
from collections.abc import Iterator

import numpy as np

from plumbline.harness.scene import Body, Box, Effect, Plane, Scene, multiply, rotate
from plumbline.harness.trajectory import Floats

ALIGNED = 1e-6
"""The greatest sine of an angle between two directions that count as one."""
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def goes_straight(scene: Scene, body: Body) -> bool:
    """Does the body, which has faces, slide along one of Bullet's two directions of friction, or are both alike to it?

    In multibody coordinates the forces along the two are found one after the other, and then scaled back to mu N: of two boxes
    askew to the directions, all points together bear less than mu N, and off the way (by 7 % and 20 degrees, turned by 45).
    Both are alike to a box whose sides are of one length and lie along them, with its moments of inertia alike.
    """
    if any(body.w_WB):
        return False
    pull = np.asarray(scene.gravity if Effect.GRAVITY in scene.effects else (0.0, 0.0, 0.0))
    belts = [np.subtract(body.v_WB, other.v_WB) for other in scene.bodies if other.motion == "kinematic"]
    if any(any(other.w_WB) for other in scene.bodies if other.motion == "kinematic"):
        return False
    drives = [way for way in (pull, np.asarray(body.v_WB), *belts) if way.any()]
    return all(
        _along(drive - (drive @ normal) * normal, float(np.linalg.norm(drive)), normal) or _square(body, normal)
        for normal in _normals(scene, pull)
        for drive in drives
    )


def _normals(scene: Scene, pull: Floats) -> Iterator[Floats]:
    """Unit normals in W of the planes that stand still or are driven, and of such boxes' faces that gravity presses on most."""
    for body in scene.bodies:
        for placed in body.collision if not body.movable else ():
            q_WS, shape = multiply(body.q_WB, placed.q_BS), placed.shape
            axes = (shape.normal,) if isinstance(shape, Plane) else AXES if isinstance(shape, Box) else ()
            normals = [np.asarray(rotate(q_WS, axis)) for axis in axes]
            if normals:
                yield max(normals, key=lambda normal: abs(float(pull @ normal)))


def _directions(normal: Floats) -> tuple[Floats, Floats]:
    """Bullet's directions of friction at a normal (btPlaneSpace1 of btVector3.h)."""
    x, y, z = normal
    across = np.array([0.0, -z, y]) if abs(z) > math.sqrt(0.5) else np.array([-y, x, 0.0])
    across /= np.linalg.norm(across)
    return across, np.cross(normal, across)


def _along(way: Floats, size: float, normal: Floats) -> bool:
    """Is a way in the face, a part of a vector of that size, along one of the directions, or none at all?"""
    return min(abs(float(way @ direction)) for direction in _directions(normal)) <= ALIGNED * size


def _square(body: Body, normal: Floats) -> bool:
    """Does the body stand on a face with this normal by square boxes whose sides lie along the directions of friction?"""
    turn = np.array([rotate(body.q_WB, axis) for axis in AXES]).T
    directions = np.array(_directions(normal)) @ turn
    moments = directions @ np.asarray(body.inertia) @ directions.T
    if np.abs(moments - np.trace(moments) / 2 * np.eye(2)).max() > ALIGNED * np.trace(moments):
        return False
    for placed in body.collision:
        shape, q_WS = placed.shape, multiply(body.q_WB, placed.q_BS)
        if not isinstance(shape, Box):
            return False
        axes = [np.asarray(rotate(q_WS, axis)) for axis in AXES]
        sides = {
            half
            for axis, half in zip(axes, shape.half_extents, strict=True)
            if abs(float(axis @ normal)) <= ALIGNED and _along(axis, 1.0, normal)
        }
        if len(sides) != 1 or sum(abs(float(axis @ normal)) <= ALIGNED for axis in axes) != 2:
            return False
    return True
