"""How far the ideal signal of a channel lies from the truth: the largest, the root mean square and the median error.

An inertial reading errs by the length of the difference of two vectors, and so does a colour; a range, an intensity or a
depth by the size of the difference. Ranges and depths are compared where both meet the same surface, taken to be another one
where they differ by more than a tenth; the share of the others is `disagree`. Two silences agree where both are alike (NaN, or
infinite with one sign). Bodies that a pixel shows agree or do not.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.sensor_readings.channel import Channel
from plumbline.harness.metric.series import maximum, root_mean_square
from plumbline.harness.trajectory import Floats

OTHER_SURFACE = 0.1


@dataclass(frozen=True, slots=True)
class IdealErrors:
    """In the channel's unit; None where nothing can be compared, and why. disagree: share of readings, None where all agree
    by their nature."""

    error_max: float | None = None
    error_rms: float | None = None
    error_median: float | None = None
    disagree: float | None = None
    why: str = ""


def ideal_errors(channel: Channel) -> IdealErrors:
    """The errors of a channel without its noise; a reading that is not finite where the truth is leaves no finite error."""
    truth = channel.truth
    if truth is None or truth.size == 0:
        return IdealErrors(why=channel.untold or "no reading was taken")
    match channel.channel:
        case "range" | "depth":
            return _surfaces(channel.ideal, truth, strict=channel.channel == "range")
        case "body":
            return IdealErrors(disagree=float(np.mean(channel.ideal != truth)))
        case "intensity":
            return _intensity(channel, truth)
        case _:
            return _of(np.linalg.norm(channel.ideal - truth, axis=-1))


def _of(errors: Floats, disagree: float | None = None) -> IdealErrors:
    if errors.size == 0:
        return IdealErrors(disagree=disagree, why="nothing that is read meets what the truth meets")
    return IdealErrors(maximum(errors), root_mean_square(errors), float(np.median(errors)), disagree)


def _same(measured: Floats, truth: Floats) -> NDArray[np.bool_]:
    """Where both meet the same surface."""
    both = np.isfinite(measured) & np.isfinite(truth)
    with np.errstate(invalid="ignore"):
        mask: NDArray[np.bool_] = both & (np.abs(measured - truth) <= OTHER_SURFACE * np.abs(truth))
    return mask


def _surfaces(measured: Floats, truth: Floats, strict: bool) -> IdealErrors:
    same = _same(measured, truth)
    silent = (np.isnan(measured) & np.isnan(truth)) | (np.isinf(measured) & (measured == truth))
    disagree = float(np.mean(~same & ~silent))
    if strict and np.isnan(measured).any():
        # A beam hits or it does not: NaN is neither, and no statistics may pass over it.
        return IdealErrors(np.nan, np.nan, np.nan, disagree)
    return _of(np.abs(measured[same] - truth[same]), disagree)


def _intensity(channel: Channel, truth: Floats) -> IdealErrors:
    ranges, true_ranges = channel.beside.get("range", (None, None))
    same = np.ones(truth.shape, dtype=np.bool_) if ranges is None or true_ranges is None else _same(ranges, true_ranges)
    if same.any() and np.isnan(channel.ideal[same]).all():
        return IdealErrors(why="the engine gives no normals where its rays hit")
    return _of(np.abs(channel.ideal[same] - truth[same]))
