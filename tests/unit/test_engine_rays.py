"""Rays: tiles against brute force and against closed forms in fifty digits, patterns, threads, meshes, and visual geometry."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from plumbline import engine
from tests.rays_one_by_one import cast_one_by_one

Array = NDArray[np.float64]
UP = np.array([0.0, 0.0, 6.0])
SOLIDS: dict[str, engine.Shape] = {
    "sphere": engine.Sphere(0.5),
    "box": engine.Box((0.3, 0.4, 0.5)),
    "capsule": engine.Capsule(0.3, 0.4),
    "cylinder": engine.Cylinder(0.4, 0.3),
}

Cast = Callable[..., engine.Hits]
CASTS: tuple[Cast, ...] = (engine.World.cast, cast_one_by_one)


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def _scene(seed: int, count: int = 30) -> engine.World:
    """The plane z = 0 and bodies of one to two random shapes scattered over it, in a ball of radius 6 m."""
    rng = np.random.default_rng(seed)
    bodies = [engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])]
    for k in range(count):
        a, b, c = rng.uniform(0.1, 0.7, 3)
        every: list[engine.Shape] = [engine.Sphere(a), engine.Box((a, b, c)), engine.Capsule(a, b), engine.Cylinder(a, b)]
        shapes = [
            engine.Placed(every[int(rng.integers(4))], rng.normal(size=3) * 0.3, _unit(rng.normal(size=4)))
            for _ in range(int(rng.integers(1, 3)))
        ]
        place = rng.uniform(-6, 6, 3) + UP
        bodies.append(engine.Body(name=str(k), shapes=shapes, p_WB=place, q_WB=_unit(rng.normal(size=4))))
    return engine.World(bodies, options=engine.Options(contacts=False))


def _lidar(channels: int, columns: int) -> Array:
    up = np.linspace(-0.4, 0.4, channels)[:, None]
    turn = np.arange(columns) * 2 * np.pi / columns
    way = np.stack(np.broadcast_arrays(np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)), axis=-1)
    return way.reshape(-1, 3)


def _pinhole(width: int, height: int) -> Array:
    u, v = np.meshgrid(np.linspace(-0.6, 0.6, width), np.linspace(-0.4, 0.4, height))
    return np.stack([np.ones_like(u), u, v], axis=-1).reshape(-1, 3)


def _patterns(rng: np.random.Generator) -> dict[str, tuple[Array, Array]]:
    """Origins and directions of scans, images and rays without any order."""
    eye = rng.uniform(-5, 5, 3) + UP
    lidar, image = _lidar(5, 100), _pinhole(50, 7)
    shift = rng.normal(size=(len(image), 3)) * 0.05
    return {
        "lidar": (np.tile(eye, (len(lidar), 1)), lidar),
        "columns": (np.tile(eye, (len(lidar), 1)), lidar.reshape(5, 100, 3).swapaxes(0, 1).reshape(-1, 3).copy()),
        "image": (eye, image),
        "rolling image": (eye + shift, image),
        "parallel": (eye + np.column_stack([np.zeros(300), rng.uniform(-5, 5, (300, 2))]), np.tile([3.0, 0, 0], (300, 1))),
        "random": (rng.uniform(-9, 9, (401, 3)) + UP, rng.normal(size=(401, 3))),
        "one ray": (eye[None], rng.normal(size=(1, 3))),
        "none": (np.empty((0, 3)), np.empty((0, 3))),
    }


def _agree(world: engine.World, origins: Array, directions: Array, max_range: float) -> None:
    """Same hits, distances to rounding of lengths of 20 m (4e-15), a grazing ray's root taken of it: 1e-12 by experience of
    the oracle's own error; a plane that a ray grazes may lie kilometres away, which round by themselves (four roundings). Who
    ties to that is either's choice.
    """
    got = world.cast(origins, directions, max_range)
    want = cast_one_by_one(world, origins, directions, max_range)
    hit = np.isfinite(want.distance)
    assert (np.isfinite(got.distance) == hit).all()
    near = np.abs(got.distance[hit] - want.distance[hit]) - 4 * np.finfo(float).eps * want.distance[hit]
    assert near.max(initial=-math.inf) < 1e-12
    same = (got.body == want.body) & (got.shape == want.shape)
    assert same[~hit].all()
    assert (got.normal[~hit] == 0).all()
    assert same.mean() > 0.99 if len(same) > 100 else True
    # At an edge of a box the two may take either face.
    edge = np.abs(got.normal - want.normal).max(axis=1, initial=0.0) > 1e-9
    assert (edge & same).sum() <= max(1, len(same) // 1000)
    assert np.abs(np.linalg.norm(got.normal[hit], axis=1) - 1).max(initial=0.0) < 1e-12


@settings(max_examples=10, deadline=None)
@example(seed=1, max_range=math.inf)  # a plane at kilometres
@given(seed=st.integers(0, 2**31), max_range=st.sampled_from([math.inf, 6.0, 0.5]))
def test_tiles_find_what_brute_force_finds_in_any_pattern(seed: int, max_range: float) -> None:
    world = _scene(seed)
    for origins, directions in _patterns(np.random.default_rng(seed)).values():
        _agree(world, origins, directions, max_range)


@pytest.mark.slow
@pytest.mark.parametrize("name", SOLIDS)
def test_tiles_find_what_brute_force_finds_for_4e5_rays_of_each_shape(name: str) -> None:
    """From near and far, towards the shape and past it."""
    rng = np.random.default_rng(1)
    place = np.array([1.0, 2.0, 3.0])
    world = engine.World([engine.Body(shapes=[engine.Placed(SOLIDS[name])], p_WB=place, q_WB=_unit(rng.normal(size=4)))])
    for distance in (0.2, 1.0, 3.0, 100.0):
        start = distance * _unit(rng.normal(size=(100_000, 3)))
        aim = rng.uniform(-0.7, 0.7, (100_000, 3))
        got = world.cast(start + place, aim - start)
        want = cast_one_by_one(world, start + place, aim - start)
        hit = np.isfinite(want.distance) & np.isfinite(got.distance)
        # A ray that grazes by less than rounding may hit or miss: with 1e-14 m of 1 m that is one of 1e7 or so.
        assert (np.isfinite(want.distance) != np.isfinite(got.distance)).sum() <= 1
        cosine = np.abs(np.sum(got.normal * _unit(aim - start), axis=1))[hit]
        assert (np.abs(got.distance[hit] - want.distance[hit]) * cosine).max() < 1e-14 * max(1.0, distance) * 10


def _first_crossing(shape: engine.Shape, o: list[Any], d: list[Any]) -> Any:
    """The least t >= 0 at which o + t d lies on the boundary, in the precision of mpmath."""
    mp = mpmath.mp

    def quadric(a: Any, b: Any, c: Any) -> list[Any]:
        root = b * b - a * c
        return [] if a == 0 or root < 0 else [(-b - mp.sqrt(root)) / a, (-b + mp.sqrt(root)) / a]

    found: list[Any] = []
    if isinstance(shape, engine.Box):
        for k in range(3):
            for side in (-1, 1):
                if d[k] != 0:
                    t = (side * mp.mpf(shape.half_extents[k]) - o[k]) / d[k]
                    if all(abs(o[j] + t * d[j]) <= shape.half_extents[j] for j in range(3) if j != k):
                        found.append(t)
        return min((t for t in found if t >= 0), default=mp.inf)
    r = mp.mpf(shape.radius)  # type: ignore[union-attr]
    half = mp.mpf(getattr(shape, "half_length", 0.0))
    flat = [sum(u[k] * v[k] for k in (0, 1)) for u, v in ((d, d), (o, d), (o, o))]
    if not isinstance(shape, engine.Sphere):
        found += [t for t in quadric(flat[0], flat[1], flat[2] - r * r) if abs(o[2] + t * d[2]) <= half]
    for end in (-half, half):
        z = o[2] - end
        if isinstance(shape, engine.Cylinder):
            if d[2] != 0:
                t = -z / d[2]
                found += [t] if (o[0] + t * d[0]) ** 2 + (o[1] + t * d[1]) ** 2 <= r * r else []
        else:
            ends = quadric(flat[0] + d[2] ** 2, flat[1] + z * d[2], flat[2] + z * z - r * r)
            found += [t for t in ends if (z + t * d[2]) * mp.sign(end) >= 0]
    return min((t for t in found if t >= 0), default=mp.inf)


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("distance", [0.1, 2.0, 1e3, 1e6])
def test_distances_are_those_of_closed_forms_in_fifty_digits(name: str, distance: float) -> None:
    """Rays inside, near, far and very far, a third of them along an axis: 1e-12 of the way or of 1 m, times how much the
    slope of the surface enlarges it: an error of the place across the ray by e moves the hit by e / cosine.
    """
    rng = np.random.default_rng(7)
    start = distance * _unit(rng.normal(size=(60, 3)))
    aim = rng.uniform(-0.6, 0.6, (60, 3))
    way = _unit(aim - start)
    way[:20] = np.eye(3)[rng.integers(3, size=20)] * rng.choice([-1, 1], (20, 1))
    start[:20] = rng.uniform(-0.25, 0.25, (20, 3)) - way[:20] * distance
    # Straight along an edge's or a rim's own plane: what a slab or a tube must not divide by.
    hits = engine.World([engine.Body(shapes=[engine.Placed(SOLIDS[name])])]).cast(start, way)
    with mpmath.workdps(50):
        for k in range(60):
            o, d = [mpmath.mpf(x) for x in start[k]], [mpmath.mpf(x) for x in way[k]]
            length = mpmath.sqrt(sum(x * x for x in d))
            want = float(_first_crossing(SOLIDS[name], o, [x / length for x in d]))
            slope = abs(float(hits.normal[k] @ way[k])) or 1.0
            bound = 1e-12 * max(1.0, distance) / slope
            assert hits.distance[k] == pytest.approx(want, abs=bound, rel=0), (k, start[k], way[k])
    assert np.isfinite(hits.distance).sum() >= 20


def test_rays_along_edges_rims_and_faces_are_decided_as_by_brute_force() -> None:
    """Starts on the surface and far from it, along each axis: the same answer, hit or miss. A tangent of a round surface, which
    rounding decides, is left out: there a radius larger or smaller by 1e-12 decides otherwise.
    """
    reach = np.array([0.0, 0.3, 0.4, 0.5, 0.7, 0.7000000001])
    grid = np.stack(np.meshgrid(*[np.concatenate([-reach, reach])] * 3), axis=-1).reshape(-1, 3)

    def distances(cast: Cast, shape: engine.Shape, way: Array) -> Array:
        return cast(engine.World([engine.Body(shapes=[engine.Placed(shape)])]), grid, np.broadcast_to(way, grid.shape)).distance

    for shape in SOLIDS.values():
        for way in np.vstack([np.eye(3), -np.eye(3)]):
            got, want = distances(engine.World.cast, shape, way), distances(cast_one_by_one, shape, way)
            sure = np.full(len(grid), True)
            if not isinstance(shape, engine.Box):
                less, more = (
                    distances(cast_one_by_one, replace(shape, radius=shape.radius * r), way) for r in (1 - 1e-12, 1 + 1e-12)
                )
                sure = np.isfinite(less) == np.isfinite(more)
            assert sure.mean() > 0.8
            assert (np.isfinite(got) == np.isfinite(want))[sure].all()
            hit = np.isfinite(want) & sure
            # The root of 1e-12 of a radius, where a ray starts on the surface or nearly grazes it.
            assert got[hit] == pytest.approx(want[hit], abs=1e-7)


def test_the_order_of_rays_changes_nothing() -> None:
    """The same rays, shuffled, make tiles of other company: distance, body and normal stay the same, bit for bit."""
    world, rng = _scene(4), np.random.default_rng(0)
    way, eye = _pinhole(64, 20), np.array([-9.0, 0.0, 6.0])
    order = rng.permutation(len(way))
    one, other = world.cast(eye, way), world.cast(np.tile(eye, (len(way), 1)), way[order])
    for name in ("distance", "body", "shape", "normal"):
        assert (getattr(one, name)[order] == getattr(other, name)).all()


def test_coincident_shapes_go_to_the_first_in_any_order() -> None:
    ball = [engine.Placed(engine.Sphere(1.0))]
    world = engine.World([engine.Body(name=n, shapes=ball) for n in "ab"], options=engine.Options(contacts=False))
    hits = world.cast([[0, 0, 3.0], [0.5, 0, -3.0]], [[0, 0, -1.0], [0, 0, 1.0]])
    assert hits.body.tolist() == [0, 0]


def test_a_hit_at_the_range_counts_and_one_beyond_does_not() -> None:
    world = engine.World([engine.Body(shapes=[engine.Placed(engine.Sphere(1.0))])])
    for reach, distance in ((2.0, 2.0), (math.nextafter(2.0, 0.0), math.inf)):
        for cast in CASTS:
            assert cast(world, [[0, 0, 3.0]], [[0, 0, -1.0]], reach).distance.tolist() == [distance]


@pytest.mark.parametrize(
    ("origins", "directions", "words"),
    [
        ([[0, 0, math.nan]], [[0, 0, 1.0]], "rays: origins"),
        ([[0, 0, 0.0]], [[0, 0, math.inf]], "rays: directions"),
        ([[0, 0, 0.0]] * 200, [[0, 0, 1.0]] * 199 + [[0, 0, 0.0]], "rays: direction 199 has length 0"),
        ([[0, 0, 0.0]] * 2, [[0, 0, 1.0]] * 3, r"rays: origins \(2, 3\) and directions \(3, 3\)"),
        ([0.0, 0.0], [[0, 0, 1.0]], r"rays: origins \(2,\)"),
    ],
)
def test_bad_rays_are_refused(origins: Any, directions: Any, words: str) -> None:
    world = engine.World([engine.Body(shapes=[engine.Placed(engine.Sphere(1.0))])])
    with pytest.raises(ValueError, match=words):
        world.cast(origins, directions)


def test_unknown_choices_are_refused() -> None:
    world = engine.World([engine.Body()])
    for choice in ({"geometry": "drawn"}, {"threads": 0}):
        with pytest.raises(ValueError, match="rays: geometry"):
            world.cast([[0, 0, 0.0]], [[0, 0, 1.0]], **choice)  # type: ignore[arg-type]


def test_threads_answer_as_one_does() -> None:
    world, eye = _scene(2), np.array([-9.0, 0.0, 6.0])
    one, two = (world.cast(eye, _lidar(16, 512), threads=k) for k in (1, 2))
    for name in ("distance", "body", "shape", "normal"):
        assert (getattr(one, name) == getattr(two, name)).all()
    with pytest.raises(ValueError, match="direction 3 has length 0"):
        world.cast(eye, [[1.0, 0, 0]] * 3 + [[0, 0, 0.0]], threads=2)


def _torus(around: int, across: int) -> tuple[Array, NDArray[np.int64]]:
    """A torus of radii 1 m and .3 m about z: vertices and faces, counter-clockwise from outside."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    ring = 1 + 0.3 * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), 0.3 * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    return vertices, np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])


def _nearest_triangle(corners: Array, o: Array, d: Array) -> float:
    """The least t >= 0 with o + t d = a + u (b - a) + v (c - a) within a triangle of corners (n, 3, 3): Cramer's rule."""
    a, e, f = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(d, f)
    det, s = np.sum(e * p, axis=1), o - a
    q = np.cross(s, e)
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v, t = np.sum(s * p, axis=1) / det, q @ d / det, np.sum(f * q, axis=1) / det
        return float(np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0), t, np.inf).min())


@pytest.mark.parametrize("around", [(20, 20), pytest.param((40, 40), marks=pytest.mark.slow)])
def test_the_tree_of_a_mesh_and_hulls_finds_the_nearest_face(around: tuple[int, int]) -> None:
    """A torus of many triangles and a hull on a turned body, seen by 150 rays, and a sphere in front of some."""
    rng = np.random.default_rng(5)
    vertices, faces = _torus(*around)
    q, p = _unit(rng.normal(size=4)), np.array([3.0, -1.0, 2.0])
    rock = rng.normal(size=(12, 3)) * 0.2
    turn = Rotation.from_quat(q, scalar_first=True)
    body = engine.Body(
        name="ring", motion="static", p_WB=p, q_WB=q,
        shapes=[engine.Placed(engine.Sphere(0.1), (0, 0, 1.0)), engine.Placed(engine.TriangleMesh(vertices, faces)),
                engine.Placed(engine.ConvexHull(rock))],
    )  # fmt: skip
    alone = engine.World([engine.Body(shapes=[engine.Placed(engine.ConvexHull(rock))], p_WB=p, q_WB=q)])
    ball = engine.World([engine.Body(shapes=[engine.Placed(engine.Sphere(0.1), (0, 0, 1.0))], p_WB=p, q_WB=q)])
    start = p + 3 * _unit(rng.normal(size=(150, 3)))
    way = _unit(p + rng.uniform(-1, 1, (150, 3)) - start)
    corners = turn.apply(vertices)[faces] + p
    mesh = np.array([_nearest_triangle(corners, o, d) for o, d in zip(start, way, strict=True)])
    each = np.stack([ball.cast(start, way).distance, mesh, alone.cast(start, way).distance])
    world = engine.World([body])
    for reach in (math.inf, 2.5):
        want = np.where(each.min(axis=0) <= reach, each.min(axis=0), np.inf)
        hits = world.cast(start, way, reach)
        met = np.isfinite(want)
        assert 25 < met.sum() < 150
        assert (np.isfinite(hits.distance) == met).all()
        assert hits.distance[met] == pytest.approx(want[met], abs=1e-12)
        assert (hits.shape == np.where(met, each.argmin(axis=0), -1)).all()
        assert np.abs(np.linalg.norm(hits.normal[met], axis=1) - 1).max() < 1e-12


def test_rays_see_the_visual_shapes_where_they_are_asked_to() -> None:
    """A dynamic body that touches as a ball and is drawn as a torus: a ray through the hole hits the ball only, also when the
    body has moved; bodies without visual shapes show what touches.
    """
    vertices, faces = _torus(24, 12)
    drawn = [engine.Placed(engine.TriangleMesh(vertices, faces))]
    ring = engine.Body(name="ring", shapes=[engine.Placed(engine.Sphere(0.2))], visual=drawn, v_WB=(1, 0, 0))
    wall = engine.Body(name="wall", motion="static", shapes=[engine.Placed(engine.Plane())], p_WB=(0, 0, -2))
    world = engine.World([ring, wall], gravity=(0, 0, 0))
    for x in (0.0, 2.0):
        rays = [[x, 0, 5.0], [x + 1.0, 0, 5.0]]
        solid = world.cast(rays, [[0, 0, -1.0]] * 2)
        seen = world.cast(rays, [[0, 0, -1.0]] * 2, geometry="visual")
        assert solid.distance == pytest.approx([4.8, 7.0], abs=1e-12)
        assert solid.body.tolist() == [0, 1]
        assert seen.distance == pytest.approx([7.0, 4.7], abs=1e-12)
        assert seen.body.tolist() == [1, 0]
        world.step(480)


@pytest.mark.compiler
def test_read_only_rays_compile_nothing_anew() -> None:
    """One origin seen many times over, as the harness tells it, is a read-only array; to the compiler that is another type."""
    from plumbline.engine.rays import tiles

    world = engine.World([engine.Body(name="g", motion="static", shapes=[engine.Placed(engine.Plane())])])
    directions = np.tile([0.0, 0.0, -1.0], (4, 1))
    world.cast([[0.0, 0.0, 3.0]], directions)
    origins = np.broadcast_to(np.array([0.0, 0.0, 3.0]), directions.shape)
    directions.flags.writeable = False
    world.cast(origins, directions)
    compiled: Any = tiles.cast_tiles
    assert len(compiled.signatures) == 1
