"""A camera that measures depth, and the noise of each of three principles: stereo, structured light, time of flight."""

import math
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.camera import Pinhole
from plumbline.harness.scene.values import FROZEN, NonNegative, Positive, Probability

Incidence = Annotated[float, Field(gt=0, le=math.pi / 2, allow_inf_nan=False)]
"""An angle [rad] between a ray and a surface's normal: 0 head-on, pi/2 grazing."""


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class StereoNoise:
    """Errors of two cameras that match the texture of what they see.

    Terms:
        baseline [m]: the second camera, alike and parallel, stands this far along +x of S.
        disparity_sigma [px]: standard deviation of a match.
        disparity_step [px]: distance of neighbouring disparities, 0 for none.
        occlusion: what the second camera does not see, hidden or outside its picture, is invalid.
        least_texture [1]: invalid where a smaller share of light is scattered by the surface itself (mirrors, glass); a
        surface that scatters nothing is always invalid.
        steepest [rad]: invalid at a greater angle of incidence.
        missing [1]: share of all other pixels that are invalid at random.
    """

    baseline: Positive
    disparity_sigma: NonNegative = 0.0
    disparity_step: NonNegative = 0.0
    occlusion: bool = True
    least_texture: Probability = 0.0
    steepest: Incidence = math.pi / 2
    missing: Probability = 0.0
    type: Literal["stereo"] = "stereo"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class StructuredLightNoise:
    """Errors of a camera that sees a projected pattern.

    Terms:
        baseline [m]: the projector, with the camera's own field, stands this far along +x of S.
        disparity_sigma [px], disparity_step [px], steepest [rad], missing [1]: as for stereo.
        shadow: what the projector does not light, hidden or outside its field, is invalid.
        least_signal [1]: invalid where less of the pattern's light comes back; 1 is a white surface head-on at 1 m.
        least_contrast [1]: invalid where the pattern's light over the sun's on the surface is smaller.
    """

    baseline: Positive
    disparity_sigma: NonNegative = 0.0
    disparity_step: NonNegative = 0.0
    shadow: bool = True
    least_signal: NonNegative = 0.0
    least_contrast: NonNegative = 0.0
    steepest: Incidence = math.pi / 2
    missing: Probability = 0.0
    type: Literal["structured_light"] = "structured_light"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class TimeOfFlightNoise:
    """Errors of a camera that measures the phase of modulated light from a lamp beside its lens.

    Terms:
        range_sigma [m] + range_sigma_slope [1] r: standard deviation of a range r. shot_sigma [m]: standard deviation by photon
        noise where the signal is 1 and no sun shines, added in squares.
        unambiguous_range [m]: half the wavelength of the modulation, beyond which ranges start from 0 again; None for no wrap.
        multipath [1]: strength, over the direct light, of light that a white surface sends on to the point that is seen.
        least_signal [1], least_contrast [1], missing [1]: as for structured light.
    """

    range_sigma: NonNegative = 0.0
    range_sigma_slope: NonNegative = 0.0
    shot_sigma: NonNegative = 0.0
    unambiguous_range: Positive | None = None
    multipath: Probability = 0.0
    least_signal: NonNegative = 0.0
    least_contrast: NonNegative = 0.0
    missing: Probability = 0.0
    type: Literal["time_of_flight"] = "time_of_flight"

    def __post_init__(self) -> None:
        if self.multipath > 0 and self.unambiguous_range is None:
            raise ValueError(
                f"time of flight: multipath {self.multipath} without unambiguous_range, expected both: paths add as phases"
            )


DepthNoise = Annotated[StereoNoise | StructuredLightNoise | TimeOfFlightNoise, Field(discriminator="type")]


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class DepthCamera(Pinhole):
    """A pinhole camera that measures z-depth [m], mounted and looking as a `Camera` does.

    Terms:
        rate [Hz]; width, height [pixels]; focal_x, focal_y, centre_x, centre_y [pixels].
        near, far [m]: bounds of the depth that is measured: what lies nearer reads -inf, what lies beyond +inf, invalid is NaN.
        seen_by: what finds the ideal depth: a ray through each pixel, which meets collision shapes, or the engine's own picture
        by this renderer, which shows visual ones. What noise asks of light, angles and second views is always told by rays.
        noise: the principle of measurement with its errors; None gives the ideal depth.
    Source: ROS REP 118 (depth images: NaN, -inf and +inf).
    """

    near: Positive = 0.1
    far: Positive = 10.0
    seen_by: Literal["rays", "rasterised", "ray_traced"] = "rays"
    noise: DepthNoise | None = None
    type: Literal["depth_camera"] = "depth_camera"

    def __post_init__(self) -> None:
        if self.far <= self.near:
            raise ValueError(f"sensor '{self.name}': far {self.far} m does not lie beyond near {self.near} m")
