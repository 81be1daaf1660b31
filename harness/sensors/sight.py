"""One frame of a depth camera before any noise: what each pixel's ray meets, and the geometry of that point.

Light of an active depth camera that comes back from a surface, and the sunlight beside it.

Unit: what a white surface sends back that faces the camera at 1 m. A surface scatters diffusely (Lambert) the share that it
neither mirrors nor lets through, so that its light goes with the cosine of the angle of incidence over the squared range; what
is mirrored or enters does not come back. The sun's light on the same surface is scattered with the same share, which falls out
of their ratio.

Source: Lange, 3D Time-of-Flight Distance Measurement (2000), chapter 4 (optical power budget); Gupta, Yin, Nayar, Structured
Light in Sunlight, ICCV 2013 (contrast against ambient light).

What a second eye beside a depth camera sees of the points that the camera sees: the other camera, the projector, the sun.

A point is hidden from an eye where a ray from the eye towards it ends short of it by more than SLACK of the way. That much,
1 mm at 1 m, covers rays of engines that err by millimetres on curved shapes; what stands closer than that before a point casts
no shadow on it.
"""

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


SLACK = 1e-3
SUN_REACH = 1e3
"""How far [m] a thing may stand and still cast a shadow."""


def in_view_of(sight: Sight, baseline: float) -> Mask:
    """Which measurable pixels' points a like and parallel camera at (baseline, 0, 0) in S sees, hidden by nothing, (r,)."""
    measurable = sight.measurable
    seen = measurable.copy()
    eye_W = sight.p_WS + rotate(sight.q_WS, np.array([baseline, 0.0, 0.0]))
    towards = sight.point_W[measurable] - eye_W
    away = np.linalg.norm(towards, axis=1)
    if not len(away):
        return seen
    hits = sight.cast(np.broadcast_to(eye_W, towards.shape).copy(), towards / away[:, None], float(away.max()))
    seen[measurable] = (hits.distance >= (1.0 - SLACK) * away) & _in_frame(sight, baseline)[measurable]
    return seen


def _in_frame(sight: Sight, baseline: float) -> Mask:
    """Does the point fall on the second camera's picture? Rows are those of the first; columns move by the disparity."""
    camera = sight.camera
    depth = np.where(sight.measurable, sight.depth, np.inf)
    across = np.tile(np.arange(camera.width) + 0.5, camera.height) - camera.focal_x * baseline / depth
    return (across >= 0.0) & (across < camera.width)


def lifted(sight: Sight) -> Floats:
    """The points of all pixels, lifted off their surfaces by SLACK of the range, (r, 3) m. Raises: Unsupported."""
    along = np.where(sight.measurable, sight.range, 0.0)
    raised: Floats = sight.point_W + SLACK * along[:, None] * sight.facing_W
    return raised


def sunlit(sight: Sight) -> Floats:
    """Irradiance by the sun over that of a surface facing it, (r,): the cosine to it, 0 in a shadow. Raises: Unsupported."""
    towards_W = np.array(sight.scene.sun.towards_W)
    cosine: Floats = np.maximum(sight.facing_W @ towards_W, 0.0)
    asked = sight.measurable & (cosine > 0.0)
    cosine = np.where(asked, cosine, 0.0)
    if asked.any():
        directions = np.broadcast_to(towards_W, (int(asked.sum()), 3)).copy()
        hits = sight.cast(lifted(sight)[asked], directions, SUN_REACH)
        cosine[asked] = np.where(np.isinf(hits.distance), cosine[asked], 0.0)
    return cosine


def scattered(sight: Sight) -> Floats:
    """Share of light that the seen surface itself scatters, (r,) [1]."""
    return sight.property_of_bodies([body.appearance.scatters for body in sight.scene.bodies])


def _sent_back(sight: Sight) -> Floats:
    """Share of light, at the camera's wavelength, that the seen surface sends back, (r,)."""
    return scattered(sight) * sight.property_of_bodies([body.appearance.reflectivity for body in sight.scene.bodies])


def signal(sight: Sight) -> Floats:
    """The camera's own light that comes back, (r,) [1]; 0 where a pixel is not measurable. Raises: Unsupported."""
    reach = np.where(sight.measurable, sight.range, 1.0)
    received: Floats = np.where(sight.measurable, _sent_back(sight) * sight.cosine / np.square(reach), 0.0)
    return received


def sunlight(sight: Sight) -> Floats:
    """Sunlight that comes from the seen surface, in the unit of `signal`, (r,) [1]. Raises: Unsupported."""
    strength = sight.scene.sun.infrared
    if strength == 0.0:
        return np.zeros(len(sight.depth))
    return strength * _sent_back(sight) * sunlit(sight)


def too_faint(sight: Sight, least_signal: float, least_contrast: float) -> Mask:
    """Which measurable pixels get no light back, less than least_signal, or less than least_contrast of the sun's, (r,).

    Raises: Unsupported.
    """
    back = signal(sight)
    faint: Mask = sight.measurable & ((back <= 0.0) | (back < least_signal))
    if least_contrast > 0.0:
        faint |= sight.measurable & (back < least_contrast * sunlight(sight))
    return faint
