"""How deep solids stand in one another, against depths by hand and against a linear programme over the same solids."""

import math
import tracemalloc
from itertools import product as every

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull as Hull

from plumbline.harness.scene import Box, Capsule, ConvexHull, Cylinder, Plane, Shape, Sphere, TriangleMesh, axis_angle
from plumbline.harness.trajectory.depths import Unmeasured, depth, solid

UNTURNED = (1.0, 0.0, 0.0, 0.0)
EIGHTH = axis_angle((0.0, 1.0, 0.0), math.pi / 4)
BOX, BALL = Box(half_extents=(0.1, 0.2, 0.3)), Sphere(radius=0.1)
CAPSULE, CYLINDER = Capsule(radius=0.1, half_length=0.2), Cylinder(radius=0.1, half_length=0.2)
ROUNDING = 1e-12
"""Lengths below a metre in double precision, some hundred roundings."""

Pose = tuple[tuple[float, float, float], tuple[float, float, float, float]]


def depth_of(a: Shape, at_a: Pose, b: Shape, at_b: Pose) -> float:
    one = [np.array([part]) for part in at_a]
    other = [np.array([part]) for part in at_b]
    found = depth(solid(a), one[0], one[1], solid(b), other[0], other[1])
    assert found == pytest.approx(depth(solid(b), other[0], other[1], solid(a), one[0], one[1]), abs=ROUNDING)
    return float(found[0])


@pytest.mark.parametrize(
    ("shape", "q", "half"),
    [
        (BOX, UNTURNED, 0.3),
        (BOX, EIGHTH, math.sqrt(0.5) * (0.1 + 0.3)),
        (BALL, EIGHTH, 0.1),
        (CAPSULE, UNTURNED, 0.3),
        (CAPSULE, EIGHTH, 0.1 + math.sqrt(0.5) * 0.2),
        (CYLINDER, UNTURNED, 0.2),
        (CYLINDER, EIGHTH, math.sqrt(0.5) * (0.1 + 0.2)),
    ],
)
@pytest.mark.parametrize("height", [0.05, 0.5])
def test_a_solid_reaches_into_a_half_space_by_what_lies_lowest(
    shape: Shape, q: tuple[float, float, float, float], half: float, height: float
) -> None:
    ground = Plane(), ((3.0, 0.0, 1.0), UNTURNED)
    assert depth_of(shape, ((7.0, -2.0, 1.0 + height), q), *ground) == pytest.approx(half - height, abs=ROUNDING)


@pytest.mark.parametrize(
    ("a", "b", "at_b", "deep"),
    [
        (BOX, BOX, ((0.19, 0.0, 0.0), UNTURNED), 0.01),
        (BOX, BOX, ((0.0, 0.0, 0.55), UNTURNED), 0.05),
        # An edge that points down into a narrow face comes out aside, along the turned box's wide face.
        (BOX, BOX, ((0.0, 0.0, 0.5), EIGHTH), math.sqrt(0.5) * (0.1 + 0.3) + 0.1 - math.sqrt(0.5) * 0.5),
        (BOX, BALL, ((0.19, 0.0, 0.0), UNTURNED), 0.01),
        # Before an edge and before a corner, where no face's normal is the nearest way.
        (BOX, BALL, ((0.16, 0.26, 0.0), UNTURNED), 0.1 - math.hypot(0.06, 0.06)),
        (BOX, BALL, ((0.15, 0.25, 0.35), UNTURNED), 0.1 - math.sqrt(3) * 0.05),
        (BOX, BALL, ((0.3, 0.0, 0.0), UNTURNED), -0.1),
        # A centre within the box comes out by its nearest face.
        (BOX, BALL, ((0.08, 0.0, 0.0), UNTURNED), 0.12),
        (BALL, BALL, ((0.0, 0.15, 0.0), UNTURNED), 0.05),
        (BALL, BALL, ((0.0, 0.0, 0.0), UNTURNED), 0.2),
        (BALL, CAPSULE, ((0.0, 0.18, 0.1), UNTURNED), 0.02),
        (BALL, CAPSULE, ((0.0, 0.12, 0.36), UNTURNED), 0.0),
        (CAPSULE, CAPSULE, ((0.0, 0.15, 0.0), axis_angle((0.0, 1.0, 0.0), math.pi / 2)), 0.05),
        (CAPSULE, BOX, ((0.0, 0.0, 0.59), UNTURNED), 0.01),
    ],
)
def test_depths_by_hand(a: Shape, b: Shape, at_b: Pose, deep: float) -> None:
    assert depth_of(a, ((0.0, 0.0, 0.0), UNTURNED), b, at_b) == pytest.approx(deep, abs=ROUNDING)


def parting(p: np.ndarray, q: np.ndarray) -> float:
    """The least depth over the faces of the difference of two polyhedra, by its own convex hull: another route."""
    difference = Hull(np.array([b - a for a, b in every(p, q)]))
    return -float(np.max(difference.equations[:, 3]))


def holds(points: np.ndarray) -> bool:
    """Is the origin a mean of these points?"""
    ones = np.ones(len(points))
    return bool(linprog(0 * ones, A_eq=np.vstack((points.T, ones)), b_eq=[0, 0, 0, 1]).success)


@pytest.mark.parametrize("pairs", [24, pytest.param(60, marks=pytest.mark.slow)])
def test_polyhedra_are_as_deep_as_the_hull_of_their_difference_says(pairs: int) -> None:
    draw, deep = np.random.default_rng(7), 0
    for _ in range(pairs):
        p, q = draw.normal(size=(9, 3)), draw.normal(size=(12, 3)) + draw.normal(size=3)
        found = depth_of(
            ConvexHull(vertices=tuple(map(tuple, p.tolist()))),
            ((0.0, 0.0, 0.0), UNTURNED),
            ConvexHull(vertices=tuple(map(tuple, q.tolist()))),
            ((0.0, 0.0, 0.0), UNTURNED),
        )
        overlap = holds(np.array([b - a for a, b in every(p, q)]))
        assert (found > 0) == overlap
        if overlap:
            deep += 1
            # Hulls of a hundred points are found to 1e-12 of their size.
            assert found == pytest.approx(parting(p, q), abs=1e-9)
    assert deep >= pairs / 3


def test_what_has_no_exact_depth_says_so() -> None:
    mesh = TriangleMesh(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0)), faces=((0, 1, 2),))
    with pytest.raises(Unmeasured, match="triangle mesh"):
        solid(mesh)
    with pytest.raises(Unmeasured, match="cylinder"):
        depth_of(CYLINDER, ((0.0, 0.0, 0.0), UNTURNED), BOX, ((0.0, 0.0, 0.3), UNTURNED))


def ellipsoid(count: int, seed: int) -> ConvexHull:
    """A hull of points on an ellipsoid of 0.1, 0.12 and 0.08 m, all of them corners."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points *= np.array([0.1, 0.12, 0.08]) / np.linalg.norm(points, axis=1)[:, None]
    return ConvexHull(vertices=tuple(map(tuple, points.tolist())))


def flying(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Poses in each other's reach, the first ten of them unturned and square to each other, the first one within."""
    draw = np.random.default_rng(seed)
    p, q = draw.normal(size=(count, 3)) * 0.12, draw.normal(size=(count, 4))
    p[0], p[1:10] = 0.0, np.round(p[1:10], 1)
    q[:10] = UNTURNED
    return p, q / np.linalg.norm(q, axis=1)[:, None]


CUBE = ConvexHull(vertices=tuple(every((-0.1, 0.1), repeat=3)))
PRISM = ConvexHull(
    vertices=tuple(
        (0.1 * math.cos(k * math.pi / 8), 0.1 * math.sin(k * math.pi / 8), z) for k in range(16) for z in (-0.2, 0.2)
    )
)


@pytest.mark.parametrize(
    ("a", "b"), [(CUBE, CUBE), (CUBE, PRISM), (PRISM, PRISM), (ellipsoid(30, 1), BOX), (ellipsoid(24, 2), PRISM)]
)
def test_the_difference_grown_from_within_is_as_deep_as_all_pairs_of_edges_say(
    monkeypatch: pytest.MonkeyPatch, a: Shape, b: Shape
) -> None:
    p, q = flying(40, 3)
    still, unturned = np.zeros_like(p), np.tile(UNTURNED, (len(p), 1))
    monkeypatch.setattr("plumbline.harness.trajectory.depths.FEW", 2**60)
    edges = depth(solid(a), still, unturned, solid(b), p, q)
    monkeypatch.setattr("plumbline.harness.trajectory.depths.FEW", 0)
    grown = depth(solid(a), still, unturned, solid(b), p, q)
    deep = edges > 1e-12
    assert deep.sum() >= 10
    assert (grown > 1e-12).tolist() == deep.tolist()
    assert grown[deep] == pytest.approx(edges[deep], abs=1e-9)


@pytest.mark.parametrize("count", [150, 500])
def test_two_hulls_of_many_corners_are_measured_in_little_memory(count: int) -> None:
    a, b = solid(ellipsoid(count, 1)), solid(ellipsoid(count, 2))
    p, q = flying(30, 4)
    tracemalloc.start()
    deep = depth(a, np.zeros_like(p), np.tile(UNTURNED, (len(p), 1)), b, p, q)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert (deep > 0).any()
    # The bound of the promise is 200 MB a process; all pairs of edges of two hulls of 150 asked for 12 GiB.
    assert most < 50 * 2**20


def test_a_ball_in_a_hull_of_many_corners_is_measured_in_little_memory() -> None:
    p, q = flying(30, 5)
    tracemalloc.start()
    deep = depth(solid(BALL), np.zeros_like(p), np.tile(UNTURNED, (len(p), 1)), solid(ellipsoid(500, 1)), p, q)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert (deep > 0).any()
    assert most < 200 * 2**20
