"""An inertial sensor on a body that a steady torque spins up: centripetal and tangential force at a lever, seen askew."""

from dataclasses import replace

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters, Positive
from plumbline.harness.case.bounds import SINGLE, G
from plumbline.harness.case.forces import Control
from plumbline.harness.metrics.readings import accelerometer_ideal_error, gyroscope_ideal_error
from plumbline.harness.scene import Body, Imu, Scene, axis_angle, sphere_inertia
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import about, rotate_back

DURATION, RATE = 2.0, 60.0
SPIN_UP, LEVER = 3.0, 0.4
MASS, RADIUS = 2.0, 0.5
MOUNTING = axis_angle((1.0, 2.0, -0.5), 0.7)


class P(Parameters):
    spin_up: Positive = SPIN_UP
    lever: NotNegative = LEVER


def scene(p: P) -> Scene:
    """A ball at rest, held up and spun up about z by the control, with a sensor `lever` [m] off its axis, turned against it."""
    ball = Body.ball("ball", RADIUS, mass=MASS, touches=False)
    imu = Imu(name="imu", body="ball", rate=RATE, p_BS=(p.lever, 0.0, 0.1), q_BS=MOUNTING, reading="states")
    return Scene(bodies=(ball,), sensors=(imu,))


def control(p: P) -> Control:
    """The weight borne, and the torque that spins the ball up by `spin_up` [rad/s2]."""
    force = np.array([[0.0, 0.0, MASS * G]])
    torque = np.array([[0.0, 0.0, sphere_inertia(MASS, RADIUS)[2][2] * p.spin_up]])

    def wrench(_time: float, _state: State) -> tuple[Floats, Floats]:
        return force, torque

    return Control(wrench=wrench)


def expected(time: Floats, p: P) -> Trajectory:
    """w = a t; the mean acceleration over an interval T between the angles A and B, seen from the middle one.

    The velocities w r stand at angles of -h and h to the middle's tangent with h = (B - A)/2 = a (t - T/2) T/2, so that their
    difference over T is -(w_B + w_A) r sin(h)/T inwards and (w_B - w_A) r cos(h)/T along the circle. The force that bears
    the weight is felt upwards.
    """
    truth = Trajectory.of(time, 1)
    truth.q_WB[:, 0] = about(2, p.spin_up * truth.time**2 / 2)
    truth.w_WB[:, 0, 2] = p.spin_up * truth.time
    count = int(np.floor(float(truth.time[-1]) * RATE + 1e-6)) if len(truth) else 0
    late = np.arange(1, count + 1) / RATE
    early = late - 1 / RATE
    half = p.spin_up * (late + early) / 2 / RATE / 2
    inwards = -p.spin_up * (late + early) * p.lever * np.sin(half) * RATE
    along = p.spin_up * p.lever * np.cos(half)
    felt = np.stack([inwards, along, np.full(count, G)], axis=1)
    turning = np.stack([0 * late, 0 * late, p.spin_up * late], axis=1)
    q_BS = np.tile(MOUNTING, (count, 1))
    streams = {"imu/time": late}
    streams["imu/accelerometer_ideal"], streams["imu/gyroscope_ideal"] = rotate_back(q_BS, felt), rotate_back(q_BS, turning)
    return replace(truth, streams=streams)


def _acceleration(dt: float, p: P) -> float:
    """[m/s2]: an interval's angle is wrong by a T dt/2 where a step takes the rate of its start or end, and by (w dt)^2/12 of
    itself where it takes 2 atan(w dt/2); rounding of w r and of g in single precision."""
    fastest = p.spin_up * DURATION
    early = fastest * p.lever * p.spin_up * dt / 2
    second = fastest**2 * p.lever * (fastest * dt) ** 2 / 12
    return 1.05 * (early + second) + 8 * SINGLE * (fastest * p.lever * RATE + G)


CASE = Case.of(
    globals(),
    title="Inertial sensor on a turntable",
    question="Does a sensor at a lever, mounted askew on a body that is spun up, feel centripetal and tangential force?",
    source="Goldstein, Classical Mechanics, 3rd ed., section 4.10: a = w' x r + w x (w x r); Titterton, Weston, section 11.3",
    truth="closed form",
    checks=(
        Check(
            accelerometer_ideal_error,
            _acceleration,
            "w r a dt/2: the angle of an interval from rates at the starts or ends of steps; w^2 r (w dt)^2/12 for an "
            "attitude updated to second order a step; single-precision rounding of what is differenced",
        ),
        Check(
            gyroscope_ideal_error,
            lambda _, p: 64 * SINGLE * p.spin_up * DURATION,
            "a steady torque is integrated exactly by every integrator; what is left is the rounding of its sum, in "
            "single precision",
        ),
    ),
)
