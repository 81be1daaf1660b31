"""Inertial sensors on a body that is shaken: how late do their readings tell of it?"""

from dataclasses import replace

import numpy as np

from plumbline.harness.case import Case, Check, Parameters, Positive, Step
from plumbline.harness.case.forces import Control
from plumbline.harness.metrics.readings import accelerometer_lag_error, gyroscope_lag_error, time_stamp_error
from plumbline.harness.scene import Body, Imu, Scene, axis_angle, sphere_inertia
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import about, rotate_back

DURATION, RATE, LATENCY = 3.0, 60.0, 0.025
FREQUENCY = 1.5
PUSH, TURN = 3.0, 2.0
"""Amplitudes of acceleration [m/s2] and of angular acceleration [rad/s2]."""
MASS, RADIUS = 2.0, 0.5
MOUNTING = axis_angle((1.0, 2.0, -0.5), 0.7)


class P(Parameters):
    frequency: Positive = FREQUENCY


def scene(_: P) -> Scene:
    """A ball with two sensors: one that the engine may read by its own means, one that differences velocities and is late."""
    ball = Body.ball("ball", RADIUS, mass=MASS, touches=False)
    own = Imu(name="own", body="ball", rate=RATE, q_BS=MOUNTING)
    late = Imu(name="late", body="ball", rate=RATE, q_BS=MOUNTING, reading="states", latency=LATENCY)
    return Scene(bodies=(ball,), sensors=(own, late), gravity=(0.0, 0.0, 0.0))


def control(p: P) -> Control:
    """Force and torque along z as sin and cos of the time, so that the turning does not mix the axes."""
    inertia = sphere_inertia(MASS, RADIUS)[2][2]

    def wrench(time: float, _state: State) -> tuple[Floats, Floats]:
        phase = 2 * np.pi * p.frequency * time
        force = np.array([[0.0, 0.0, MASS * PUSH * np.sin(phase)]])
        return force, np.array([[0.0, 0.0, inertia * TURN * np.cos(phase)]])

    return Control(wrench=wrench)


def expected(time: Floats, p: P) -> Trajectory:
    """What is there to be felt at the instants of the time stamps: a sin(Wt), and b/W sin(Wt) turning."""
    truth = Trajectory.of(time, 1)
    pulse = 2 * np.pi * p.frequency
    t = truth.time
    # From rest: z' = a (1 - cos Wt)/W.
    truth.v_WB[:, 0, 2] = PUSH * (1 - np.cos(pulse * t)) / pulse
    truth.p_WB[:, 0, 2] = PUSH * (t - np.sin(pulse * t) / pulse) / pulse
    angle = TURN * (1 - np.cos(pulse * t)) / pulse**2
    truth.q_WB[:, 0] = about(2, angle)
    truth.w_WB[:, 0, 2] = TURN * np.sin(pulse * t) / pulse
    count = int(np.floor(float(t[-1]) * RATE + 1e-6)) if len(truth) else 0
    streams: dict[str, Floats] = {}
    for name, first in (("own", 1), ("late", 1 + int(np.ceil(LATENCY * RATE)))):
        stamps = np.arange(first, count + 1) / RATE
        wave = np.stack([0 * stamps, 0 * stamps, np.sin(pulse * stamps)], axis=1)
        askew = rotate_back(np.tile(MOUNTING, (len(stamps), 1)), wave)
        streams |= {f"{name}/time": stamps, f"{name}/accelerometer_instant": PUSH * askew}
        streams[f"{name}/gyroscope_instant"] = TURN / pulse * askew
    return replace(truth, streams=streams)


def _late(dt: Step, _: P) -> float:
    """[s]: a force that is held over a step between two calls, or the one told last."""
    return dt.outer + 1e-6


CASE = Case.of(
    globals(),
    title="Lag of inertial sensors",
    question="Are readings of a shaken body late by their latency alone, plus half an interval where they are differences?",
    source="Knapp, Carter, The generalized correlation method for estimation of time delay (1976); centre of a difference",
    truth="closed form",
    dt=1 / 240,
    ladder=(1 / 120, 1 / 240, 1 / 360, 1 / 480, 1 / 960),
    checks=(
        Check(
            accelerometer_lag_error,
            _late,
            "a force told at the start of a step and held acts half a step late, and a sensor that is asked at its end "
            "feels it a whole step late; a microsecond for the spline through the signal",
        ),
        Check(
            gyroscope_lag_error,
            _late,
            "a torque told at the start of a step and held acts half a step late, and a damping of the vendor's shifts "
            "the phase; one step is granted",
        ),
        Check(time_stamp_error, 8 * 2.0**-52 * DURATION, "a few roundings of the time"),
    ),
)
