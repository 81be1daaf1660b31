"""A scanning range finder that fires all beams of a scan at once: ideal ranges and intensities from what the rays met.

A beam without a return has an infinite range and intensity 0 (ROS REP 117). Intensity is the reflectivity of the body that was
hit times the cosine of the angle of incidence (Lambert's law) and NaN where the engine gives no normal. A beam that starts
inside a solid, as of a sensor inside the housing of its own carrier, meets that solid's far side.

A spreading beam is the sum of its sub-rays (see `harness.sensors.beams`): what one body sends back arrives as one echo, with
the sum of its sub-rays' intensities over their number and their mean range weighted by them. The strongest echo is returned,
of equal ones the nearer, as a range finder with a single return does; so at an edge the beam tells of the body that sends
back more. Source: Wagner et al., Gaussian decomposition and calibration of a novel small-footprint full-waveform digitising
airborne laser scanner, ISPRS J. Photogramm. Remote Sens. 60 (2006) 100 (echoes are sums over the footprint).
"""

import numpy as np

from plumbline.harness.scene import Lidar, Scene, rotation_matrix
from plumbline.harness.sensors.beams import SUB_RAYS, beams, spread
from plumbline.harness.sensors.lidar_scans import Scans
from plumbline.harness.sensors.reader import Setting, pose_of, row_of
from plumbline.harness.trajectory import Floats, Hits, State
from plumbline.harness.trajectory.kinematics import product, rotate


def in_world(lidar: Lidar, p_WB: Floats, q_WB: Floats) -> tuple[Floats, Floats]:
    """Origins [m] and unit directions of all sub-rays in W, each (sub-rays * channels * columns, 3), for the carrier's pose."""
    q_WS = product(q_WB, np.array(lidar.q_BS))
    return fired(p_WB + rotate(q_WB, np.array(lidar.p_BS)), q_WS, spread(beams(lidar), lidar.divergence).reshape(-1, 3))


def fired(p_WS: Floats, q_WS: Floats, rays_S: Floats, room: Floats | None = None) -> tuple[Floats, Floats]:
    """Origins [m] and unit directions (r, 3) in W of rays (r, 3) in S; directions are written into `room` where there is one.

    The origins are one row seen r times over, read-only.
    """
    w, x, y, z = (float(c) for c in q_WS)
    directions = np.matmul(rays_S, np.array(rotation_matrix((w, x, y, z))).T, out=room)
    return np.broadcast_to(p_WS, directions.shape), directions


def _dots(a: Floats, b: Floats) -> Floats:
    """Row by row the scalar product, shapes (r, 3); twice as fast as einsum for these shapes."""
    products = a * b
    total: Floats = products[:, 0] + products[:, 1]
    total += products[:, 2]
    return total


def ideal(lidar: Lidar, scene: Scene, directions: Floats, hits: Hits) -> tuple[Floats, Floats]:
    """Ranges [m] and intensities [1], each (channels, columns), from the hits of the rays in the order of `in_world`."""
    shape = (lidar.channels, lidar.columns)
    ranges, intensity = returns(lidar, scene, directions, hits)
    return ranges.reshape(shape), intensity.reshape(shape)


def returns(lidar: Lidar, scene: Scene, directions: Floats, hits: Hits) -> tuple[Floats, Floats]:
    """Ranges [m] and intensities [1] of beams, each (b,), from the hits of their sub-rays, (sub-rays * b)."""
    distance, normal = hits.distance, hits.normal_W
    # NaN is neither inside nor outside: it stays NaN and shows as such.
    outside = distance > lidar.max_range
    if lidar.min_range > 0.0:
        outside |= distance < lidar.min_range
    ranges = distance.copy()
    np.putmask(ranges, outside, np.inf)
    # The last place stands for nothing, which body -1 names.
    reflectivity = np.array([*(body.appearance.reflectivity for body in scene.bodies), 0.0])
    intensity = _dots(normal, directions)
    np.abs(intensity, out=intensity)
    # Normals are unit or zero: where the product says nothing, the length tells a grazing beam from a missing normal.
    dark = np.flatnonzero(intensity == 0.0)
    intensity[dark[~normal[dark].any(axis=1)]] = np.nan
    intensity *= reflectivity[hits.body]
    np.putmask(intensity, ranges == np.inf, 0.0)
    if lidar.divergence == 0.0:
        return ranges, intensity
    return _strongest(ranges, intensity, hits.body)


def _strongest(ranges: Floats, intensity: Floats, body: np.ndarray[tuple[int], np.dtype[np.int64]]) -> tuple[Floats, Floats]:
    """Range and intensity (b,) of the strongest echo of each beam, from its sub-rays, each (7 * b,)."""
    r, power, owner = (a.reshape(SUB_RAYS, -1) for a in (ranges, intensity, body))
    heard = r != np.inf
    # Without normals all that returns counts alike, and the intensity says that it is not known.
    blind = np.isnan(power).any(axis=0)
    weight = np.where(heard, np.where(blind, 1.0, power), 0.0)
    path = weight * np.where(heard, r, 0.0)
    best_range = np.full(r.shape[1], np.inf)
    best_power = np.zeros(r.shape[1])
    for ray in range(SUB_RAYS):
        same = heard & (owner == owner[ray])
        total = np.sum(weight, axis=0, where=same)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.sum(path, axis=0, where=same) / total
        better = (total > best_power) | (total == best_power) & (mean < best_range)
        better &= heard[ray]
        best_range, best_power = np.where(better, mean, best_range), np.where(better, total, best_power)
    return np.where(np.isnan(r).any(axis=0), np.nan, best_range), np.where(blind, np.nan, best_power / SUB_RAYS)


class LidarReader:
    """Scans, as `Scans` gives them."""

    def __init__(self, lidar: Lidar, setting: Setting, start: State) -> None:  # noqa: ARG002 -- a scan needs no past
        self._lidar, self._setting = lidar, setting
        self._rays = spread(beams(lidar), lidar.divergence).reshape(-1, 3)
        # Memory that is new costs more to touch than to fill.
        self._room = np.empty_like(self._rays)
        self._scans = Scans(lidar, setting.seed)

    def read(self, time: float, state: State) -> None:
        """Cast all beams. Raises: Unsupported."""
        lidar, setting = self._lidar, self._setting
        pose = pose_of(row_of(setting.scene, lidar.body, state), lidar.p_BS, lidar.q_BS)
        origins, directions = fired(*pose, self._rays, self._room)
        # An engine may cut the ray's end off by rounding; the bounds of the sensor are applied to what comes back.
        hits = setting.simulation.cast(origins, directions, lidar.max_range)
        self._scans.add(time, *ideal(lidar, setting.scene, directions, hits))

    def streams(self) -> dict[str, Floats]:
        """All scans, ideal and with noise."""
        return self._scans.streams()
