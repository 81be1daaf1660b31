"""How deep two polyhedra of many corners stand in one another: their difference, grown from within.

The depth is the distance from the origin to the nearest face of D = {a - b}. The hull of some points of D lies within it, so
that its own nearest face is no farther; how far D goes along that face's normal is no nearer. The corner of D that lies there
is added to the points, again and again, until the two meet; a body that hardly moved begins with the corners that its last pose
ended with.
What is sought are the few faces near the origin: neither all pairs of edges nor all of their memory.
Source: van den Bergen, Proximity Queries and Penetration Depth Computation on 3D Game Objects (2001), section 4.
"""

from itertools import product as every

import numpy as np

from plumbline.harness.trajectory import Floats, Integers

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
