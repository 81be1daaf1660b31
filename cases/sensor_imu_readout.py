"""What an inertial sensor without noise makes of its signal: a triad out of line, a scale error, steps and bounds."""

from dataclasses import replace

import numpy as np

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import SINGLE, G
from plumbline.harness.case.forces import Control
from plumbline.harness.metrics.readings import accelerometer_ideal_error, gyroscope_ideal_error, inertial_readout_error
from plumbline.harness.scene import AxisNoise, Body, Imu, ImuNoise, Scene, axis_angle, sphere_inertia
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import about, rotate_back

DURATION, RATE = 2.0, 60.0
MASS, RADIUS = 2.0, 0.5
SPIN_UP = 3.0
MOUNTING = axis_angle((1.0, 2.0, -0.5), 0.7)
ACCELEROMETER = AxisNoise(quantisation=0.05, saturation=7.0, scale_error=0.02, misalignment=(0.03, -0.02, 0.04))
GYROSCOPE = AxisNoise(quantisation=0.02, saturation=4.0, scale_error=-0.03, misalignment=(-0.02, 0.05, 0.01))
"""Coarse steps and bounds that the signal passes: the weight alone reaches 7.4 m/s2 on one axis, the spin 4.9 rad/s."""


class P(Parameters):
    spin_up: Positive = SPIN_UP


def scene(_: P) -> Scene:
    """A ball at rest, held up and spun up about z by the control, with a sensor at its centre, turned against it."""
    ball = Body.ball("ball", RADIUS, mass=MASS, touches=False)
    law = ImuNoise(accelerometer=ACCELEROMETER, gyroscope=GYROSCOPE)
    imu = Imu(name="imu", body="ball", rate=RATE, q_BS=MOUNTING, reading="states", noise=law)
    return Scene(bodies=(ball,), sensors=(imu,))


def control(p: P) -> Control:
    """The weight borne, and the torque that spins the ball up by `spin_up` [rad/s2]."""
    force = np.array([[0.0, 0.0, MASS * G]])
    torque = np.array([[0.0, 0.0, sphere_inertia(MASS, RADIUS)[2][2] * p.spin_up]])

    def wrench(_time: float, _state: State) -> tuple[Floats, Floats]:
        return force, torque

    return Control(wrench=wrench)


def expected(time: Floats, p: P) -> Trajectory:
    """The weight is felt along z, which is the axis of the spin as well: both signals stand still in S but for w = a t."""
    truth = Trajectory.of(time, 1)
    truth.q_WB[:, 0] = about(2, p.spin_up * truth.time**2 / 2)
    truth.w_WB[:, 0, 2] = p.spin_up * truth.time
    count = int(np.floor(float(truth.time[-1]) * RATE + 1e-6)) if len(truth) else 0
    late = np.arange(1, count + 1) / RATE
    up = np.tile((0.0, 0.0, 1.0), (count, 1))
    q_BS = np.tile(MOUNTING, (count, 1))
    streams = {
        "imu/time": late,
        "imu/accelerometer_ideal": rotate_back(q_BS, G * up),
        "imu/gyroscope_ideal": rotate_back(q_BS, p.spin_up * late[:, None] * up),
    }
    return replace(truth, streams=streams)


CASE = Case.of(
    globals(),
    title="Digits of an inertial sensor",
    question="Are readings the nearest levels, within their bounds, of a signal that is seen askew and out of scale?",
    source="IEEE Std 1293-2018; Widrow, Kollar, Quantization Noise (2008), section 1.1",
    truth="closed form",
    checks=(
        Check(
            inertial_readout_error,
            1e-9,
            "a reading is a whole number of steps to some roundings of some hundreds; a wrong level is a whole step",
        ),
        Check(
            accelerometer_ideal_error,
            8 * SINGLE * G * (1.0 + RATE),
            "the weight is borne: rounding of g dt, a sum of it over an interval, in single precision",
        ),
        Check(
            gyroscope_ideal_error,
            lambda _, p: 64 * SINGLE * p.spin_up * DURATION,
            "a steady torque is integrated exactly by every integrator; what is left is the rounding of its sum, in "
            "single precision",
        ),
    ),
)
