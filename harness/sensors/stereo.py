"""Stereo: two cameras match the texture of surfaces, and what only one of them sees has no match.

Invalid are points that the second camera does not see, surfaces that scatter less than `least_texture` of the light themselves
(a mirror shows the texture of other things, at other depths), and surfaces too steep for a window of pixels to match.

Source: Scharstein and Szeliski, A Taxonomy and Evaluation of Dense Two-Frame Stereo Correspondence Algorithms, IJCV 47 (2002) 7
(occlusion, windows); the error of depth: see `triangulation`.
"""

from plumbline.harness.scene import StereoNoise
from plumbline.harness.sensors.returned_light import in_view_of, scattered
from plumbline.harness.sensors.sight import Mask, Sight
from plumbline.harness.sensors.triangulation import through_disparity, too_steep
from plumbline.harness.trajectory import Floats


def lost(noise: StereoNoise, sight: Sight) -> Mask:
    """Which measurable pixels are invalid by geometry and optics, (r,). Raises: Unsupported."""
    texture = scattered(sight)
    invalid: Mask = sight.measurable & ((texture <= 0.0) | (texture < noise.least_texture))
    if noise.occlusion:
        invalid |= sight.measurable & ~in_view_of(sight, noise.baseline)
    return invalid | too_steep(sight, noise.steepest)


def answer(noise: StereoNoise, sight: Sight, normal: Floats) -> Floats:
    """z-depth [m] of all pixels as if all were valid, (r,), from standard normal deviates (r,)."""
    return through_disparity(sight, noise.baseline, noise.disparity_sigma, noise.disparity_step, normal)
