"""Rays, cast by DART's own detector in a group of its own."""

import numpy as np

from adapters.dart.built import Built
from adapters.dart.vendor import body_of
from harness.adapter import Unsupported
from harness.adapter.what_goes_in import check_rays
from harness.scene import Ellipsoid
from harness.trajectory import Floats, Hits, Integers

__all__ = ["LONGEST_RAY", "Caster"]

LONGEST_RAY = 1e9
"""A ray is a segment in DART [m]; beyond this its fraction loses the millimetre."""


class Caster:
    """All shapes of a world, to be met by rays."""

    def __init__(self, built: Built) -> None:
        self._collision, self._any = built.dart.collision, bool(built.shapes)
        self._round = [b.name for b in built.scene.bodies if any(isinstance(p.shape, Ellipsoid) for p in b.collision)]
        self._group = self._collision.DARTCollisionDetector().createCollisionGroup()
        for node in built.shapes:
            self._group.addShapeFrame(node)

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hit of each ray within max_range [m]. Args: origins, directions: (n, 3), m and 1, in W.

        Raises: ValueError, Unsupported.
        """
        check_rays(origins, directions, max_range)
        if self._round:
            raise Unsupported(
                f"rays on the ellipsoid of body '{self._round[0]}'", "DART's own detector meets a polyhedron in its place"
            )
        if max_range > LONGEST_RAY:
            raise ValueError(f"cast: max_range {max_range} m, expected at most {LONGEST_RAY:g}")
        distance: Floats = np.full(len(origins), np.inf)
        body: Integers = np.full(len(origins), -1, dtype=np.int64)
        normal: Floats = np.zeros((len(origins), 3))
        option = self._collision.RaycastOption(False, True)
        for r, (start, end) in enumerate(zip(origins, origins + max_range * directions, strict=True)):
            result = self._collision.RaycastResult()
            if self._any and self._group.raycast(start, end, option, result):
                hit = result.mRayHits[0]
                distance[r] = max(hit.mFraction * max_range, 0.0)
                body[r] = body_of(hit.mCollisionObject)
                normal[r] = hit.mNormal
        return Hits(distance, body, normal)
