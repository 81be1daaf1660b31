"""An inertial sensor in free fall: does it feel nothing, whatever the speed, and turn as it was thrown?"""

from dataclasses import replace

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import SINGLE, G
from plumbline.harness.metrics.readings import accelerometer_ideal_error, gyroscope_ideal_error
from plumbline.harness.scene import Body, Imu, Scene, axis_angle
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about, rotate_back

DURATION, RATE = 2.0, 60.0
MOUNTING = axis_angle((1.0, 2.0, -0.5), 0.7)


class P(Parameters):
    speed: float = 5.0
    spin: NotNegative = 2.0


def scene(p: P) -> Scene:
    """A ball thrown up and forwards at `speed` [m/s] each, spinning about z, with a sensor at its centre, turned against it."""
    ball = Body.ball("ball", 0.5, touches=False, v_WB=(p.speed, 0.0, p.speed), w_WB=(0.0, 0.0, p.spin))
    return Scene(bodies=(ball,), sensors=(Imu(name="imu", body="ball", rate=RATE, q_BS=MOUNTING),))


def expected(time: Floats, p: P) -> Trajectory:
    """The parabola and a steady turn; a sensor that falls with its body feels no force."""
    truth = Trajectory.of(time, 1)
    t = truth.time
    truth.p_WB[:, 0, 0], truth.p_WB[:, 0, 2] = p.speed * t, p.speed * t - G * t * t / 2
    truth.v_WB[:, 0, 0], truth.v_WB[:, 0, 2] = p.speed, p.speed - G * t
    truth.q_WB[:, 0], truth.w_WB[:, 0, 2] = about(2, p.spin * t), p.spin
    count = int(np.floor(float(t[-1]) * RATE + 1e-6)) if len(truth) else 0
    streams = {"imu/time": np.arange(1, count + 1) / RATE, "imu/accelerometer_ideal": np.zeros((count, 3))}
    streams["imu/gyroscope_ideal"] = np.tile(rotate_back(np.array(MOUNTING), np.array([0.0, 0.0, p.spin])), (count, 1))
    return replace(truth, streams=streams)


CASE = Case.of(
    globals(),
    title="Inertial sensor in free fall",
    question="Does a sensor that falls with its body feel no force, and turn as its body does?",
    source="Titterton, Weston, Strapdown Inertial Navigation Technology, 2nd ed., section 3.5: specific force is a - g",
    truth="closed form",
    checks=(
        Check(
            accelerometer_ideal_error,
            lambda _, p: 8 * SINGLE * (p.speed + G * DURATION) * RATE,
            "every integrator makes v' = v + g dt exactly, so that what is left is the rounding of velocities "
            "in single precision over one interval",
        ),
        Check(
            gyroscope_ideal_error,
            lambda _, p: 16 * SINGLE * p.spin,
            "no torque acts, so the rate stays what it was; a few roundings in single precision",
        ),
    ),
)
