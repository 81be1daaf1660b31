"""Two triangles meet where an edge of one meets the other: every answer against that, worked out in whole numbers.

Of two in one plane, or of one without an area, the engine says that they are flat, and not whether they meet.

Corners are whole numbers here, divided by a power of two before the engine sees them, so that engine and oracle are given the
same triangles to the last bit. Whole numbers of eight bits leave the engine's own products exact: touching, coplanar and
degenerate triangles have to come out as they are. With twenty bits they round, as for any other corner.
"""

import itertools
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline.engine.narrow.triangle_triangle import APART, CROSSING, EDGES_OF_B, FLAT
from tests.engine_entries import measure_triangles

Array = NDArray[np.float64]
Whole = NDArray[np.int64]
Point = tuple[int, int, int]
FINE = 20
"""Bits of a corner that the engine's products round."""
COARSE = 8
"""Bits of a corner of which no product of the engine rounds: differences have nine, and four of them make 40 of 53."""
ROUNDING = 1e-13
"""Of a point of a segment [m], beyond its conditioning: some hundred operations on numbers below 2 m."""


def _sub(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a: Point, b: Point) -> Point:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: Point, b: Point) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _flat(x: Point, drop: int) -> tuple[int, int]:
    one, two = (k for k in range(3) if k != drop)
    return x[one], x[two]


def _turn(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int]) -> int:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _segments_in_a_plane(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int], d: tuple[int, int]) -> bool:
    """Whether closed segments meet: their boxes do, and neither has the other on one side."""
    for k in range(2):
        if max(a[k], b[k]) < min(c[k], d[k]) or max(c[k], d[k]) < min(a[k], b[k]):
            return False
    return _turn(a, b, c) * _turn(a, b, d) <= 0 and _turn(c, d, a) * _turn(c, d, b) <= 0


def _segment_meets(a: Point, b: Point, t: tuple[Point, ...]) -> bool:
    """Whether a closed segment meets a closed triangle, either of them of any shape down to a point."""
    n = _cross(_sub(t[1], t[0]), _sub(t[2], t[0]))
    if n == (0, 0, 0):
        return any(_segments_meet(a, b, t[k], t[(k + 1) % 3]) for k in range(3))
    over, under = _dot(n, _sub(a, t[0])), _dot(n, _sub(b, t[0]))
    if over * under > 0:
        return False
    if over == under == 0:
        drop = max(range(3), key=lambda k: abs(n[k]))
        corners, p, q = [_flat(x, drop) for x in t], _flat(a, drop), _flat(b, drop)
        if any(_segments_in_a_plane(p, q, corners[k], corners[(k + 1) % 3]) for k in range(3)):
            return True
        turns = [_turn(corners[k], corners[(k + 1) % 3], p) for k in range(3)]
        return min(turns) >= 0 or max(turns) <= 0
    x = _crossing(a, b, over, under)
    sides = [_dot(_cross(_sub(t[(k + 1) % 3], t[k]), tuple(x[c] - t[k][c] for c in range(3))), n) for k in range(3)]  # type: ignore[arg-type]
    return min(sides) >= 0


def _crossing(a: Point, b: Point, over: int, under: int) -> tuple[Fraction, Fraction, Fraction]:
    share = Fraction(over, over - under)
    return tuple(a[c] + share * (b[c] - a[c]) for c in range(3))  # type: ignore[return-value]


def _segments_meet(a: Point, b: Point, c: Point, d: Point) -> bool:
    """As `_segments_in_a_plane`, in space: in a plane of theirs, seen along two axes where they lie in no one plane."""
    if _dot(_cross(_sub(b, a), _sub(c, a)), _sub(d, a)) != 0:
        return False
    return all(_segments_in_a_plane(*(_flat(x, drop) for x in (a, b, c, d))) for drop in range(3))


def _meet(a: tuple[Point, ...], b: tuple[Point, ...]) -> bool:
    """Brute force: every edge of each against the other."""
    return any(_segment_meets(s[k], s[(k + 1) % 3], t) for s, t in ((a, b), (b, a)) for k in range(3))


def _flat_pair(a: tuple[Point, ...], b: tuple[Point, ...]) -> bool:
    """Whether all corners of one lie in the plane of the other, or the other has no area."""
    return any(
        all(_dot(_cross(_sub(t[1], t[0]), _sub(t[2], t[0])), _sub(x, t[0])) == 0 for x in s) for s, t in ((a, b), (b, a))
    )


def _corners(whole: Whole) -> tuple[Point, ...]:
    return tuple((int(x), int(y), int(z)) for x, y, z in whole)


def _answers(one: Whole, two: Whole, bits: int) -> tuple[Whole, Array]:
    """The engine's answers to pairs (n, 3, 3) of whole corners, divided by 2^bits."""
    kind, ends = np.zeros((len(one), 3), np.int64), np.zeros((len(one), 6))
    measure_triangles(one.reshape(-1, 9) / 2.0**bits, two.reshape(-1, 9) / 2.0**bits, kind, ends)
    return kind, ends


def _anywhere(count: int, seed: int) -> tuple[Whole, Whole]:
    """Triangles of any shape in a cube, the second moved off by as much: a third of them meet."""
    rng = np.random.default_rng(seed)
    size = 1 << FINE
    one, two = rng.integers(-size, size, (2, count, 3, 3))
    return one, two + rng.integers(-size // 2, size // 2, (count, 1, 3))


def _on_a_lattice(count: int, seed: int) -> tuple[Whole, Whole]:
    """Corners of few values: common corners and edges, common planes, segments and points."""
    rng = np.random.default_rng(seed)
    one, two = rng.integers(-1, 3, (2, count, 3, 3))
    return one, two


def _in_a_plane(count: int, seed: int) -> tuple[Whole, Whole]:
    """Triangles in one plane of any tilt; every seventh is a segment."""
    rng = np.random.default_rng(seed)
    span = rng.integers(-3, 4, (count, 2, 3))
    one, two = (np.einsum("nij,njk->nik", rng.integers(-5, 6, (count, 3, 2)), span) for _ in range(2))
    one[::7, 2] = one[::7, 1]
    return one, two


def _touching(count: int, seed: int) -> tuple[Whole, Whole]:
    """A corner of the second on a corner, an edge or the face of the first, or beside it by the least there is."""
    rng = np.random.default_rng(seed)
    share = np.array(
        [(4, 0, 0), (2, 2, 0), (1, 3, 0), (2, 1, 1), (1, 1, 2), (0, 4, 0), (0, 1, 3), (1, 2, 1)]
    )  # of the corners, in quarters
    one, two = 4 * rng.integers(-8, 9, (2, count, 3, 3))
    two[:, 0] = np.einsum("nk,nkc->nc", share[rng.integers(0, len(share), count)], one) // 4
    two[::2] += rng.integers(-1, 2, (len(two[::2]), 1, 3))
    return one, two


FAMILIES = {
    "anywhere": (_anywhere, FINE),
    "on a lattice": (_on_a_lattice, 0),
    "in a plane": (_in_a_plane, COARSE),
    "touching": (_touching, COARSE),
}
FEW, MANY = 500, 25_000


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
def test_triangles_meet_where_an_edge_of_one_meets_the_other(name: str, count: int) -> None:
    """10^5 pairs in all; both answers are common in every family."""
    make, bits = FAMILIES[name]
    one, two = make(count, seed=3)
    kind, _ = _answers(one, two, bits)
    expected = np.array([_meet(_corners(a), _corners(b)) for a, b in zip(one, two, strict=True)])
    assert 0.1 < expected.mean() < 0.98
    wrong = np.flatnonzero((kind[:, 0] != FLAT) & ((kind[:, 0] == CROSSING) != expected))
    assert len(wrong) == 0, f"{len(wrong)} pairs, the first {one[wrong[0]].tolist()} {two[wrong[0]].tolist()}"
    flat = np.array([_flat_pair(_corners(a), _corners(b)) for a, b in zip(one, two, strict=True)])
    assert not (flat & (kind[:, 0] == CROSSING)).any()
    assert not (~flat & (kind[:, 0] == FLAT)).any()
    assert not (expected & flat & (kind[:, 0] == APART)).any()


def test_the_order_of_triangles_and_of_their_corners_decides_nothing() -> None:
    for make, bits in FAMILIES.values():
        one, two = make(300, seed=5)
        told = _answers(one, two, bits)[0][:, 0]
        assert np.array_equal(told, _answers(two, one, bits)[0][:, 0])
        for turn in itertools.permutations(range(3)):
            assert np.array_equal(told, _answers(one[:, turn], two, bits)[0][:, 0])


def test_the_segment_is_all_that_two_triangles_have_in_common() -> None:
    """Every exact crossing of an edge with the other triangle lies on it, its ends are two of them, on the edges it names."""
    one, two = _anywhere(3 * FEW, seed=8)
    kind, ends = _answers(one, two, FINE)
    edges = Counter[int]()
    for a, b, (met, begins, stops), told in zip(one, two, kind, ends, strict=True):
        if met != CROSSING:
            continue
        found: dict[int, Array] = {}
        for first, s, t in ((0, _corners(a), _corners(b)), (EDGES_OF_B, _corners(b), _corners(a))):
            n = _cross(_sub(t[1], t[0]), _sub(t[2], t[0]))
            for k in range(3):
                p, q = s[k], s[(k + 1) % 3]
                if _segment_meets(p, q, t):
                    x = _crossing(p, q, _dot(n, _sub(p, t[0])), _dot(n, _sub(q, t[0])))
                    found[first + k] = np.array([float(c) for c in x]) / 2.0**FINE
        assert set(found) == {int(begins), int(stops)}
        edges.update(found.keys())
        # An edge that meets a plane at a sine s makes of a height's rounding 1 / s of it along itself.
        sine = min(_sine(a, b, int(edge)) for edge in found)
        assert np.abs(found[int(begins)] - told[:3]).max() <= ROUNDING / sine
        assert np.abs(found[int(stops)] - told[3:]).max() <= ROUNDING / sine
    assert len(edges) == 6
    assert min(edges.values()) > 50


def _sine(a: Whole, b: Whole, edge: int) -> float:
    """Between an edge and the plane of the other triangle."""
    own, other = (a, b) if edge < EDGES_OF_B else (b, a)
    e = (own[(edge % 3 + 1) % 3] - own[edge % 3]).astype(float)
    n = np.cross(*(other[k] - other[0] for k in (1, 2))).astype(float)
    return float(abs(e @ n) / (np.linalg.norm(e) * np.linalg.norm(n)))


def _told(one: object, two: object) -> tuple[int, Array]:
    kind, ends = _answers(np.array([one]), np.array([two]), 0)
    return int(kind[0, 0]), ends[0]


LEVEL = ((0, 0, 0), (4, 0, 0), (0, 4, 0))


@pytest.mark.parametrize(
    ("other", "met"),
    [
        (((1, 1, 0), (1, 1, 2), (2, 1, 2)), CROSSING),  # a corner on the face
        (((0, 0, 0), (0, 0, 2), (-1, 0, 2)), CROSSING),  # a corner in common
        (((2, 2, -1), (2, 2, 1), (5, 5, 1)), CROSSING),  # an edge through an edge
        (((0, 0, 0), (4, 0, 0), (0, 0, 4)), CROSSING),  # an edge in common
        (((1, 1, 0), (2, 1, 0), (1, 2, 0)), FLAT),  # the other within
        (((4, 0, 0), (6, 0, 0), (4, 3, 0)), FLAT),  # a corner in common, in one plane
        (((3, 3, 0), (6, 3, 0), (3, 6, 0)), FLAT),  # beside each other in one plane
        (((1, 1, 1), (2, 1, 1), (1, 2, 1)), APART),  # parallel
        (((1, 1, -1), (1, 1, 1), (1, 1, 1)), FLAT),  # a segment through the face
        (((3, 3, -1), (3, 3, 1), (3, 3, 1)), FLAT),  # one that passes by
        (((1, 1, 0), (1, 1, 0), (1, 1, 0)), FLAT),  # a point on the face
        (((1, 1, 1), (1, 1, 1), (1, 1, 1)), APART),  # a point over it
        (((2, 0, 0), (3, 0, 0), (1, 0, 0)), FLAT),  # a segment along an edge
    ],
)
def test_triangles_that_touch_lie_in_one_plane_or_have_no_area(other: object, met: int) -> None:
    assert _told(LEVEL, other)[0] == met
    assert _told(other, LEVEL)[0] == met


def test_a_triangle_stands_on_another_along_a_segment() -> None:
    met, ends = _told(LEVEL, ((1, 1, -2), (1, 1, 2), (9, 1, 0)))
    assert met == CROSSING
    assert sorted(ends[[0, 3]]) == [1.0, 3.0]
    assert ends[[1, 2, 4, 5]].tolist() == [1.0, 0.0, 1.0, 0.0]
