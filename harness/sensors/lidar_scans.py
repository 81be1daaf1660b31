"""Scans of a range finder as they are collected, and what is made of them: noise, drawn scan by scan in the order of time.

Streams: '<name>/range' and '<name>/intensity' (k, channels, columns), both also as '..._ideal', and the organised cloud
'<name>/points' (k, channels, columns, 3) m in S, the noisy range along the beam, NaN where nothing returned. Each column of
a spinning sensor is given in S as S was when the column was fired, as a driver hands it out that knows of no motion.
"""

import numpy as np

from plumbline.harness.scene import Lidar
from plumbline.harness.sensors.beams import by_axis
from plumbline.harness.sensors.lidar_noise import noisy
from plumbline.harness.trajectory import Floats


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
