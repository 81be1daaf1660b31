"""Beams of a scanning range finder: the directions of its pattern, and the sub-rays of a beam that spreads.

The pattern: `channels` elevations against the x-y plane of S, its own or evenly from elevation_low to elevation_high (both
included), times `columns` azimuths 2 pi k / columns counter-clockwise from +x of S.

A beam of half angle a is told by seven sub-rays of equal weight: its axis, and six evenly on a ring at a sqrt(7/12), where
their mean square distance from the axis, 6/7 of the ring's, is the a^2/2 of an even disc. A hexagon has no moments of the
first and third order, so that on a plane the mean of the seven ranges is the mean over the beam but for terms in a^4.
Source: Stroud, Approximate Calculation of Multiple Integrals (1971), chapter 8 (rules for the disc).
"""

from functools import lru_cache

import numpy as np

from plumbline.harness.scene import Lidar
from plumbline.harness.trajectory import Floats

SUB_RAYS = 7


@lru_cache(maxsize=16)
def beams(lidar: Lidar) -> Floats:
    """Unit directions in S, shape (channels, columns, 3), read-only."""
    even = np.linspace(lidar.elevation_low, lidar.elevation_high, lidar.channels)
    elevation = (even if lidar.elevations is None else np.array(lidar.elevations))[:, None]
    azimuth = 2.0 * np.pi * np.arange(lidar.columns)[None, :] / lidar.columns
    across = np.cos(elevation)
    up = np.broadcast_to(np.sin(elevation), (lidar.channels, lidar.columns))
    directions = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), up], axis=-1)
    directions.flags.writeable = False
    return directions


@lru_cache(maxsize=16)
def by_axis(lidar: Lidar) -> Floats:
    """The same axis by axis, (3, channels, columns), read-only: a product over a last axis of three takes twice as long."""
    components = np.ascontiguousarray(np.moveaxis(beams(lidar), -1, 0))
    components.flags.writeable = False
    return components


def spread(directions: Floats, divergence: float) -> Floats:
    """Sub-rays of beams (..., 3) with this half angle [rad], (7, ..., 3) unit, the axis first; (1, ..., 3) for no angle."""
    if divergence == 0.0:
        return directions[None]
    # Any vector off the beam's line gives a frame about it: the axis that it has least of.
    least = np.eye(3)[np.argmin(np.abs(directions), axis=-1)]
    u = np.cross(directions, least)
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    v = np.cross(directions, u)
    angle = divergence * np.sqrt(7.0 / 12.0)
    turn = np.arange(SUB_RAYS - 1) * np.pi / 3.0
    ring = [np.cos(angle) * directions + np.sin(angle) * (np.cos(t) * u + np.sin(t) * v) for t in turn]
    return np.stack([directions, *ring])
