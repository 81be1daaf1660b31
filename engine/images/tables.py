"""What compiled code is told about the optics of bodies and the sun."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.optics import Sun
from plumbline.engine.maths.arrays import unit
from plumbline.engine.maths.types import Floats


class Lighting(NamedTuple):
    """Terms:

    optics (bodies, 6): colour, mirror, transmission, refractive index; sun (1, 5): unit vector to the sun, irradiance, radiance
    of the sky.
    """

    optics: Floats
    sun: Floats


def lighting_of(bodies: Sequence[Body], sun: Sun) -> Lighting:
    """What surfaces do to light, and where it comes from."""
    rows = [(*one.optics.colour, one.optics.mirror, one.optics.transmission, one.optics.refractive_index) for one in bodies]
    towards = np.asarray(sun.towards_W, float)
    return Lighting(np.array(rows, float).reshape(-1, 6), np.array([[*unit(towards), sun.irradiance, sun.sky]]))
