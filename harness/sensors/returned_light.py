"""Light of an active depth camera that comes back from a surface, and the sunlight beside it.

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

import numpy as np

from plumbline.harness.sensors.sight import Mask, Sight
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import rotate

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
