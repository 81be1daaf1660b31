"""The channels of a trial's sensors: what was read, what an ideal sensor would have read, what the truth says it should; and
what is found of its noise beside what its law says.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.scene import Camera, DepthCamera, Lidar, Scene, Sensor
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.percentiles import chi_squared_percentile
from plumbline.harness.statistics.student import Z_95, wilson_interval
from plumbline.harness.trajectory import Floats

RAYS = "rays"
"""The type, and the stream, of a case that casts rays of its own, without a sensor."""

UNITS: Mapping[str, Mapping[str, str]] = {
    "imu": {"accelerometer": "m/s2", "gyroscope": "rad/s"},
    "lidar": {"range": "m", "intensity": "1"},
    "camera": {"colour": "1", "depth": "m", "body": "1"},
    "depth_camera": {"depth": "m", "body": "1"},
    RAYS: {"range": "m"},
}
"""Units of the channels, by type of sensor."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One channel of one sensor in one trial.

    Terms:
        sensor: as in the scene, None for rays without one. name, type: of the sensor. channel, unit.
        time (k,) s. read (k, ...): what came out; ideal (k, ...): without noise, the same where there is none.
        truth (k, ...): ideal by the truth, None where it does not tell; untold: why. excused (k, ...): 1 where the truth says
        that geometry or optics take the reading away, None where it does not say. beside: the other channels by name, as
        (ideal, truth).
    """

    sensor: Sensor | None
    name: str
    type: str
    channel: str
    unit: str
    time: Floats
    read: Floats
    ideal: Floats
    truth: Floats | None
    untold: str
    excused: Floats | None
    beside: Mapping[str, tuple[Floats, Floats | None]]


def rays_of(sensor: Sensor) -> int:
    """Beams or pixels of one reading; 0 for a sensor that casts none."""
    if isinstance(sensor, Lidar):
        return sensor.channels * sensor.columns
    return sensor.width * sensor.height if isinstance(sensor, Camera | DepthCamera) else 0


def channels(scene: Scene, arrays: Mapping[str, Any]) -> Iterator[Channel]:
    """The channels that were recorded, sensor by sensor.

    Args: arrays: of a trajectory, as `harness.store.store.Store.trajectory` gives them.
    """
    known: list[tuple[Sensor | None, str, str]] = [(sensor, sensor.name, sensor.type) for sensor in scene.sensors]
    for sensor, name, kind in [*known, (None, RAYS, RAYS)]:
        every = {channel: _signals(name, channel, arrays) for channel in UNITS[kind]}
        recorded = {channel: signals for channel, signals in every.items() if signals is not None}
        for channel, (read, ideal, truth, untold) in recorded.items():
            yield Channel(
                sensor=sensor,
                name=name,
                type=kind,
                channel=channel,
                unit=UNITS[kind][channel],
                time=arrays[f"stream:{name}/time"],
                read=read,
                ideal=ideal,
                truth=truth,
                untold=untold,
                excused=_excused(name, read, arrays),
                beside={other: (signals[1], signals[2]) for other, signals in recorded.items() if other != channel},
            )


def _excused(name: str, read: Floats, arrays: Mapping[str, Any]) -> Floats | None:
    lost = arrays.get(f"truth_stream:{name}/lost")
    return None if lost is None or lost.shape != read.shape else np.asarray(lost)


def _signals(name: str, channel: str, arrays: Mapping[str, Any]) -> tuple[Floats, Floats, Floats | None, str] | None:
    plain, ideal = f"stream:{name}/{channel}", f"stream:{name}/{channel}_ideal"
    if f"stream:{name}/time" not in arrays or (plain not in arrays and ideal not in arrays):
        return None
    read = np.asarray(arrays[plain] if plain in arrays else arrays[ideal])
    without = np.asarray(arrays.get(ideal, read))
    truth = next((arrays[f"truth_{key}"] for key in (ideal, plain) if f"truth_{key}" in arrays), None)
    if truth is None:
        return read, without, None, "the truth does not tell this channel"
    here, there = arrays[f"stream:{name}/time"], arrays.get(f"truth_stream:{name}/time")
    if there is None or here.shape != there.shape or not np.all(np.abs(here - there) < 1e-9):
        return read, without, None, "the truth stands at other times than the readings"
    if truth.shape != without.shape:
        return read, without, None, f"the truth has the shape {truth.shape}, the readings {without.shape}"
    return read, without, np.asarray(truth), ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """Found, with 95 % intervals, and by law; None where the law has no such part or the readings cannot tell.

    Terms:
        law: in words. count: of readings that the spread is taken from. sigma: standard deviation from reading to reading,
        over all readings together. bias: mean deviation. lost: share of returns that got lost.
        white, floor, walk: Allan deviation over the law's, where that process is strongest. why: what cannot be told.
    """

    law: str
    count: int = 0
    sigma: Interval | None = None
    sigma_law: float | None = None
    bias: Interval | None = None
    bias_law: float | None = None
    lost: Interval | None = None
    lost_law: float | None = None
    white: float | None = None
    floor: float | None = None
    walk: float | None = None
    why: str = ""


@dataclass(frozen=True, slots=True)
class NoiseCurve:
    """What was found of noise beside its law, as a chart draws it, (k,) each: the Allan deviation over averaging times [s], the
    density of range errors over their standard deviation by law, or the spread of depth errors [m] over depths [m].

    Terms: low, high: where 95 % of findings lie if the law holds; of a spread, its own 95 % interval. count: of readings that a
    density is of; beyond: those outside of all its bins.
    """

    at: Floats
    found: Floats
    law: Floats
    low: Floats
    high: Floats
    count: int = 0
    beyond: int = 0


SILENT = Noise(law="")
"""Of a channel without noise."""


def spread_interval(sigma: float, freedom: float) -> Interval:
    """A standard deviation with so many degrees of freedom, by the chi-squared law of its square."""
    if not (math.isfinite(sigma) and freedom >= 1):
        return Interval(sigma, math.nan, math.nan)
    high, low = (float(chi_squared_percentile(share, freedom)) for share in (0.025, 0.975))
    return Interval(sigma, sigma * math.sqrt(freedom / low), sigma * math.sqrt(freedom / high))


def lost_share(lost: int, count: int, law: float) -> dict[str, Any]:
    """The fields of `Noise` about returns that got lost, with Wilson's interval; none where nothing could get lost."""
    if count == 0:
        return {}
    return {"lost": Interval(lost / count, *wilson_interval(lost, count)), "lost_law": law}


def spread(deviation: Floats, law: Floats) -> dict[str, Any]:
    """The fields of `Noise` about spread and mean of independent deviations (n,), whose standard deviations by law are (n,)."""
    n = len(deviation)
    sigma, bias = spread_interval(float(np.sqrt(np.mean(np.square(deviation)))), n), float(np.mean(deviation))
    # The law is known, so the interval of the mean is that of a known variance.
    width = Z_95 * float(np.sqrt(np.mean(np.square(law)) / n))
    by_law = float(np.sqrt(np.mean(np.square(law))))
    return {"sigma": sigma, "sigma_law": by_law, "bias": Interval(bias, bias - width, bias + width), "bias_law": 0.0}
