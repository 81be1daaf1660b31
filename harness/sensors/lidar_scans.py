"""Scans of a range finder as they are collected: noise is drawn scan by scan, in the order of time.

Streams: '<name>/range' and '<name>/intensity' (k, channels, columns), both also as '..._ideal', and the organised cloud
'<name>/points' (k, channels, columns, 3) m in S, the noisy range along the beam, NaN where nothing returned. Each column of
a spinning sensor is given in S as S was when the column was fired, as a driver hands it out that knows of no motion.
"""

import numpy as np

from harness.scene import Lidar
from harness.sensors.lidar_noise import ScanNoise
from harness.trajectory import Floats

__all__ = ["Scans"]


class Scans:
    """The scans so far of one sensor with beams (channels, columns, 3) in S."""

    def __init__(self, lidar: Lidar, pattern: Floats, seed: int) -> None:
        self._name, self._pattern = lidar.name, pattern
        self._noise = None if lidar.noise is None else ScanNoise(lidar.noise, pattern.shape[:2], seed, lidar.name)
        self._times: list[float] = []
        self._kept: dict[str, list[Floats]] = {}
        for channel in ("range_ideal", "intensity_ideal", "range", "intensity", "points"):
            self._kept[channel] = []

    def add(self, time: float, ranges: Floats, intensities: Floats) -> None:
        """One ideal scan, each (channels, columns), which is kept and left as it is."""
        heard = (ranges, intensities) if self._noise is None else self._noise.next(ranges, intensities)
        points = np.where(np.isfinite(heard[0]), heard[0], np.nan)[..., None] * self._pattern
        self._times.append(time)
        for channel, one in zip(self._kept, (ranges, intensities, *heard, points), strict=True):
            self._kept[channel].append(one)

    def streams(self) -> dict[str, Floats]:
        """All scans."""
        found: dict[str, Floats] = {f"{self._name}/time": np.array(self._times)}
        for channel, scans in self._kept.items():
            size = self._pattern.shape if channel == "points" else self._pattern.shape[:2]
            found[f"{self._name}/{channel}"] = np.array(scans).reshape(-1, *size)
        return found
