"""How far the ideal signal of a channel lies from the truth: the largest, the root mean square and the median error.

An inertial reading errs by the length of the difference of two vectors, and so does a colour; a range, an intensity or a
depth by the size of the difference. Ranges and depths are compared where both meet the same surface, taken to be another one
where they differ by more than a tenth; the share of the others is `disagree`. Two silences agree where both are alike (NaN, or
infinite with one sign). Bodies that a pixel shows agree or do not.

What sensors should read in a scene without a truth: readings of the engine whose limit is agreed on, at a step of zero.

Its ladder of steps gives each reading several times. Where all are finite they are extrapolated as poses are
(`harness.statistics.richardson`), else those of its finest step stand.

How far an inertial channel lags behind the motion that it tells of.

The motion is that of the trial's own states at its samples: angular velocity as it stands, specific force from a spline through
the velocities of S. The lag is the shift at which the ideal signal, between its readings a spline, fits it best.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.once import once
from plumbline.harness.findings.sensor_readings.channel import Channel
from plumbline.harness.metric.series import maximum, root_mean_square
from plumbline.harness.scene import WORLD, Effect, Imu, Scene
from plumbline.harness.statistics.richardson import extrapolate
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import product, rotate, rotate_back

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


WIDEST = 240
"""Pixels of a picture's longer side."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraPicture:
    """What was seen: colour (h, w, 3), linear, or depth (h, w) m; the ideal depth beside it where noise was laid over it, and
    the truth where it is told. height, width: of the camera's own picture."""

    seen: Floats
    ideal: Floats | None
    truth: Floats | None
    height: int
    width: int


def first_picture(channel: Channel) -> CameraPicture | None:
    """Of a colour or depth channel; None for any other, or where nothing was seen."""
    if channel.channel not in ("colour", "depth") or len(channel.read) == 0:
        return None
    height, width = channel.read.shape[1:3]
    noisy = not np.array_equal(channel.read[0], channel.ideal[0], equal_nan=True)
    return CameraPicture(
        small(channel.read[0]),
        small(channel.ideal[0]) if noisy else None,
        None if channel.truth is None else small(channel.truth[0]),
        height,
        width,
    )


def small(pixels: Floats) -> Floats:
    """At most WIDEST pixels a side: colours are averaged, of depths one in so many is kept, since a mean of two is none."""
    factor = -(-max(pixels.shape[:2]) // WIDEST)
    if factor == 1:
        return pixels.astype(np.float32)
    if pixels.ndim == 2:
        return pixels[factor // 2 :: factor, factor // 2 :: factor].astype(np.float32)
    height, width = (side // factor * factor for side in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // factor, factor, width // factor, factor, 3)
    averaged: Floats = blocks.mean(axis=(1, 3)).astype(np.float32)
    return averaged


ROUND_OFF = 1e-12
"""Relative: of a reading, over some thousand steps."""


@once
def converged_readings(store: Store, case: str) -> Mapping[str, Floats]:
    """Streams 'truth_stream:<sensor>/<channel>_ideal' and their times, as a stored truth has them; empty where no limit is
    agreed to the end of the run."""
    for agreement in agreements(store):
        if agreement.case == case and agreement.agreed and agreement.until >= 0.999 * agreement.duration:
            return _agreed(store, agreement)
    return {}


def _agreed(store: Store, agreement: Agreement) -> dict[str, Floats]:
    voters = [side for side in agreement.members(agreement.agreed) if side.votes and side.limit.until >= agreement.until]
    sharpest = min(voters, key=lambda side: side.limit.bar_at(agreement.until))
    rungs = [rung for rung in sharpest.limit.rungs if rung.run is not None]
    hashes = dict(zip(store.trials["trial"], store.trials["trajectory_hash"], strict=True))
    runs: list[Mapping[str, Any]] = [store.trajectory(str(hashes[rung.trial])) for rung in rungs]
    readings: dict[str, Floats] = {}
    for name, finest in runs[-1].items():
        if not name.startswith("stream:"):
            continue
        ladder = [np.asarray(run[name], float) for run in runs if name in run and run[name].shape == finest.shape]
        regular = len(ladder) > 1 and len(ladder) == len(runs) and all(np.isfinite(each).all() for each in ladder)
        if not regular or name.endswith("/time"):
            readings[f"truth_{name}"] = finest
            continue
        off = ROUND_OFF * float(np.abs(finest).max(initial=0.0))
        readings[f"truth_{name}"] = extrapolate(ladder, [1 / rung.substep for rung in rungs], off).value
    return readings


LEAST = 16
"""Samples and readings below which no shift is sought."""
STEADY = 1e-3
"""A signal that varies by less than this share of its size tells of no time."""
TREMBLE = {"accelerometer": 1e-2, "gyroscope": 1e-3}
"""Nor does one that varies by less than this [m/s2, rad/s]: what rests trembles by so much until its contacts have settled."""

EDGE = 4
"""Samples at each end at which the slope of a spline is worse than between them."""
UNLIKE = 0.01
"""A signal that is off by more than this share of the motion's variance, wherever it is shifted, tells of another motion."""


def lag_by_law(channel: Channel) -> float | None:
    """Latency [s], half an interval more where an acceleration is a mean over one; None where the engine may give its own."""
    imu = channel.sensor
    if not isinstance(imu, Imu):
        return None
    if channel.channel == "gyroscope":
        return imu.latency
    return imu.latency + 0.5 / imu.rate if imu.reading == "states" else None


def lag_of(channel: Channel, scene: Scene, arrays: Mapping[str, Any]) -> float | None:
    """The lag [s]; None where the motion tells of no time, or too little was read or sampled."""
    from scipy.interpolate import CubicSpline  # late: a listing must not pay for it
    from scipy.optimize import minimize_scalar

    imu = channel.sensor
    if not isinstance(imu, Imu) or imu.body == WORLD or len(channel.time) < LEAST or len(arrays["time"]) < LEAST:
        return None
    time, motion = arrays["time"], _motion(imu, channel.channel, scene, arrays)
    if not (np.isfinite(motion).all() and np.isfinite(channel.ideal).all()):
        return None
    least = max(TREMBLE[channel.channel], STEADY * float(np.abs(channel.ideal).max()))
    if np.ptp(channel.ideal, axis=0).max() < least:
        return None
    reach = imu.latency + 3.0 / imu.rate
    inside = (time > channel.time[0] + reach) & (time < channel.time[-1] - reach)
    inside[:EDGE] = inside[-EDGE:] = False
    if inside.sum() < LEAST:
        return None
    signal, at, expected = CubicSpline(channel.time, channel.ideal), time[inside], motion[inside]

    def misfit(lag: float) -> float:
        return float(np.mean(np.square(signal(at + lag) - expected)))

    # The first guess is a scan: a periodic motion has more than one shift that fits a little.
    shifts = np.linspace(-reach, reach, 61)
    best = int(np.argmin([misfit(shift) for shift in shifts]))
    ends = shifts[max(best - 1, 0)], shifts[min(best + 1, len(shifts) - 1)]
    fit = minimize_scalar(misfit, bounds=ends, method="bounded", options={"xatol": 1e-9})
    return float(fit.x) if fit.fun < UNLIKE * float(np.mean(np.var(expected, axis=0))) else None


def _motion(imu: Imu, channel: str, scene: Scene, arrays: Mapping[str, Any]) -> Floats:
    """What an ideal sensor without delay reads at the samples, (t, 3)."""
    from scipy.interpolate import CubicSpline

    index = scene.index(imu.body)
    q_WB, v_WB, w_WB = (arrays[name][:, index] for name in ("q_WB", "v_WB", "w_WB"))
    q_WS = product(q_WB, np.broadcast_to(np.array(imu.q_BS), q_WB.shape))
    if channel == "gyroscope":
        return rotate_back(q_WS, w_WB)
    v_WS = v_WB + np.cross(w_WB, rotate(q_WB, np.broadcast_to(np.array(imu.p_BS), v_WB.shape)))
    felt = (0.0, 0.0, 0.0) if Effect.GRAVITY in scene.narrow else scene.gravity
    force_W = CubicSpline(arrays["time"], v_WS)(arrays["time"], 1) - np.array(felt)
    return rotate_back(q_WS, force_W)
