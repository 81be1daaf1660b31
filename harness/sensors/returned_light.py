"""Light of an active depth camera that comes back from a surface, and the sunlight beside it.

Unit: what a white surface sends back that faces the camera at 1 m. A surface scatters diffusely (Lambert) the share that it
neither mirrors nor lets through, so that its light goes with the cosine of the angle of incidence over the squared range; what
is mirrored or enters does not come back. The sun's light on the same surface is scattered with the same share, which falls out
of their ratio.

Source: Lange, 3D Time-of-Flight Distance Measurement (2000), chapter 4 (optical power budget); Gupta, Yin, Nayar, Structured
Light in Sunlight, ICCV 2013 (contrast against ambient light).
"""

import numpy as np

from plumbline.harness.sensors.second_view import sunlit
from plumbline.harness.sensors.sight import Mask, Sight
from plumbline.harness.trajectory import Floats


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
