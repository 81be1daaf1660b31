"""Structured light: a camera beside a projector finds a known pattern, where the pattern falls and outshines the sun.

Invalid are points in the projector's shadow or outside its field, too little light of the pattern (dark, far, mirrors, glass),
too little of it beside sunlight, and surfaces too steep for a window of the pattern to be known again.

Source: Khoshelham and Elberink, Accuracy and Resolution of Kinect Depth Data for Indoor Mapping Applications, Sensors 12 (2012)
1437, section 3; light: see `returned_light`; the error of depth: see `triangulation`.
"""

from plumbline.harness.scene import StructuredLightNoise
from plumbline.harness.sensors.returned_light import in_view_of, too_faint
from plumbline.harness.sensors.sight import Mask, Sight
from plumbline.harness.sensors.triangulation import through_disparity, too_steep
from plumbline.harness.trajectory import Floats


def lost(noise: StructuredLightNoise, sight: Sight) -> Mask:
    """Which measurable pixels are invalid by geometry and optics, (r,). Raises: Unsupported."""
    invalid = too_faint(sight, noise.least_signal, noise.least_contrast)
    if noise.shadow:
        invalid |= sight.measurable & ~in_view_of(sight, noise.baseline)
    return invalid | too_steep(sight, noise.steepest)


def answer(noise: StructuredLightNoise, sight: Sight, normal: Floats) -> Floats:
    """z-depth [m] of all pixels as if all were valid, (r,), from standard normal deviates (r,)."""
    return through_disparity(sight, noise.baseline, noise.disparity_sigma, noise.disparity_step, normal)
