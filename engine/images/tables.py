"""What compiled code is told about the optics of bodies and the sun."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.describe.bodies import Body
from engine.describe.optics import Sun

__all__ = ["optics_table", "sun_row"]

FloatArray = NDArray[np.float64]


def optics_table(bodies: Sequence[Body]) -> FloatArray:
    """(bodies, 6): colour, mirror, transmission, refractive index."""
    rows = [(*one.optics.colour, one.optics.mirror, one.optics.transmission, one.optics.refractive_index) for one in bodies]
    return np.array(rows, float).reshape(-1, 6)


def sun_row(sun: Sun) -> FloatArray:
    """(1, 5): unit vector to the sun, irradiance, radiance of the sky."""
    towards = np.asarray(sun.towards_W, float)
    return np.array([[*(towards / np.linalg.norm(towards)), sun.irradiance, sun.sky]])
