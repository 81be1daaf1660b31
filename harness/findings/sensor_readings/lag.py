"""How far an inertial channel lags behind the motion that it tells of.

The motion is that of the trial's own states at its samples: angular velocity as it stands, specific force from a spline through
the velocities of S. The lag is the shift at which the ideal signal, between its readings a spline, fits it best.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from plumbline.harness.findings.sensor_readings.channel import Channel
from plumbline.harness.scene import WORLD, Effect, Imu, Scene
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import product, rotate, rotate_back

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
