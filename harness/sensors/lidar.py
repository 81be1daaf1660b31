"""Beams of a scanning range finder: their directions, and ideal ranges and intensities from what the rays met.

The pattern: `channels` elevations evenly from elevation_low to elevation_high (both included) against the x-y plane of S, times
`columns` azimuths 2 pi k / columns counter-clockwise from +x of S. All beams of a scan are fired at the same instant.
A beam without a return has an infinite range and intensity 0 (ROS REP 117). Intensity is reflectivity times the cosine of the
angle of incidence (Lambert's law) and NaN where the engine gives no normal.
"""

import numpy as np

from harness.kinematics import product, rotate
from harness.scene import Lidar
from harness.trajectory import Floats, Hits

__all__ = ["beams", "ideal", "in_world"]


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


def ideal(lidar: Lidar, directions: Floats, hits: Hits) -> tuple[Floats, Floats]:
    """Ranges [m] and intensities [1], each (channels, columns), from the hits of the beams in the order of `in_world`."""
    shape = (lidar.channels, lidar.columns)
    distance = hits.distance
    # NaN is neither inside nor outside: it stays NaN and shows as such.
    inside = (distance >= lidar.min_range) & (distance <= lidar.max_range) | np.isnan(distance)
    ranges = np.where(inside, distance, np.inf)
    length = np.linalg.norm(hits.normal_W, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = np.abs(np.sum(hits.normal_W * directions, axis=-1)) / length
    intensity = np.where(np.isinf(ranges), 0.0, (1.0 if lidar.noise is None else lidar.noise.reflectivity) * cosine)
    return ranges.reshape(shape), intensity.reshape(shape)
