"""One frame of a depth camera before any noise: what each pixel's ray meets, and the geometry of that point."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import DepthCamera, Scene
from plumbline.harness.trajectory import Floats, Hits, Integers
from plumbline.harness.trajectory.kinematics import rotate

Cast: TypeAlias = Callable[[Floats, Floats, float], Hits]
"""(origins (r, 3) m, unit directions (r, 3), max_range [m]) in W to first hits."""
Mask: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Sight:
    """What all r = height * width pixels see, row by row.

    Terms:
        cast: rays into the same instant. p_WS (3,) m, q_WS (4,): pose of the camera. ahead (r,): cosine between a pixel's ray
        and the optical axis, z-depth over range. directions_W (r, 3) unit.
        depth (r,) m: ideal z-depth, -inf nearer than `near`, +inf beyond `far` or nothing at all. body (r,): place in the
        scene, -1 for nothing up to `far`. normal_W (r, 3): outward unit normal of the surface, zero where none is known.
    """

    camera: DepthCamera
    scene: Scene
    cast: Cast
    p_WS: Floats
    q_WS: Floats
    ahead: Floats
    directions_W: Floats
    depth: Floats
    body: Integers
    normal_W: Floats

    @property
    def measurable(self) -> Mask:
        """Pixels that see something between `near` and `far`; NaN counts, so that it shows."""
        return ~np.isinf(self.depth)

    @property
    def range(self) -> Floats:
        """Distance [m] from the camera, (r,)."""
        return self.depth / self.ahead

    @property
    def point_W(self) -> Floats:
        """What is seen, (r, 3) m; the camera itself where a pixel is not measurable."""
        along = np.where(self.measurable, self.range, 0.0)
        point: Floats = self.p_WS + along[:, None] * self.directions_W
        return point

    @property
    def facing_W(self) -> Floats:
        """The normals, turned to the side that the camera is on, (r, 3).

        Raises:
            Unsupported: no normal is known of a surface that is seen.
        """
        unknown = self.measurable & ~self.normal_W.any(axis=1)
        if unknown.any():
            raise Unsupported(
                f"noise of sensor '{self.camera.name}'",
                f"it depends on the angle of incidence, and the rays of {int(unknown.sum())} pixels came back without a normal",
            )
        away = np.sum(self.normal_W * self.directions_W, axis=1) > 0
        return np.where(away[:, None], -self.normal_W, self.normal_W)

    @property
    def cosine(self) -> Floats:
        """Cosine of the angle of incidence, (r,). Raises: Unsupported, as `facing_W`."""
        cosine: Floats = -np.sum(self.facing_W * self.directions_W, axis=1)
        return cosine

    def property_of_bodies(self, values: list[float]) -> Floats:
        """One value a body, (r,), for the body that each pixel sees; 0 for nothing."""
        # The last place stands for nothing, which body -1 names.
        per_ray: Floats = np.array([*values, 0.0])[self.body]
        return per_ray


def bounded(camera: DepthCamera, depth: Floats) -> Floats:
    """The z-depth [m] with -inf below `near` and +inf above `far`; NaN stays NaN."""
    return np.where(depth < camera.near, -np.inf, np.where(depth > camera.far, np.inf, depth))


def sight_by_rays(camera: DepthCamera, scene: Scene, cast: Cast, p_WS: Floats, q_WS: Floats, directions_S: Floats) -> Sight:
    """What rays along directions_S (r, 3), one a pixel, meet; z-depth is range times the cosine to the optical axis."""
    ahead, directions_W = directions_S[:, 2], rotate(q_WS, directions_S)
    # The corner pixels' rays are the longest; an engine may cut a ray's end off by rounding, so each gets a little more.
    reach = 1.001 * camera.far / float(ahead.min())
    hits = cast(np.broadcast_to(p_WS, directions_W.shape).copy(), directions_W, reach)
    depth = bounded(camera, hits.distance * ahead)
    body = np.where(depth == np.inf, -1, hits.body)
    return Sight(camera, scene, cast, p_WS, q_WS, ahead, directions_W, depth, body, hits.normal_W)
