"""Depth by triangulation: two cameras match the texture of surfaces (stereo), or a camera finds the pattern of a projector
(structured light).

A point at depth z appears in two views, `baseline` b apart, at columns that differ by the disparity d = f b / z. An error of
sigma_d pixels makes sigma_z = z^2 / (f b) sigma_d of depth, to first order. The disparity is disturbed, then rounded to the
nearest multiple of its step; what is left without a positive disparity lies too far (+inf).

Invalid are points that the second camera or the projector does not see, and surfaces too steep for a window of pixels or of the
pattern to match. For stereo, so are surfaces that scatter less than `least_texture` of the light themselves (a mirror shows the
texture of other things, at other depths); for structured light, what sends back too little of the pattern (dark, far, mirrors,
glass), or too little of it beside sunlight.

Source: Khoshelham and Elberink, Accuracy and Resolution of Kinect Depth Data for Indoor Mapping Applications, Sensors 12 (2012)
1437, section 3, equations 5 and 6; Gallup et al., Variable Baseline/Resolution Stereo, CVPR 2008, equation 2; Scharstein and
Szeliski, A Taxonomy and Evaluation of Dense Two-Frame Stereo Correspondence Algorithms, IJCV 47 (2002) 7 (occlusion, windows);
light: see `returned_light`.
"""

import numpy as np

from plumbline.harness.scene import StereoNoise, StructuredLightNoise
from plumbline.harness.sensors.sight import Mask, Sight, in_view_of, scattered, too_faint
from plumbline.harness.trajectory import Floats


def lost(noise: StereoNoise | StructuredLightNoise, sight: Sight) -> Mask:
    """Which measurable pixels are invalid by geometry and optics, (r,). Raises: Unsupported."""
    if isinstance(noise, StereoNoise):
        texture, hides = scattered(sight), noise.occlusion
        invalid: Mask = sight.measurable & ((texture <= 0.0) | (texture < noise.least_texture))
    else:
        invalid, hides = too_faint(sight, noise.least_signal, noise.least_contrast), noise.shadow
    if hides:
        invalid |= sight.measurable & ~in_view_of(sight, noise.baseline)
    if noise.steepest < np.pi / 2:
        invalid |= sight.measurable & (sight.cosine < np.cos(noise.steepest))
    return invalid


def answer(noise: StereoNoise | StructuredLightNoise, sight: Sight, normal: Floats) -> Floats:
    """z-depth [m] of all pixels as if all were valid, read off disturbed disparities, (r,), infinite where the ideal one is.

    Args: normal: standard normal deviates, shape (r,).
    """
    sigma, step = noise.disparity_sigma, noise.disparity_step
    if sigma == 0.0 and step == 0.0:
        return sight.depth
    measurable = sight.measurable
    scale = sight.camera.focal_x * noise.baseline
    disparity = scale / np.where(measurable, sight.depth, 1.0) + sigma * normal
    if step > 0.0:
        disparity = step * np.rint(disparity / step)
    with np.errstate(divide="ignore"):
        depth = np.where(disparity <= 0.0, np.inf, scale / disparity)
    return np.where(measurable, depth, sight.depth)
