"""The geometry of contact apart from dynamics: distances, depths, manifolds and rays of convex shapes and meshes."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.spatial import ConvexHull as Quickhull
from scipy.spatial.transform import Rotation

from plumbline import engine
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.arena import float_table
from tests.engine_entries import measure_convex

Array = NDArray[np.float64]
RNG = np.random.default_rng(11)
ROCK = RNG.normal(size=(24, 3)) * (0.3, 0.2, 0.15)
CUBE = np.array(list(itertools.product((-0.1, 0.1), (-0.1, 0.1), (-0.1, 0.1))))
SHAPES: dict[str, engine.Shape] = {
    "sphere": engine.Sphere(0.2),
    "capsule": engine.Capsule(0.1, 0.25),
    "box": engine.Box((0.3, 0.2, 0.1)),
    "cylinder": engine.Cylinder(0.2, 0.15),
    "hull": engine.ConvexHull(ROCK.tolist()),
}
PAIRS = list(itertools.combinations_with_replacement(SHAPES, 2))
POLYHEDRAL = [pair for pair in PAIRS if "cylinder" not in pair]
ROUNDING = 1e-11
"""Rounding of a distance [m] of shapes below 1 m in size, some hundred operations of 1e-16 each, the search's own bound
(1e-14 relative in the square) included with a margin of ten."""
STALLED = 1e-8
"""As above for a cylinder: the search ends where |v|^2 falls by rounding only, 1e-16 m / gap of
it, and the normal then errs by the square root."""
CURVED = 2e-6
"""Error [m] of the depth of a round shape where the polytope runs out of its 160 corners: the sagitta s^2 / 8 r of the last
facets, s = 1 mm and r = .1 m."""


def _core(shape: engine.Shape) -> tuple[Array, float]:
    """Corners (n, 3) of the core of a shape that is a polytope with a radius around it."""
    if isinstance(shape, engine.Sphere):
        return np.zeros((1, 3)), shape.radius
    if isinstance(shape, engine.Capsule):
        return np.array([[0, 0, shape.half_length], [0, 0, -shape.half_length]]), shape.radius
    if isinstance(shape, engine.Box):
        return np.array(list(itertools.product(*[(-h, h) for h in shape.half_extents]))), 0.0
    assert isinstance(shape, engine.ConvexHull)
    return np.asarray(shape.vertices, float), 0.0


def _reach(shape: engine.Shape, n: Array) -> Array:
    """The support function of a shape along directions (..., 3) of its own frame [m], from the definition of each shape."""
    if isinstance(shape, engine.Cylinder):
        return np.asarray(shape.radius * np.hypot(n[..., 0], n[..., 1]) + shape.half_length * np.abs(n[..., 2]))
    corners, radius = _core(shape)
    return np.asarray((n @ corners.T).max(axis=-1) + radius * np.linalg.norm(n, axis=-1))


def _poses(seed: int, count: int, spread: float) -> tuple[Array, Array]:
    """Positions (k, 3) m within a ball of radius `spread` and rotations (k, 3, 3), any as likely as any other."""
    rng = np.random.default_rng(seed)
    way = rng.normal(size=(count, 3))
    way *= (spread * rng.uniform(size=count) ** (1 / 3) / np.linalg.norm(way, axis=1))[:, None]
    return way, Rotation.random(count, random_state=rng).as_matrix()


def _measure(one: engine.Shape, two: engine.Shape, a: tuple[Array, Array], b: tuple[Array, Array]) -> Array:
    """Gap, normal and closest points (k, 10) of two shapes at the poses a and b of their given frames."""
    bodies = [engine.Body(name=str(k), shapes=[engine.Placed(shape)]) for k, shape in enumerate((one, two))]
    bodies.append(engine.Body(name="third", shapes=[engine.Placed(engine.Cylinder(1, 1))]))
    floats, ints = engine.World(bodies).save()
    table = float_table(floats, ints, at.SHAPE)
    poses = []
    for k, (p, r) in enumerate((a, b)):
        poses.append(np.concatenate([p + r @ table[k, at.OFFSET : at.OFFSET + 3], r.reshape(-1, 9)], axis=1))
    out = np.empty((len(a[0]), 10))
    measure_convex(floats, ints, 0, 1, poses[0], poses[1], out)
    return out


def _signed_distance(one: engine.Shape, two: engine.Shape, p: Array, r: Array) -> float:
    """The exact gap [m] of two polytopes with radii: a quadratic program outside, the nearest facet of A - B inside."""
    (va, ra), (vb, rb) = _core(one), _core(two)
    difference = (va[:, None, :] - (vb @ r.T + p)[None]).reshape(-1, 3)
    if np.linalg.matrix_rank(difference - difference[0], tol=1e-9) == 3:
        deepest = float(Quickhull(difference).equations[:, 3].max())
        if deepest < 0:
            return deepest - ra - rb
    # min |V x| over x >= 0, sum x = 1: least squares with the row of ones has the same minimum up to a scale.
    x, _ = nnls(np.vstack([difference.T, np.ones(len(difference))]), np.array([0, 0, 0, 1.0]), maxiter=10_000)
    return float(np.linalg.norm(difference.T @ (x / x.sum()))) - ra - rb


def _certify(one: engine.Shape, two: engine.Shape, a: tuple[Array, Array], b: tuple[Array, Array], found: Array) -> Array:
    """Check that the normal parts the shapes by exactly the gap and that the two points lie apart by it along the normal.

    With both, a positive gap is the distance: no two points are closer than the slab, and these two are that close.
    Returns: which poses are apart.
    """
    gap, n, qa, qb = found[:, 0], found[:, 1:4], found[:, 4:7], found[:, 7:]
    (pa, ra), (pb, rb) = a, b
    high = np.einsum("ki,ki->k", pa, n) + _reach_each(one, ra, n)
    low = np.einsum("ki,ki->k", pb, n) - _reach_each(two, rb, -n)
    assert np.abs(np.linalg.norm(n, axis=1) - 1).max() < 1e-12
    # Rounding of v by 1e-16 m turns a short v by 1e-16 / gap, and the slab of shapes 1 m in size shifts by as much.
    core = np.abs(gap + sum(s.radius for s in (one, two) if isinstance(s, engine.Sphere | engine.Capsule)))
    bound = ROUNDING + 1e-15 / core
    if isinstance(one, engine.Cylinder) or isinstance(two, engine.Cylinder):
        bound = STALLED + STALLED / np.sqrt(core)
    assert (np.abs(low - high - gap) < bound).all()
    apart = gap > 0
    if apart.any():
        # The points' own way may lean from the normal by the square root of the search's bound, times 1 m.
        assert np.abs(qb - qa - gap[:, None] * n)[apart].max() < 1e-6
    return np.asarray(apart)


def _reach_each(shape: engine.Shape, r: Array, n: Array) -> Array:
    """The reach of a shape turned by r (k, 3, 3) along n (k, 3)."""
    return _reach(shape, np.einsum("kji,kj->ki", r, n))


def _check(pair: tuple[str, str], seed: int, count: int, exact: int) -> None:
    """Random poses of a pair: certificates for all, the exact signed distance for the first `exact` of polytopes."""
    one, two = SHAPES[pair[0]], SHAPES[pair[1]]
    a, b = _poses(seed, count, 0.4), _poses(seed + 1, count, 0.4)
    found = _measure(one, two, a, b)
    apart = _certify(one, two, a, b, found)
    back = _measure(two, one, b, a)
    bound = CURVED if "cylinder" in pair else 1e-10
    assert np.abs(back[:, 0] - found[:, 0]).max() < bound
    ways = np.random.default_rng(seed).normal(size=(200, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    for way in ways[: 200 if count <= 1000 else 20]:
        n = np.broadcast_to(way, (count, 3))
        along = (b[0] - a[0]) @ way - _reach_each(one, a[1], n) - _reach_each(two, b[1], -n)
        assert (along <= found[:, 0] + bound)[np.logical_not(apart)].all()
    if "cylinder" not in pair:
        for k in range(exact):
            r = a[1][k].T @ b[1][k]
            want = _signed_distance(one, two, a[1][k].T @ (b[0][k] - a[0][k]), r)
            assert found[k, 0] == pytest.approx(want, abs=1e-9), (pair, seed, k)


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 2**31))
def test_distance_and_depth_of_random_poses_are_exact(pair: tuple[str, str], seed: int) -> None:
    """Polytopes agree with a quadratic program and with the facets of A - B; round shapes carry a certificate."""
    _check(pair, seed, 100, 8)


@pytest.mark.slow
@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_distance_and_depth_of_1e5_poses_are_exact(pair: tuple[str, str]) -> None:
    """As above, for 1e5 poses of each pair."""
    _check(pair, 5, 100_000, 500)


@pytest.mark.parametrize("ratio", [1.0, 1e-3])
@pytest.mark.parametrize("gap", [1e-6, 0.0, -1e-6, -0.02])
@pytest.mark.parametrize("turn", [0.0, math.pi / 4, 0.3])
def test_faces_edges_and_corners_that_just_touch_have_their_exact_gap(turn: float, gap: float, ratio: float) -> None:
    """A cube on the face of another, turned about z so that edges are parallel or cross; one may be a thousandth of the other.

    The depth is at most a fifth of the half extent, so up is the shortest way out.
    """
    small = engine.ConvexHull((CUBE * ratio).tolist())
    big = engine.ConvexHull(CUBE.tolist())
    depth = gap * ratio
    here = (np.zeros((1, 3)), np.eye(3)[None])
    there = (np.array([[0.0, 0.0, 0.1 + 0.1 * ratio + depth]]), Rotation.from_rotvec([0, 0, turn]).as_matrix()[None])
    found = _measure(big, small, here, there)[0]
    assert found[0] == pytest.approx(depth, abs=1e-13)
    if depth <= 0:
        assert found[1:4] == pytest.approx([0, 0, 1], abs=1e-9)


def test_shapes_with_one_centre_part_along_their_shortest_way() -> None:
    """Two cubes of half extent .1 at one place are .2 deep; two cylinders of radius .2 and half length .15 are .3 deep."""
    here = (np.zeros((1, 3)), np.eye(3)[None])
    cube = engine.ConvexHull(CUBE.tolist())
    assert _measure(cube, cube, here, here)[0, 0] == pytest.approx(-0.2, abs=1e-14)
    assert _measure(SHAPES["cylinder"], SHAPES["cylinder"], here, here)[0, 0] == pytest.approx(-0.3, abs=1e-9)


# A shape, its half height along z when upright, and the points of contact that its lower face makes.
UPRIGHT: dict[str, tuple[engine.Shape, float, int]] = {
    "sphere": (engine.Sphere(0.1), 0.1, 1),
    "capsule": (engine.Capsule(0.05, 0.05), 0.1, 1),
    "box": (engine.Box((0.1, 0.1, 0.1)), 0.1, 4),
    "cylinder": (engine.Cylinder(0.1, 0.1), 0.1, 4),
    "hull": (engine.ConvexHull(CUBE.tolist()), 0.1, 4),
}
BLOCK_FACES = [
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7),
    (1, 7, 3),
]  # fmt: skip
BLOCK = engine.TriangleMesh((CUBE * (5, 5, 1)).tolist(), BLOCK_FACES)


@pytest.mark.parametrize("lower", [*UPRIGHT, "mesh", "plane"])
@pytest.mark.parametrize("upper", [*UPRIGHT])
@pytest.mark.parametrize("depth", [1e-3, 0.0, -5e-4])
@pytest.mark.parametrize("swapped", [False, True])
def test_every_pair_has_a_manifold_with_its_normal_from_a_to_b(upper: str, lower: str, depth: float, swapped: bool) -> None:
    """One shape stands on another: the normal is z, the gap minus the depth, and all points lie halfway between the surfaces.

    Half a millimetre apart there is contact too: the margin is one.
    """
    shape, half, points = UPRIGHT[upper]
    under: tuple[engine.Shape, float, int] = (BLOCK, 0.1, 9) if lower == "mesh" else (engine.Plane(), 0.0, 9)
    under = UPRIGHT.get(lower, under)
    bodies = [
        engine.Body(name="under", motion="static", shapes=[engine.Placed(under[0])]),
        engine.Body(name="over", shapes=[engine.Placed(shape)], p_WB=(0.003, 0.002, under[1] + half - depth)),
    ]
    world = engine.World(bodies[::-1] if swapped else bodies, gravity=(0, 0, 0), options=engine.Options(dt=1e-9))
    world.step()
    contacts = world.contacts()
    if {upper, lower} == {"sphere", "capsule"} or (lower in ("sphere", "capsule") and upper in ("sphere", "capsule")):
        assert len(contacts.gap) == 1
        return
    assert len(contacts.gap) >= min(points, under[2])
    way = np.where(contacts.bodies[:, 0] == (1 if swapped else 0), 1.0, -1.0)
    assert contacts.normal * way[:, None] == pytest.approx(np.tile([0, 0, 1], (len(way), 1)), abs=0.06)
    flat = under[2] > 1 and points > 1
    assert contacts.gap == pytest.approx(-depth, abs=1e-12 if flat else 1.5e-4)
    assert contacts.point[:, 2] == pytest.approx(under[1] - depth / 2, abs=1e-12 if flat else 1.5e-4)
    if flat:
        assert np.ptp(contacts.point[:, 0]) > 0.15
        assert np.ptp(contacts.point[:, 1]) > 0.15


def test_balls_of_unlike_size_touch_between_their_surfaces() -> None:
    """Radii .3 and .1, centres .4 apart less a depth of 1 mm: the point lies half a millimetre inside of either ball.

    Alone, in a world of spheres, and where a box elsewhere makes it one of all shapes.
    """
    box = engine.Body(name="box", shapes=[engine.Placed(engine.Box((0.1, 0.1, 0.1)))], p_WB=(5, 0, 0))
    small = engine.Body(name="small", shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0, 0, 0.4 - 1e-3))
    large = engine.Body(name="large", motion="static", shapes=[engine.Placed(engine.Sphere(0.3))])
    for bodies in ([large, small], [small, large], [large, small, box], [small, large, box]):
        world = engine.World(bodies, gravity=(0, 0, 0), options=engine.Options(dt=1e-9))
        world.step()
        contacts = world.contacts()
        assert contacts.gap == pytest.approx([-1e-3], abs=1e-12)
        assert contacts.point[0] == pytest.approx([0, 0, 0.3 - 5e-4], abs=1e-12)


def test_rays_hit_a_hull_of_a_box_where_they_hit_the_box() -> None:
    """The closed form of the box is the oracle: distance to 1e-12 of the way, the normal but for sign to rounding."""
    q = Rotation.random(random_state=3).as_quat(scalar_first=True)
    placed = {"p_BS": (0.1, -0.2, 0.3), "q_BS": (0.5, 0.5, -0.5, 0.5)}
    corners = list(itertools.product((-0.3, 0.3), (-0.2, 0.2), (-0.1, 0.1)))
    way, turns = _poses(4, 3000, 1.0)
    hits = [
        engine.World([engine.Body(shapes=[engine.Placed(shape, **placed)], p_WB=(1, 2, 3), q_WB=q)]).cast(
            np.array([1, 2, 3]) + way, turns[:, 0]
        )
        for shape in (engine.Box((0.3, 0.2, 0.1)), engine.ConvexHull(corners))
    ]
    assert np.isfinite(hits[0].distance).sum() > 100
    assert (np.isfinite(hits[0].distance) == np.isfinite(hits[1].distance)).all()
    met = np.isfinite(hits[0].distance)
    assert hits[1].distance[met] == pytest.approx(hits[0].distance[met], abs=1e-12)
    assert hits[1].normal == pytest.approx(hits[0].normal, abs=1e-12)
    assert (hits[1].shape == hits[0].shape).all()


def test_rays_hit_a_mesh_where_brute_force_over_its_triangles_does() -> None:
    """The oracle solves o + t d = a + u (b - a) + v (c - a) for every triangle."""
    corners = Quickhull(ROCK)
    faces = [f if np.dot(np.cross(ROCK[f[1]] - ROCK[f[0]], ROCK[f[2]] - ROCK[f[0]]), e[:3]) > 0 else f[::-1]
             for f, e in zip(corners.simplices.tolist(), corners.equations, strict=True)]  # fmt: skip
    mesh = engine.TriangleMesh(ROCK.tolist(), faces)
    first = engine.Placed(engine.Sphere(0.01), p_BS=(50, 0, 0))
    way, turns = _poses(9, 2000, 1.0)
    hits = engine.World([engine.Body(motion="static", shapes=[first, engine.Placed(mesh)])]).cast(way, turns[:, 0])
    want = np.full(len(way), np.inf)
    for f in faces:
        a, b, c = ROCK[f]
        m = np.stack([turns[:, 0], np.broadcast_to(a - b, way.shape), np.broadcast_to(a - c, way.shape)], axis=-1)
        t, u, v = np.linalg.solve(m, (a - way)[..., None])[..., 0].T
        want = np.where((t >= 0) & (u >= 0) & (v >= 0) & (u + v <= 1) & (t < want), t, want)
    met = np.isfinite(want)
    assert met.sum() > 100
    assert (met == np.isfinite(hits.distance)).all()
    assert hits.distance[met] == pytest.approx(want[met], abs=1e-12)
    assert (hits.shape[met] == 1).all()


@pytest.mark.parametrize(("cap", "faces"), [(4, 6), (24, 26)])
def test_coplanar_facets_of_a_hull_become_one_face(cap: int, faces: int) -> None:
    """A prism of n sides has n + 2 faces, and Euler's V - E + F = 2 holds; its normals point outwards."""
    from plumbline.engine.build.polyhedra import hull_polyhedron

    angle = 2 * math.pi * np.arange(cap) / cap
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.concatenate([np.column_stack([ring, np.full(cap, z)]) for z in (-0.5, 0.5)])
    made = hull_polyhedron(points @ Rotation.random(random_state=1).as_matrix().T)
    assert len(made.loops) == faces
    assert len(made.vertices) - sum(len(loop) for loop in made.loops) // 2 + len(made.loops) == 2
    for n, loop in zip(made.normals, made.loops, strict=True):
        ring3 = made.vertices[list(loop)]
        assert np.dot(np.cross(ring3[1] - ring3[0], ring3[2] - ring3[1]), n) > 0
        assert ((made.vertices - ring3[0]) @ n).max() < 1e-12
