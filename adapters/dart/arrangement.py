"""How the bodies of a scene start beside each other: near, touching, laid level in stacks."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import assert_never

import numpy as np

from plumbline.adapters.dart.surfaces import touching_bodies
from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Effect,
    Ellipsoid,
    Plane,
    Scene,
    Shape,
    Sphere,
    TriangleMesh,
    rotation_matrix,
)
from plumbline.harness.trajectory import Floats

CLOSE = 0.01
"""Two bodies are near if their bounding balls meet, each larger by this share."""
TOUCH = 1e-3
"""Two bodies touch up to this share of the smaller's size."""
LEVEL = 1e-6
"""A face is level where at least three of its corners are equally high up to this share of a body's size."""
RING = 2 * math.pi * np.arange(64) / 64
"""Where corners stand for a circle [rad]; they leave out 0.12 % of its radius, of which ROUNDER gives back half."""
ROUNDER = 1.0006


@dataclass(frozen=True)
class Arrangement:
    """The movable bodies of a scene that can touch others, as they start."""

    scene: Scene

    @cached_property
    def bodies(self) -> list[Body]:
        """Those bodies."""
        return [body for body in touching_bodies(self.scene) if body.movable]

    @cached_property
    def held(self) -> frozenset[str]:
        """The bodies at joints."""
        return frozenset(name for pair in self.scene.joined() for name in pair)

    @cached_property
    def near(self) -> list[tuple[int, int]]:
        """Pairs of places in `bodies` whose bounding balls meet, of what can collide or is held by joints."""
        p_WB = np.array([body.p_WB for body in self.bodies]).reshape(-1, 3)
        reach = np.array([_reach(body) for body in self.bodies])
        gap = np.linalg.norm(p_WB[:, None] - p_WB[None], axis=2) - (1 + CLOSE) * (reach[:, None] + reach[None])
        return [(int(a), int(b)) for a, b in np.argwhere(np.triu(gap <= 0, 1)) if self._bears(self.bodies[a], self.bodies[b])]

    def _bears(self, a: Body, b: Body) -> bool:
        return a.name in self.held or b.name in self.held or self.scene.collides(a, b)

    @property
    def crowd(self) -> list[Body]:
        """The bodies that are near others."""
        return [self.bodies[k] for k in sorted({k for pair in self.near for k in pair})]

    @property
    def jointed(self) -> bool:
        """Does a joint hold one of the bodies that are near others?"""
        return any(body.name in self.held for body in self.crowd)

    @property
    def stacked(self) -> bool:
        """Does one lie on another, level face on level face, while all are at rest under gravity?"""
        pull = np.array(self.scene.gravity)
        still = not any(np.any(body.v_WB) or np.any(body.w_WB) for body in self.bodies)
        if not (still and pull.any() and Effect.GRAVITY in self.scene.effects):
            return False
        up = -pull / np.linalg.norm(pull)
        faces = {k: _faces(self.bodies[k], up) for k in {k for pair in self.near for k in pair}}
        return any(_lies_on(faces[a], faces[b]) or _lies_on(faces[b], faces[a]) for a, b in self.near)

    @property
    def touching(self) -> bool:
        """Do two of them touch?"""
        return any(_touch(self.bodies[a], self.bodies[b]) for a, b in self.near)


def _corners(shape: Shape) -> tuple[Floats, float]:
    """Points (n, 3) [m] about the origin of S and a radius [m]: the shape is the hull of balls of that radius about them."""
    match shape:
        case Sphere(radius=r):
            return np.zeros((1, 3)), r
        case Box(half_extents=half):
            return np.array([np.multiply(half, (x, y, z)) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]), 0.0
        case Capsule(radius=r, half_length=h):
            return np.array([(0.0, 0.0, -h), (0.0, 0.0, h)]), r
        case Cylinder(radius=r, half_length=h):
            return np.array([(ROUNDER * r * math.cos(a), ROUNDER * r * math.sin(a), z) for z in (-h, h) for a in RING]), 0.0
        case Ellipsoid(semi_axes=semi_axes):
            return np.zeros((1, 3)), max(semi_axes)
        case ConvexHull(vertices=vertices) | TriangleMesh(vertices=vertices):
            return np.asarray(vertices, dtype=np.float64), 0.0
        case Plane():
            raise ValueError("a plane cannot move")
        case _:
            assert_never(shape)


def _pieces(body: Body) -> list[tuple[Floats, float]]:
    """The corners of each shape in W about the world's origin (n, 3) m, with its radius [m]."""
    R_WB, pieces = np.array(rotation_matrix(body.q_WB)), []
    for placed in body.collision:
        points, radius = _corners(placed.shape)
        p_B = points @ np.array(rotation_matrix(placed.q_BS)).T + placed.p_BS
        pieces.append((p_B @ R_WB.T + body.p_WB, radius))
    return pieces


def _reach(body: Body) -> float:
    """Radius [m] of the ball about the body's origin that holds its shapes."""
    return max(float(np.linalg.norm(p - body.p_WB, axis=1).max()) + radius for p, radius in _pieces(body))


@dataclass(frozen=True, slots=True)
class _Faces:
    """Heights [m] of the lowest and the highest points of a body along `up`; is each of the two a level face? Its size [m]."""

    low: float
    high: float
    level_low: bool
    level_high: bool
    size: float


def _faces(body: Body, up: Floats) -> _Faces:
    """What a body turns to those above and below it."""
    size = _reach(body)
    heights = np.concatenate([p @ up for p, radius in _pieces(body) if radius == 0.0] or [np.zeros(0)])
    ends = [p @ up + sign * radius for p, radius in _pieces(body) for sign in (-1, 1)]
    low, high = min(float(h.min()) for h in ends), max(float(h.max()) for h in ends)
    level_low, level_high = (int((np.abs(heights - end) <= LEVEL * size).sum()) >= 3 for end in (low, high))
    return _Faces(low, high, level_low, level_high, size)


def _lies_on(upper: _Faces, lower: _Faces) -> bool:
    """Does a level face of one, or a part of one that has sunk in, lie on one of the other?"""
    middle = (lower.low + lower.high) / 2
    reached = middle < upper.low <= lower.high + TOUCH * min(upper.size, lower.size)
    return upper.level_low and lower.level_high and reached


def _touch(a: Body, b: Body) -> bool:
    """Are two bodies nearer to each other than a share of the smaller's size?"""
    most = TOUCH * min(_reach(a), _reach(b))
    return any(_distance(p, q) - r - s <= most for p, r in _pieces(a) for q, s in _pieces(b))


def _distance(p: Floats, q: Floats) -> float:
    """Distance [m] of the hulls of two sets of points: |p'a - q'b|, least over a, b >= 0 of sum 1.

    Source: Lawson, Hanson, Solving Least Squares Problems (1974), chapter 23 (non-negative least squares).
    """
    from scipy.optimize import nnls

    # Sums of 1 are asked for a thousand times as strongly as distances, of which they cost a millionth.
    middle, size, strong = q.mean(axis=0), float(np.ptp(np.concatenate((p, q)), axis=0).max()), 1e3
    if size == 0.0:
        return 0.0
    sums = np.array([[strong] * len(p) + [0.0] * len(q), [0.0] * len(p) + [strong] * len(q)])
    rows = np.vstack((np.hstack(((p - middle).T, -(q - middle).T)) / size, sums))
    return float(nnls(rows, np.array([0.0, 0.0, 0.0, strong, strong]))[1]) * size
