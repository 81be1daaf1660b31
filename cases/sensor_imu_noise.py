"""An inertial sensor on a spinning body: is the ideal signal right, and does its noise follow its law?"""

from dataclasses import replace
from functools import partial

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics import inertial_noise, readings
from plumbline.harness.scene import AxisNoise, Body, Imu, ImuNoise, Scene, axis_angle
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about, rotate_back

DURATION = 200.0
RATE = 120.0
MOUNTING = axis_angle((1.0, 2.0, -0.5), 0.7)

GYROSCOPE = AxisNoise(density=2e-4, bias=0.02, instability=1e-3, instability_time=0.2, random_walk=1.5e-3)
ACCELEROMETER = AxisNoise(density=2e-3, bias=0.2, instability=1e-2, instability_time=0.2, random_walk=1.5e-2)
"""White noise of a consumer's sensor; instability and walk are large and quick, so that 200 s show all three slopes."""


class P(Parameters):
    spin: NotNegative = 2.0
    lever: NotNegative = 0.3


def scene(p: P) -> Scene:
    """A free ball turning about z at `spin` [rad/s], with a sensor `lever` [m] off its axis, turned against the ball."""
    ball = Body.ball("ball", 0.5, touches=False, w_WB=(0.0, 0.0, p.spin))
    imu = Imu(
        name="imu",
        body="ball",
        rate=RATE,
        p_BS=(p.lever, 0.0, 0.1),
        q_BS=MOUNTING,
        reading="states",
        noise=ImuNoise(accelerometer=ACCELEROMETER, gyroscope=GYROSCOPE),
    )
    return Scene(bodies=(ball,), sensors=(imu,), gravity=(0.0, 0.0, 0.0))


def expected(time: Floats, p: P) -> Trajectory:
    """Steady rotation, and what an ideal sensor reads in it that differences velocities, as it does in every engine.

    The mean acceleration over an interval T of a circle of radius r is the chord of the velocity's own circle over T: it has
    the size 2 w r sin(w T/2)/T and points to the axis from where S is in the middle of the interval.
    """
    truth = Trajectory.of(time, 1)
    truth.q_WB[:, 0], truth.w_WB[:, 0, 2] = about(2, p.spin * truth.time), p.spin
    count = int(np.floor(float(truth.time[-1]) * RATE + 1e-6)) if len(truth) else 0
    inwards = -2.0 * p.spin * p.lever * np.sin(p.spin / (2 * RATE)) * RATE
    streams = {"imu/time": np.arange(1, count + 1) / RATE}
    for name, signal in (("accelerometer", [inwards, 0.0, 0.0]), ("gyroscope", [0.0, 0.0, p.spin])):
        streams[f"imu/{name}_ideal"] = np.tile(rotate_back(np.array(MOUNTING), np.array(signal)), (count, 1))
    return replace(truth, streams=streams)


def _acceleration(dt: float, p: P) -> float:
    """[m/s2]: an angle a step of 2 atan(w dt/2) instead of w dt, and the rounding of velocities w r over one interval."""
    return 1.01 * p.spin**2 * p.lever * (p.spin * dt) ** 2 / 12 + 8 * SINGLE * p.spin * p.lever * RATE


def _slope_checks() -> tuple[Check, ...]:
    count = round(DURATION * RATE)
    laws: dict[inertial_noise.Channel, AxisNoise] = {"gyroscope": GYROSCOPE, "accelerometer": ACCELEROMETER}
    regimes: tuple[inertial_noise.Regime, ...] = ("white", "floor", "random_walk")

    def bound(law: AxisNoise, regime: inertial_noise.Regime, _dt: float, _p: P) -> float:
        return inertial_noise.slope_bound(law, regime, count, 1.0 / RATE)

    return tuple(
        Check(
            inertial_noise.SLOPES[channel, regime],
            partial(bound, law, regime),
            "the part that the law's other processes have in the slope over this window, and five standard deviations",
        )
        for channel, law in laws.items()
        for regime in regimes
    )


FIVE = "five standard deviations: each comparison raises a false alarm in 6 of 10 million runs, "

CASE = Case.of(
    globals(),
    title="Noise of an inertial sensor",
    question="Are acceleration and turning right at a lever arm, and has the noise the Allan deviation of its law?",
    source="IEEE Std 952-1997, annex C; Titterton, Weston, Strapdown Inertial Navigation Technology, 2nd ed., chapter 11",
    truth="statistics",
    sample_interval=0.1,
    dt=1 / 120,
    ladder=(1 / 120, 1 / 240, 1 / 360, 1 / 480, 1 / 720, 1 / 960),
    checks=(
        Check(
            readings.accelerometer_ideal_error,
            _acceleration,
            "w^2 r (w dt)^2/12 for an attitude updated to second order a step, and single-precision rounding of the "
            "velocities that are differenced",
        ),
        Check(
            readings.gyroscope_ideal_error,
            lambda _, p: 16 * SINGLE * p.spin,
            "no torque acts, so the rate stays what it was; a few roundings in single precision",
        ),
        Check(inertial_noise.gyroscope_allan_score, 5.0, FIVE + "the largest of 36 in 2 of 100 000"),
        Check(inertial_noise.accelerometer_allan_score, 5.0, FIVE + "the largest of 36 in 2 of 100 000"),
        Check(inertial_noise.inertial_bias_score, 5.0, FIVE + "the largest of 6 in 3 of a million"),
        Check(inertial_noise.inertial_correlation_score, 5.0, FIVE + "the largest of 15 pairs in 9 of a million"),
        *_slope_checks(),
    ),
)
