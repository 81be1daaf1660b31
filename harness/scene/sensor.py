"""Sensors, mounted on a body (or the world) with a pose, a rate and a noise model in the units of data sheets."""

import math
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.scene.values import FROZEN, Name, NonNegative, Positive, Probability, Quaternion, Vector3

__all__ = [
    "AxisNoise",
    "Camera",
    "DepthCamera",
    "DepthNoise",
    "Imu",
    "ImuNoise",
    "Lidar",
    "LidarNoise",
    "Sensor",
]


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class AxisNoise:
    """Noise of one inertial channel, u being rad/s (gyroscope) or m/s2 (accelerometer).

    Terms:
        density [u/sqrt(Hz)]: white noise. bias [u]: constant. instability [u]: the flat floor of the Allan deviation.
        instability_time [s]: correlation time of the process that makes that floor.
        random_walk [u/s/sqrt(Hz)]: rate of the drifting bias.
    Source: IEEE Std 952-1997, annex C.
    """

    density: NonNegative = 0.0
    bias: float = 0.0
    instability: NonNegative = 0.0
    instability_time: Positive = 100.0
    random_walk: NonNegative = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class ImuNoise:
    """Noise of an inertial measurement unit: the same law on each of three axes, drawn independently."""

    accelerometer: AxisNoise = AxisNoise()
    gyroscope: AxisNoise = AxisNoise()


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Imu:
    """Accelerometer (specific force) and gyroscope at p_BS [m], turned by q_BS, read `rate` [Hz] times a second."""

    name: Name
    body: Name
    rate: Positive
    p_BS: Vector3 = (0.0, 0.0, 0.0)
    q_BS: Quaternion = (1.0, 0.0, 0.0, 0.0)
    noise: ImuNoise | None = None
    type: Literal["imu"] = "imu"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class LidarNoise:
    """Noise of a scanning range finder.

    Terms:
        range_sigma [m] + range_sigma_slope [m/m] r: standard deviation of a range r.
        dropout [1]: probability that a beam that hit returns nothing.
        reflectivity [1]: of the surfaces; the intensity is reflectivity cos(incidence) (Lambert).
    """

    range_sigma: NonNegative = 0.0
    range_sigma_slope: NonNegative = 0.0
    dropout: Probability = 0.0
    reflectivity: Probability = 1.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Lidar:
    """A scanning range finder: `channels` elevations between the two bounds [rad] times `columns` azimuths over 2 pi."""

    name: Name
    body: Name
    rate: Positive
    p_BS: Vector3 = (0.0, 0.0, 0.0)
    q_BS: Quaternion = (1.0, 0.0, 0.0, 0.0)
    channels: Annotated[int, Field(ge=1, le=4096)] = 32
    columns: Annotated[int, Field(ge=1, le=65536)] = 360
    elevation_low: Annotated[float, Field(ge=-math.pi / 2, le=math.pi / 2)] = -math.pi / 8
    elevation_high: Annotated[float, Field(ge=-math.pi / 2, le=math.pi / 2)] = math.pi / 8
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


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Camera:
    """A pinhole camera looking along +z of S with x right and y down; the centre of pixel (0, 0) lies at (0.5, 0.5)."""

    name: Name
    body: Name
    rate: Positive
    p_BS: Vector3 = (0.0, 0.0, 0.0)
    q_BS: Quaternion = (1.0, 0.0, 0.0, 0.0)
    width: Annotated[int, Field(ge=1, le=16384)] = 640
    height: Annotated[int, Field(ge=1, le=16384)] = 480
    focal_x: Positive = 500.0
    focal_y: Positive = 500.0
    centre_x: float = 320.0
    centre_y: float = 240.0
    type: Literal["camera"] = "camera"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class DepthNoise:
    """Noise of a depth camera; sigma [m] + sigma_square [1/m] z^2 at depth z, and the share of missing pixels."""

    sigma: NonNegative = 0.0
    sigma_square: NonNegative = 0.0
    missing: Probability = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class DepthCamera:
    """A pinhole camera that measures z-depth [m] between `near` and `far`, by one of three principles."""

    name: Name
    body: Name
    rate: Positive
    p_BS: Vector3 = (0.0, 0.0, 0.0)
    q_BS: Quaternion = (1.0, 0.0, 0.0, 0.0)
    width: Annotated[int, Field(ge=1, le=16384)] = 640
    height: Annotated[int, Field(ge=1, le=16384)] = 480
    focal_x: Positive = 500.0
    focal_y: Positive = 500.0
    centre_x: float = 320.0
    centre_y: float = 240.0
    near: Positive = 0.1
    far: Positive = 10.0
    principle: Literal["structured_light", "time_of_flight", "stereo"] = "stereo"
    noise: DepthNoise | None = None
    type: Literal["depth_camera"] = "depth_camera"

    def __post_init__(self) -> None:
        if self.far <= self.near:
            raise ValueError(f"sensor '{self.name}': far {self.far} m does not lie beyond near {self.near} m")


Sensor = Annotated[Imu | Lidar | Camera | DepthCamera, Field(discriminator="type")]
