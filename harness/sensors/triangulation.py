"""Depth from disparity: noise and quantisation of the disparity, and what they make of the depth.

A point at depth z appears in two views, `baseline` b apart, at columns that differ by the disparity d = f b / z. An error of
sigma_d pixels makes sigma_z = z^2 / (f b) sigma_d of depth, to first order. The disparity is disturbed, then rounded to the
nearest multiple of its step; what is left without a positive disparity lies too far (+inf).

Source: Khoshelham and Elberink, Sensors 12 (2012) 1437, equations 5 and 6; Gallup et al., Variable Baseline/Resolution Stereo,
CVPR 2008, equation 2.
"""

import numpy as np

from plumbline.harness.sensors.sight import Mask, Sight
from plumbline.harness.trajectory import Floats


def through_disparity(sight: Sight, baseline: float, sigma: float, step: float, normal: Floats) -> Floats:
    """z-depth [m] read off disturbed disparities, (r,), infinite where the ideal one is.

    Args:
        baseline: [m]. sigma, step: of the disparity [px]. normal: standard normal deviates, shape (r,).
    """
    if sigma == 0.0 and step == 0.0:
        return sight.depth
    measurable = sight.measurable
    scale = sight.camera.focal_x * baseline
    disparity = scale / np.where(measurable, sight.depth, 1.0) + sigma * normal
    if step > 0.0:
        disparity = step * np.rint(disparity / step)
    with np.errstate(divide="ignore"):
        depth = np.where(disparity <= 0.0, np.inf, scale / disparity)
    return np.where(measurable, depth, sight.depth)


def too_steep(sight: Sight, steepest: float) -> Mask:
    """Which measurable pixels see their surface at an angle of incidence above `steepest` [rad], (r,). Raises: Unsupported."""
    if steepest >= np.pi / 2:
        return np.zeros(len(sight.depth), dtype=np.bool_)
    steep: Mask = sight.measurable & (sight.cosine < np.cos(steepest))
    return steep
