"""How deep the bodies of a scene stand in one another along a trajectory, pair by pair, from their poses and shapes.

How deep solids stand in one another, from their shapes and poses alone: the shortest way that parts them.

A solid is the convex hull of some points, its core, and all that lies within a radius of it, which for a cylinder is a radius
about its axis. The depth of two of them is the least, over all directions d, of the way along d that parts them,

    depth = min over |d| = 1 of  max_a a . d - min_b b . d,

a negative one being the distance between them. Any d gives an upper bound, so that it is enough to try a set of directions that
the best one is sure to lie in: for two polyhedra the normals of their faces and the products of their edges, for round solids
also the ways between corners and between corners and edges. Two polyhedra with many edges have too many products of them: those
are left to `difference_depth`.
Source: Ericson, Real-Time Collision Detection (2005), sections 4.4 and 5.2; Gottschalk, Lin, Manocha, OBBTree (1996).

How deep two polyhedra of many corners stand in one another: their difference, grown from within.

The depth is the distance from the origin to the nearest face of D = {a - b}. The hull of some points of D lies within it, so
that its own nearest face is no farther; how far D goes along that face's normal is no nearer. The corner of D that lies there
is added to the points, again and again, until the two meet; a body that hardly moved begins with the corners that its last pose
ended with.
What is sought are the few faces near the origin: neither all pairs of edges nor all of their memory.
Source: van den Bergen, Proximity Queries and Penetration Depth Computation on 3D Game Objects (2001), section 4.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from itertools import product as every

import numpy as np

from plumbline.harness.scene import Box, Capsule, ConvexHull, Cylinder, PlacedShape, Plane, Scene, Shape, Sphere
from plumbline.harness.trajectory import Floats, Integers, Trajectory
from plumbline.harness.trajectory.kinematics import product, rotate

_WAYS = np.array([direction for direction in every((-1.0, 0.0, 1.0), repeat=3) if any(direction)])
_WAYS /= np.linalg.norm(_WAYS, axis=1)[:, None]
_AT_ONCE = 12
"""Faces that are looked beyond in one turn."""
_KEPT = 48
"""Corners of the difference that the next pose begins with: those of the faces that are nearest."""
_ROUNDING = 1e-12
"""Of the size of the two: faces nearer to their bound than this are faces of the difference."""


def difference_depths(corners_a: Floats, corners_b: Floats) -> Floats:
    """The depth at each of t poses, (t,) m; where the two are apart, no less than minus their distance.

    Args: corners_a (t, k, 3), corners_b (t, m, 3): in one frame, each of a body that is not flat.
    """
    depths, pairs = np.empty(len(corners_a)), np.zeros((0, 2), dtype=np.int64)
    for t, (a, b) in enumerate(zip(corners_a, corners_b, strict=True)):
        depths[t], pairs = _depth(a, b, pairs)
    return depths


class _Difference:
    """Corners of {a - b} by the places of a and b. Terms: pairs (n, 2), points (n, 3) m: so far, each once."""

    def __init__(self, a: Floats, b: Floats, pairs: Integers) -> None:
        self._a, self._b = a, b
        self.pairs, self.points = pairs, a[pairs[:, 0]] - b[pairs[:, 1]]
        self._known = {(int(i), int(j)) for i, j in pairs}

    def along(self, ways: Floats) -> tuple[Floats, bool]:
        """How far the difference goes along unit vectors (n, 3), (n,) m; were its corners there new?"""
        pairs = np.stack([np.argmax(ways @ self._a.T, axis=1), np.argmin(ways @ self._b.T, axis=1)], axis=1)
        points = self._a[pairs[:, 0]] - self._b[pairs[:, 1]]
        far: Floats = np.einsum("ni,ni->n", ways, points)
        fresh = list[int]()
        for n, pair in enumerate(map(tuple, pairs.tolist())):
            if pair not in self._known:
                self._known.add(pair)
                fresh.append(n)
        self.pairs = np.concatenate([self.pairs, pairs[fresh]])
        self.points = np.concatenate([self.points, points[fresh]])
        return far, bool(fresh)


def _depth(a: Floats, b: Floats, pairs: Integers) -> tuple[float, Integers]:
    """The depth at one pose [m], and the corners to begin the next one with. Args: pairs: to begin this one with."""
    from scipy.spatial import ConvexHull as Hull  # late: a listing must not pay for it

    difference = _Difference(a, b, pairs)
    centre = a.mean(axis=0) - b.mean(axis=0)
    length = float(np.linalg.norm(centre))
    # Where they are apart, the way between their centres mostly parts them.
    ways = _WAYS if length == 0.0 else np.concatenate([_WAYS, -centre[None] / length])
    far, _ = difference.along(ways)
    least, size, fresh = float(far.min()), float(far.max()), True
    while fresh and least > 0.0:
        hull = Hull(difference.points)
        away = -hull.equations[:, 3]
        order = np.argsort(away)
        near = order[:_AT_ONCE][away[order[:_AT_ONCE]] < least - _ROUNDING * size]
        pairs = difference.pairs[np.unique(hull.simplices[order[:_KEPT]])]
        if len(near) == 0:
            break
        far, fresh = difference.along(hull.equations[near, :3])
        least = min(least, float(far.min()))
    return least, pairs


FLAT = 1e-9
"""A direction shorter than this, of unit vectors' products and of corners' distances [m], is none."""
FEW = 2**15
"""Of directions times corners: two polyhedra with more are measured by their difference, which is the faster then."""
TOGETHER = 2**22
"""Of directions times corners times poses that are tried in one call: 32 MB of numbers."""


class Unmeasured(ValueError):
    """No exact depth is known of such a shape or pair; the text says of which."""


@dataclass(frozen=True, slots=True)
class Convex:
    """A shape in its own frame S.

    Terms:
        corners: (k, 3) m of the core; none of a half space. normals: (f, 3) of its faces, unit, outward. edges: (e, 2) corners.
        sides: edges, one of each direction. radius [m]: what lies within it of the core is solid. rim [m]: radius about z of a
        cylinder, else 0. name: in words.
    """

    corners: Floats
    normals: Floats
    edges: tuple[tuple[int, int], ...]
    radius: float
    rim: float
    name: str
    sides: tuple[tuple[int, int], ...] = field(init=False)

    def __post_init__(self) -> None:
        """Each direction of edges once."""
        own = np.array([self.corners[end] - self.corners[start] for start, end in self.edges]).reshape(-1, 3)
        own = own / np.linalg.norm(own, axis=1)[:, None]
        first = [k for k in range(len(own)) if k == 0 or np.max(np.abs(own[:k] @ own[k])) < 1.0 - FLAT]
        object.__setattr__(self, "sides", tuple(self.edges[k] for k in first))


NONE, UP = np.zeros((0, 3)), np.array([0.0, 0.0, 1.0])
_SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
_SIX = np.concatenate((np.eye(3), -np.eye(3)))
_TWELVE = tuple((i, i | bit) for bit in (1, 2, 4) for i in range(8) if not i & bit)


@cache
def solid(shape: Shape) -> Convex:
    """A scene's shape as a solid. Raises: Unmeasured, of a triangle mesh."""
    match shape:
        case Sphere(radius=radius):
            return Convex(np.zeros((1, 3)), NONE, (), radius, 0.0, "sphere")
        case Capsule(radius=radius, half_length=half):
            return Convex(np.array([[0.0, 0.0, -half], [0.0, 0.0, half]]), NONE, ((0, 1),), radius, 0.0, "capsule")
        case Cylinder(radius=radius, half_length=half):
            return Convex(np.array([[0.0, 0.0, -half], [0.0, 0.0, half]]), NONE, (), 0.0, radius, "cylinder")
        case Box(half_extents=half_extents):
            return Convex(_SIGNS * np.array(half_extents), _SIX, _TWELVE, 0.0, 0.0, "box")
        case ConvexHull(vertices=vertices):
            return _hull(np.array(vertices))
        case Plane(normal=normal):
            return Convex(NONE, np.array([normal]), (), 0.0, 0.0, "plane")
        case _:
            raise Unmeasured(f"a {shape.type.replace('_', ' ')} is no convex solid")


def _hull(vertices: Floats) -> Convex:
    from scipy.spatial import ConvexHull as Hull  # late: a listing must not pay for it

    hull = Hull(vertices)
    corners, corner_of = vertices[hull.vertices], {int(k): i for i, k in enumerate(hull.vertices)}
    normals = np.unique(np.round(hull.equations[:, :3], 12), axis=0)
    outward = hull.equations[:, :3]
    edges = set()
    for face, (triangle, beside) in enumerate(zip(hull.simplices.tolist(), hull.neighbors.tolist(), strict=True)):
        for i, other in enumerate(beside):
            # Two triangles of one face have no edge between them.
            if outward[face] @ outward[other] < 1.0 - FLAT:
                a, b = corner_of[triangle[i - 1]], corner_of[triangle[i - 2]]
                edges.add((min(a, b), max(a, b)))
    return Convex(corners, normals / np.linalg.norm(normals, axis=1)[:, None], tuple(sorted(edges)), 0.0, 0.0, "convex hull")


def reach(convex: Convex) -> float:
    """Radius [m] of the ball about the origin of S that holds the solid; infinite for a half space."""
    if len(convex.corners) == 0:
        return np.inf
    return float(np.max(np.hypot(np.linalg.norm(convex.corners, axis=1), convex.rim))) + convex.radius


def _along(convex: Convex, corners: Floats, axis: Floats, d: Floats) -> Floats:
    """The farthest that a solid goes along each direction, (t, n) m; corners (t, k, 3), axis (t, 3), d (t, n, 3) unit."""
    farthest: Floats = np.max(np.einsum("tki,tni->tnk", corners, d), axis=2) + convex.radius
    if convex.rim > 0:
        cosine = np.einsum("ti,tni->tn", axis, d)
        farthest = farthest + convex.rim * np.sqrt(np.maximum(0.0, 1.0 - cosine**2))
    return farthest


def _between(a: Convex, corners_a: Floats, corners_b: Floats, b: Convex) -> list[Floats]:
    """Ways from the corners and edges of core a to those of core b, each (t, n, 3): where two cores apart are nearest."""
    ways = [(corners_b[:, None, :, :] - corners_a[:, :, None, :]).reshape(len(corners_a), -1, 3)]
    for points, other, edges, sign in ((corners_a, corners_b, b.edges, 1.0), (corners_b, corners_a, a.edges, -1.0)):
        for start, end in edges:
            along = other[:, end] - other[:, start]
            along = along / np.linalg.norm(along, axis=1)[:, None]
            way = other[:, None, start] - points
            ways.append(sign * (way - np.einsum("tki,ti->tk", way, along)[..., None] * along[:, None]))
    return ways


def depth(a: Convex, p_WA: Floats, q_WA: Floats, b: Convex, p_WB: Floats, q_WB: Floats) -> Floats:
    """How deep solids a and b stand in one another at each of t poses of their frames, (t,) m; negative where they are apart.

    Two polyhedra that are apart are told to be at least as near as they are.
    Raises: Unmeasured, of a cylinder and what is no half space.
    """
    if len(a.corners) == 0:
        return depth(b, p_WB, q_WB, a, p_WA, q_WA)
    corners_a = p_WA[:, None] + rotate(q_WA[:, None], a.corners)
    axis_a = rotate(q_WA, UP)
    if len(b.corners) == 0:
        normal = rotate(q_WB, b.normals[0])
        into: Floats = np.einsum("ti,ti->t", p_WB, normal) + _along(a, corners_a, axis_a, -normal[:, None])[:, 0]
        return into
    if a.rim > 0 or b.rim > 0:
        raise Unmeasured(f"a {a.name} and a {b.name}")
    corners_b = p_WB[:, None] + rotate(q_WB[:, None], b.corners)
    tried = _tried(a, b) * max(len(a.corners), len(b.corners))
    if tried > FEW and a.radius == 0 and b.radius == 0:
        return difference_depths(corners_a - p_WA[:, None], corners_b - p_WA[:, None])
    least: Floats = np.empty(len(p_WA))
    chunk = max(1, TOGETHER // tried)
    for t in range(0, len(p_WA), chunk):
        some = slice(t, t + chunk)
        least[some] = _over_directions(a, corners_a[some], q_WA[some], b, corners_b[some], q_WB[some])
    return least


def _tried(a: Convex, b: Convex) -> int:
    """How many directions are tried for two solids."""
    tried = len(a.normals) + len(b.normals) + 2 * len(a.sides) * len(b.sides) + 1
    if a.radius > 0 or b.radius > 0:
        tried += len(a.corners) * len(b.corners) + len(a.corners) * len(b.edges) + len(b.corners) * len(a.edges)
    return tried


def _over_directions(a: Convex, corners_a: Floats, q_WA: Floats, b: Convex, corners_b: Floats, q_WB: Floats) -> Floats:
    """The depth at each of t poses over all directions that the best one may be, (t,) m. Args: corners (t, k, 3) m, in W."""
    normals_a, normals_b = rotate(q_WA[:, None], a.normals), rotate(q_WB[:, None], b.normals)
    sides_a, sides_b = _sides(a, corners_a), _sides(b, corners_b)
    crossed = np.cross(sides_a[:, :, None], sides_b[:, None]).reshape(len(q_WA), sides_a.shape[1] * sides_b.shape[1], 3)
    # Upwards, in case of two centres in one place, between which there is no way.
    ways = [normals_a, -normals_b, crossed, -crossed, np.broadcast_to(UP, (len(q_WA), 1, 3))]
    if a.radius > 0 or b.radius > 0:
        ways += _between(a, corners_a, corners_b, b)
    d = np.concatenate(ways, axis=1)
    length = np.linalg.norm(d, axis=2)
    none = length < FLAT
    d = np.where(none[..., None], 0.0, d / np.where(none, 1.0, length)[..., None])
    apart = _along(a, corners_a, NONE, d) + _along(b, corners_b, NONE, -d)
    least: Floats = np.min(np.where(none, np.inf, apart), axis=1)
    return least


def _sides(convex: Convex, corners: Floats) -> Floats:
    """The directions of a core's edges, each once, (t, m, 3) unit."""
    if not convex.sides:
        return np.zeros((len(corners), 0, 3))
    starts, ends = (list(places) for places in zip(*convex.sides, strict=True))
    ways = corners[:, ends] - corners[:, starts]
    sides: Floats = ways / np.linalg.norm(ways, axis=2)[..., None]
    return sides


POSES = 1024
"""Of pairs that are measured in one call: enough to outweigh its start, few enough for the directions of each to fit memory."""


@dataclass(frozen=True, slots=True)
class _Near:
    """Two shapes that come near. Terms: a, b: their numbers. at: the samples at which they are near, (k,)."""

    a: int
    b: int
    at: Integers


def _shapes(scene: Scene) -> list[tuple[int, PlacedShape]]:
    return [(place, placed) for place, body in enumerate(scene.bodies) for placed in body.collision]


def _poses(run: Trajectory, place: int, placed: PlacedShape) -> tuple[Floats, Floats]:
    """Position (t, 3) m and attitude (t, 4) of a shape in W."""
    q_WB = run.q_WB[:, place]
    return run.p_WB[:, place] + rotate(q_WB, np.array(placed.p_BS)), product(q_WB, np.array(placed.q_BS))


def pair_depths(scene: Scene, run: Trajectory) -> Iterator[tuple[int, int, Floats | None]]:
    """Of each two shapes that come near: their bodies' places, and how deep the shapes stand in one another, (t,) m.

    -inf where they are far apart; None of a pair of shapes whose depth is not known exactly.
    """
    shapes = _shapes(scene)
    if not shapes or len(run) == 0:
        return
    p, q = (np.stack(parts, axis=1) for parts in zip(*(_poses(run, place, placed) for place, placed in shapes), strict=True))
    solids = [_solid(placed) for _, placed in shapes]
    for pairs in _together(_near(scene, [place for place, _ in shapes], solids, p)):
        for pair, deep in zip(pairs, _depths(pairs, solids, p, q), strict=True):
            whole = None if deep is None else np.full(len(run), -np.inf)
            if whole is not None:
                whole[pair.at] = deep
            yield shapes[pair.a][0], shapes[pair.b][0], whole


def _near(scene: Scene, places: Sequence[int], solids: Sequence[Convex | None], p: Floats) -> Iterator[_Near]:
    """The pairs of shapes that can touch and come near. Args: places: of their bodies; p: of the shapes, (t, n, 3) m."""
    reaches = np.array([math.inf if hull is None else reach(hull) for hull in solids])
    for a, place in enumerate(places):
        near = np.sum((p[:, :a] - p[:, a : a + 1]) ** 2, axis=2) <= (reaches[:a] + reaches[a]) ** 2
        for b in np.flatnonzero(near.any(axis=0)).tolist():
            if scene.collides(scene.bodies[place], scene.bodies[places[b]]):
                yield _Near(a, b, np.flatnonzero(near[:, b]))


def _together(pairs: Iterable[_Near]) -> Iterator[list[_Near]]:
    """The pairs in their order, as many at once as have `POSES` poses between them."""
    some, poses = list[_Near](), 0
    for pair in pairs:
        some.append(pair)
        poses += len(pair.at)
        if poses >= POSES:
            yield some
            some, poses = [], 0
    if some:
        yield some


def _solid(placed: PlacedShape) -> Convex | None:
    try:
        return solid(placed.shape)
    except Unmeasured:
        return None


def _depths(pairs: Sequence[_Near], solids: Sequence[Convex | None], p: Floats, q: Floats) -> list[Floats | None]:
    """The depth of each pair where it is near, (k,) m; None where it is not known exactly. Equal solids go together."""
    alike: dict[tuple[int, int], list[int]] = {}
    for number, pair in enumerate(pairs):
        # Equal shapes are one solid.
        alike.setdefault((id(solids[pair.a]), id(solids[pair.b])), []).append(number)
    deep: list[Floats | None] = [None] * len(pairs)
    for numbers in alike.values():
        chosen = [pairs[number] for number in numbers]
        a, b = solids[chosen[0].a], solids[chosen[0].b]
        if a is None or b is None:
            continue
        counts, samples = [len(pair.at) for pair in chosen], np.concatenate([pair.at for pair in chosen])
        at_a = samples, np.repeat([pair.a for pair in chosen], counts)
        at_b = samples, np.repeat([pair.b for pair in chosen], counts)
        with suppress(Unmeasured):
            measured = depth(a, p[at_a], q[at_a], b, p[at_b], q[at_b])
            for number, own in zip(numbers, np.split(measured, np.cumsum(counts)[:-1]), strict=True):
                deep[number] = own
    return deep
