"""Sensors: what all state, cameras, depth cameras, inertial units and lidars with their noise, and their closed union."""

import math
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.values import FROZEN, Finite, Name, NonNegative, Positive, Probability, Quaternion, Vector3


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Mount:
    """A sensor whose frame S sits on a body at p_BS [m], turned by q_BS, read `rate` [Hz] times a second."""

    name: Name
    body: Name
    rate: Positive
    p_BS: Vector3 = (0.0, 0.0, 0.0)
    q_BS: Quaternion = (1.0, 0.0, 0.0, 0.0)


Pixels = Annotated[int, Field(ge=1, le=16384)]
Renderer = Literal["rasterised", "ray_traced"]
"""A z-buffer, or rays with shadows, reflection and refraction."""


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Distortion:
    """Lens distortion of normalised image coordinates (x, y) at r^2 = x^2 + y^2.

    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), y' = y (...) + p1 (r^2 + 2 y^2) + 2 p2 x y.
    Source: Brown, Decentering Distortion of Lenses, Photogrammetric Engineering 32 (1966) 444.
    """

    k1: Finite = 0.0
    k2: Finite = 0.0
    k3: Finite = 0.0
    p1: Finite = 0.0
    p2: Finite = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Pinhole(Mount):
    """Looks along +z of S with x right and y down; the centre of pixel (0, 0) lies at (0.5, 0.5). All numbers in pixels."""

    width: Pixels = 640
    height: Pixels = 480
    focal_x: Positive = 500.0
    focal_y: Positive = 500.0
    centre_x: Finite = 320.0
    centre_y: Finite = 240.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Camera(Pinhole):
    """A pinhole camera looking along +z of S with x right and y down; the centre of pixel (0, 0) lies at (0.5, 0.5).

    Terms:
        rate [Hz]; width, height [pixels]; focal_x, focal_y, centre_x, centre_y [pixels]; distortion: none is a pinhole.
        renderer: what draws the picture. samples [1]: rays a pixel, for a renderer that traces them.
    """

    distortion: Distortion | None = None
    renderer: Renderer = "rasterised"
    samples: Annotated[int, Field(ge=1, le=1024)] = 1
    type: Literal["camera"] = "camera"

    def __post_init__(self) -> None:
        if self.distortion is not None and self.renderer == "rasterised":
            raise ValueError(f"sensor '{self.name}': a rasteriser draws straight lines; expected renderer 'ray_traced'")


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


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class AxisNoise:
    """Errors of one inertial channel, u being rad/s (gyroscope) or m/s2 (accelerometer), in the order in which they arise.

    Data sheets use other units: docs/method.md says how to convert them.

    Terms:
        misalignment [rad]: rotation vector that turns the channel's triad against S. scale_error [1]: the signal is multiplied
        by 1 + scale_error.
        density [u/sqrt(Hz)]: white noise. bias [u]: constant. instability [u]: the flat floor of the Allan deviation.
        instability_time [s]: correlation time of the process that makes that floor.
        random_walk [u/s/sqrt(Hz)]: rate of the drifting bias.
        saturation [u]: greatest size of what can be read, None for no bound. quantisation [u]: distance of neighbouring
        readings, 0 for none.
    Source: IEEE Std 952-1997, annex C; IEEE Std 1293-2018 (accelerometers: scale factor, misalignment).
    """

    misalignment: Vector3 = (0.0, 0.0, 0.0)
    scale_error: Finite = 0.0

    density: NonNegative = 0.0
    bias: Finite = 0.0
    instability: NonNegative = 0.0
    instability_time: Positive = 100.0
    random_walk: NonNegative = 0.0
    saturation: Positive | None = None
    quantisation: NonNegative = 0.0

    def __post_init__(self) -> None:
        if self.saturation is not None and self.saturation < self.quantisation:
            raise ValueError(
                f"inertial noise: saturation {self.saturation:g} lies below quantisation {self.quantisation:g}, which leaves "
                "no reading but 0; expected at least one step of the quantisation"
            )


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class ImuNoise:
    """Noise of an inertial measurement unit: the same law on each of three axes, drawn independently."""

    accelerometer: AxisNoise = AxisNoise()
    gyroscope: AxisNoise = AxisNoise()


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Imu(Mount):
    """Accelerometer (specific force) and gyroscope at p_BS [m], turned by q_BS, read `rate` [Hz] times a second.

    Terms:
        latency [s]: age of a signal when it is read; a reading stamped t tells of t - latency.
        reading: 'native' takes the engine's own sensor where it has one, 'states' differences the velocities in any engine.
    """

    latency: NonNegative = 0.0
    reading: Literal["native", "states"] = "native"
    noise: ImuNoise | None = None
    type: Literal["imu"] = "imu"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class LidarNoise:
    """Noise of a scanning range finder.

    Terms:
        range_sigma [m] + range_sigma_slope [1] r: standard deviation of a range r.
        dropout [1]: probability that a beam that hit returns nothing.
        intensity_sigma [1]: standard deviation of the intensity; what would be negative is 0.
        least_intensity [1]: a beam whose ideal intensity lies below this returns nothing.
    """

    range_sigma: NonNegative = 0.0
    range_sigma_slope: NonNegative = 0.0
    dropout: Probability = 0.0
    intensity_sigma: NonNegative = 0.0
    least_intensity: Probability = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Lidar(Mount):
    """A scanning range finder: `channels` elevations between the two bounds [rad] times `columns` azimuths over 2 pi.

    Terms:
        elevations [rad]: the channels' own, in place of evenly spaced ones. spinning: the columns are fired one after the other
        over the interval that ends at the time stamp, each from where the sensor then is, instead of all at once.
        divergence [rad]: half the angle of a beam's cone, 0 for a line. min_range, max_range [m].
    """

    channels: Annotated[int, Field(ge=1, le=4096)] = 32
    columns: Annotated[int, Field(ge=1, le=65536)] = 360
    elevation_low: Annotated[float, Field(ge=-math.pi / 2, le=math.pi / 2)] = -math.pi / 8
    elevation_high: Annotated[float, Field(ge=-math.pi / 2, le=math.pi / 2)] = math.pi / 8
    elevations: tuple[Annotated[float, Field(ge=-math.pi / 2, le=math.pi / 2)], ...] | None = None
    spinning: bool = False
    divergence: Annotated[float, Field(ge=0, lt=math.pi / 4)] = 0.0
    min_range: NonNegative = 0.0
    max_range: Positive = 100.0
    noise: LidarNoise | None = None
    type: Literal["lidar"] = "lidar"

    def __post_init__(self) -> None:
        if self.min_range >= self.max_range:
            raise ValueError(f"sensor '{self.name}': min_range {self.min_range} m reaches max_range {self.max_range} m")
        if self.elevation_low > self.elevation_high:
            raise ValueError(
                f"sensor '{self.name}': elevation_low {self.elevation_low} lies above elevation_high {self.elevation_high}"
            )
        if self.elevations is not None and len(self.elevations) != self.channels:
            raise ValueError(
                f"sensor '{self.name}': {len(self.elevations)} elevations for {self.channels} channels, expected as many"
            )


Sensor = Annotated[Imu | Lidar | Camera | DepthCamera, Field(discriminator="type")]
