"""Points that fill a square evenly, the same in every run: where a pixel is sampled, and where a surface looks for the sky.

Source: Hammersley, Monte Carlo Methods for Solving Multivariable Problems, 1960; Cranley, Patterson, Randomization of Number
Theoretic Methods for Multiple Integration, 1976 (a pattern shifted for each place).
"""

import numpy as np

from plumbline.engine.maths.types import Floats


def even_points(count: int) -> Floats:
    """Points (count, 2) in the unit square whose mean is its middle; one point is the middle itself."""
    k = np.arange(count)
    mirrored, bits = np.zeros(count), max(1, int(count - 1).bit_length())
    for b in range(bits):
        mirrored += (k >> b & 1) / (1 << (b + 1))
    points = np.column_stack([(k + 0.5) / count, mirrored])
    points[:, 1] += 0.5 - points[:, 1].mean()
    return np.asarray(points % 1.0)
