"""Beams of a scanning range finder: their directions, and ideal ranges and intensities from what the rays met.

The pattern: `channels` elevations evenly from elevation_low to elevation_high (both included) against the x-y plane of S, times
`columns` azimuths 2 pi k / columns counter-clockwise from +x of S. All beams of a scan are fired at the same instant.
A beam without a return has an infinite range and intensity 0 (ROS REP 117). Intensity is the reflectivity of the body that was
hit times the cosine of the angle of incidence (Lambert's law) and NaN where the engine gives no normal.
"""

import numpy as np

from harness.kinematics import product, rotate
from harness.scene import Lidar, Scene
from harness.sensors.lidar_noise import noisy
from harness.sensors.reader import Setting, row_of
from harness.trajectory import Floats, Hits, State

__all__ = ["LidarReader", "beams", "ideal", "in_world"]


def beams(lidar: Lidar) -> Floats:
    """Unit directions in S, shape (channels, columns, 3)."""
    elevation = np.linspace(lidar.elevation_low, lidar.elevation_high, lidar.channels)[:, None]
    azimuth = 2.0 * np.pi * np.arange(lidar.columns)[None, :] / lidar.columns
    across = np.cos(elevation)
    up = np.broadcast_to(np.sin(elevation), (lidar.channels, lidar.columns))
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), up], axis=-1)


def in_world(lidar: Lidar, p_WB: Floats, q_WB: Floats) -> tuple[Floats, Floats]:
    """Origins [m] and unit directions of all beams in W, each (channels * columns, 3), for the pose of the carrying body."""
    q_WS = product(q_WB, np.array(lidar.q_BS))
    origin = p_WB + rotate(q_WB, np.array(lidar.p_BS))
    directions = rotate(q_WS, beams(lidar).reshape(-1, 3))
    return np.broadcast_to(origin, directions.shape).copy(), directions


def ideal(lidar: Lidar, scene: Scene, directions: Floats, hits: Hits) -> tuple[Floats, Floats]:
    """Ranges [m] and intensities [1], each (channels, columns), from the hits of the beams in the order of `in_world`."""
    shape = (lidar.channels, lidar.columns)
    distance = hits.distance
    # NaN is neither inside nor outside: it stays NaN and shows as such.
    inside = (distance >= lidar.min_range) & (distance <= lidar.max_range) | np.isnan(distance)
    ranges = np.where(inside, distance, np.inf)
    length = np.linalg.norm(hits.normal_W, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = np.abs(np.sum(hits.normal_W * directions, axis=-1)) / length
    # The last place stands for nothing, which body -1 names.
    reflectivity = np.array([*(body.appearance.reflectivity for body in scene.bodies), 0.0])
    intensity = np.where(np.isinf(ranges), 0.0, reflectivity[hits.body] * cosine)
    return ranges.reshape(shape), intensity.reshape(shape)


class LidarReader:
    """Scans '<name>/range' and '<name>/intensity' (k, channels, columns)."""

    def __init__(self, lidar: Lidar, setting: Setting, start: State) -> None:  # noqa: ARG002 -- a scan needs no past
        self._lidar, self._setting = lidar, setting
        self._times: list[float] = []
        self._scans: list[tuple[Floats, Floats]] = []

    def read(self, time: float, state: State) -> None:
        """Cast all beams. Raises: Unsupported."""
        lidar, setting = self._lidar, self._setting
        row = row_of(setting.scene, lidar.body, state)
        origins, directions = in_world(lidar, row[:3], row[3:7])
        # An engine may cut the ray's end off by rounding; the bounds of the sensor are applied to what comes back.
        hits = setting.simulation.cast(origins, directions, lidar.max_range)
        self._times.append(time)
        self._scans.append(ideal(lidar, setting.scene, directions, hits))

    def streams(self) -> dict[str, Floats]:
        """Ranges and intensities, ideal and with noise."""
        lidar, name = self._lidar, self._lidar.name
        shape = (-1, lidar.channels, lidar.columns)
        ranges, intensities = (np.array([scan[k] for scan in self._scans]).reshape(shape) for k in range(2))
        heard = (ranges.copy(), intensities.copy())
        if lidar.noise is not None:
            heard = noisy(lidar.noise, ranges, intensities, self._setting.seed, name)
        return {
            f"{name}/time": np.array(self._times),
            f"{name}/range_ideal": ranges,
            f"{name}/intensity_ideal": intensities,
            f"{name}/range": heard[0],
            f"{name}/intensity": heard[1],
        }
