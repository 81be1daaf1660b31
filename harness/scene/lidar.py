"""A scanning range finder: its beams, its bounds and its noise."""

import math
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.mount import Mount
from plumbline.harness.scene.values import FROZEN, NonNegative, Positive, Probability


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
