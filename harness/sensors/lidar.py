"""A scanning range finder that fires all beams of a scan at once: ideal ranges and intensities from what the rays met.

A beam without a return has an infinite range and intensity 0 (ROS REP 117). Intensity is the reflectivity of the body that was
hit times the cosine of the angle of incidence (Lambert's law) and NaN where the engine gives no normal. A beam that starts
inside a solid, as of a sensor inside the housing of its own carrier, meets that solid's far side.

A spreading beam is the sum of its sub-rays (see `harness.sensors.lidar`): what one body sends back arrives as one echo, with
the sum of its sub-rays' intensities over their number and their mean range weighted by them. The strongest echo is returned,
of equal ones the nearer, as a range finder with a single return does; so at an edge the beam tells of the body that sends
back more. Source: Wagner et al., Gaussian decomposition and calibration of a novel small-footprint full-waveform digitising
airborne laser scanner, ISPRS J. Photogramm. Remote Sens. 60 (2006) 100 (echoes are sums over the footprint).

Beams of a scanning range finder: the directions of its pattern, and the sub-rays of a beam that spreads.

The pattern: `channels` elevations against the x-y plane of S, its own or evenly from elevation_low to elevation_high (both
included), times `columns` azimuths 2 pi k / columns counter-clockwise from +x of S.

A beam of half angle a is told by seven sub-rays of equal weight: its axis, and six evenly on a ring at a sqrt(7/12), where
their mean square distance from the axis, 6/7 of the ring's, is the a^2/2 of an even disc. A hexagon has no moments of the
first and third order, so that on a plane the mean of the seven ranges is the mean over the beam but for terms in a^4.
Source: Stroud, Approximate Calculation of Multiple Integrals (1971), chapter 8 (rules for the disc).

Noise of a scanning range finder: range noise, intensity noise, beams that return nothing by chance or for want of light.

The range gets a normal deviate of standard deviation range_sigma + range_sigma_slope * range; a return stays a return whatever
its noisy range, so that the noise is not cut off at the bounds. Each beam that hit is dropped independently with the
given probability, and surely where its ideal intensity lies below the least: infinite range, intensity 0. The intensity gets
a normal deviate of its own; what would be negative is 0.

Each of the three draws once a scan for every beam, whether it hit or not, from a generator of its own: a longer record begins
with the shorter one, and what one beam meets is nothing to another one's noise.

Source: Thrun, Burgard, Fox, Probabilistic Robotics, section 6.3.1 (beam model: p_hit, and p_max for failures).

Scans of a range finder as they are collected, and what is made of them: noise, drawn scan by scan in the order of time.

Streams: '<name>/range' and '<name>/intensity' (k, channels, columns), both also as '..._ideal', and the organised cloud
'<name>/points' (k, channels, columns, 3) m in S, the noisy range along the beam, NaN where nothing returned. Each column of
a spinning sensor is given in S as S was when the column was fired, as a driver hands it out that knows of no motion.
"""

from functools import lru_cache

import numpy as np

from plumbline.harness.scene import Lidar, LidarNoise, Scene, rotation_matrix
from plumbline.harness.sensors.reader import Setting, generator, pose_of, row_of
from plumbline.harness.trajectory import Floats, Hits, State
from plumbline.harness.trajectory.kinematics import product, rotate


def points(lidar: Lidar, ranges: Floats) -> Floats:
    """Ranges (k, channels, columns) [m] along the beams, (k, channels, columns, 3), NaN where nothing returned."""
    positions = np.empty((*ranges.shape, 3))
    for scan, out in zip(ranges, positions, strict=True):
        write_points(by_axis(lidar), scan, out)
    return positions


def write_points(along: Floats, scan: Floats, out: Floats) -> None:
    """Write one scan (channels, columns) along the pattern (3, channels, columns) into `out` (channels, columns, 3)."""
    reach = scan.copy()
    np.putmask(reach, scan == np.inf, np.nan)
    for axis in range(3):
        np.multiply(reach, along[axis], out=out[..., axis])


class Scans:
    """The scans so far of one sensor."""

    def __init__(self, lidar: Lidar, seed: int) -> None:
        self._lidar, self._seed = lidar, seed
        self._times: list[float] = []
        self._ranges: list[Floats] = []
        self._intensities: list[Floats] = []

    def add(self, time: float, ranges: Floats, intensities: Floats) -> None:
        """One ideal scan, each (channels, columns), which is kept as it is."""
        self._times.append(time)
        self._ranges.append(ranges)
        self._intensities.append(intensities)

    def streams(self) -> dict[str, Floats]:
        """All scans."""
        lidar, name, shape = self._lidar, self._lidar.name, (-1, self._lidar.channels, self._lidar.columns)
        ranges, intensities = (np.array(kept).reshape(shape) for kept in (self._ranges, self._intensities))
        if lidar.noise is None:
            heard = ranges.copy(), intensities.copy()
        else:
            heard = noisy(lidar.noise, ranges, intensities, self._seed, name)
        return {
            f"{name}/time": np.array(self._times),
            f"{name}/range_ideal": ranges,
            f"{name}/intensity_ideal": intensities,
            f"{name}/range": heard[0],
            f"{name}/intensity": heard[1],
            f"{name}/points": points(lidar, heard[0]),
        }


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


class ScanNoise:
    """The noise of one sensor's scans (channels, columns), in the order of time."""

    def __init__(self, law: LidarNoise, shape: tuple[int, ...], seed: int, sensor: str) -> None:
        self._law, self._room = law, np.empty(shape)
        self._range, self._dropout, self._intensity = (
            generator(seed, sensor, channel) for channel in ("range", "dropout", "intensity")
        )

    def next(self, ranges: Floats, intensities: Floats, heard: Floats, light: Floats) -> None:
        """Write the next scan's noisy ranges [m] and intensities [1] into `heard` and `light`, from its ideal ones."""
        law, room, lost = self._law, self._room, ranges == np.inf
        if law.range_sigma > 0.0 or law.range_sigma_slope > 0.0:
            self._range.standard_normal(out=room)
            # The sigma of what is infinite is infinite too; the sum is no number, and is lost below.
            with np.errstate(invalid="ignore"):
                sigma = np.multiply(ranges, law.range_sigma_slope, out=heard)
                sigma += law.range_sigma
                room *= sigma
                np.add(ranges, room, out=heard)
        else:
            heard[:] = ranges
        if law.intensity_sigma > 0.0:
            self._intensity.standard_normal(out=room)
            room *= law.intensity_sigma
            room += intensities
            np.maximum(room, 0.0, out=light)
        else:
            light[:] = intensities
        if law.least_intensity > 0.0:
            lost |= intensities < law.least_intensity
        if law.dropout > 0.0:
            self._dropout.random(out=room)
            lost |= room < law.dropout
        np.putmask(heard, lost, np.inf)
        np.putmask(light, lost, 0.0)


def noisy(law: LidarNoise, ranges: Floats, intensities: Floats, seed: int, sensor: str) -> tuple[Floats, Floats]:
    """Noisy ranges [m] and intensities [1] of whole records, each (scans, channels, columns)."""
    noise = ScanNoise(law, ranges.shape[1:], seed, sensor)
    heard, light = np.empty(ranges.shape), np.empty(ranges.shape)
    for scan in zip(ranges, intensities, heard, light, strict=True):
        noise.next(*scan)
    return heard, light
