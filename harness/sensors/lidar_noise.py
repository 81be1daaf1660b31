"""Noise of a scanning range finder: range noise, intensity noise, beams that return nothing by chance or for want of light.

The range gets a normal deviate of standard deviation range_sigma + range_sigma_slope * range; a return stays a return whatever
its noisy range, so that the noise is not cut off at the bounds. Each beam that hit is dropped independently with the
given probability, and surely where its ideal intensity lies below the least: infinite range, intensity 0. The intensity gets
a normal deviate of its own; what would be negative is 0.

Each of the three draws once a scan for every beam, whether it hit or not, from a generator of its own: a longer record begins
with the shorter one, and what one beam meets is nothing to another one's noise.

Source: Thrun, Burgard, Fox, Probabilistic Robotics, section 6.3.1 (beam model: p_hit, and p_max for failures).
"""

import numpy as np

from plumbline.harness.scene import LidarNoise
from plumbline.harness.sensors.seeds import generator
from plumbline.harness.trajectory import Floats


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
