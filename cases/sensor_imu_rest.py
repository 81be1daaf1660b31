"""An inertial sensor on a box that stands on the ground: does it read -R^T g, as upward as gravity is downward?"""

from dataclasses import replace

import numpy as np

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics.readings import accelerometer_ideal_error, gyroscope_ideal_error, time_stamp_error
from plumbline.harness.scene import Body, Imu, Scene, Surface, axis_angle
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate_back

DURATION, SETTLED, RATE = 3.0, 2.0, 60.0
HALF = 0.1
MOUNTING = axis_angle((1.0, 2.0, -0.5), 0.7)
BORNE = 0.01
"""How well a ground has to carry a weight that rests on it, as a share of the weight [1]."""


def scene(_: Parameters) -> Scene:
    """A box that just touches a smooth plane, with a sensor off its centre, turned against it."""
    half = (HALF, HALF, HALF)
    box = Body.box("box", half, p_WB=(0.0, 0.0, HALF))
    imu = Imu(name="imu", body="box", rate=RATE, p_BS=(0.05, -0.03, 0.08), q_BS=MOUNTING)
    return Scene(bodies=(Body.ground("default"), box), surfaces=(Surface(),), sensors=(imu,))


def expected(time: Floats, p: Parameters) -> Trajectory:
    """Rest, in which the sensor feels the ground's push g upwards."""
    truth = Trajectory.at_rest(scene(p), time)
    count = int(np.floor(float(truth.time[-1]) * RATE + 1e-6)) if len(truth) else 0
    felt = rotate_back(np.array(MOUNTING), np.array([0.0, 0.0, G]))
    streams = {"imu/time": np.arange(1, count + 1) / RATE}
    streams["imu/accelerometer_ideal"] = np.tile(felt, (count, 1))
    streams["imu/gyroscope_ideal"] = np.zeros((count, 3))
    return replace(truth, streams=streams)


EDGE = BORNE * G / (2 / 3 * HALF)
"""Angular acceleration [rad/s2] by that share of the weight at the box's edge: m g a over 2/3 m a^2."""
ARM = 0.1

CASE = Case.of(
    globals(),
    title="Inertial sensor at rest",
    question="Does a sensor on a box that stands still read gravity upwards in its own frame, and no turning?",
    source="Titterton, Weston, Strapdown Inertial Navigation Technology, 2nd ed., section 3.5: f = -R^T g",
    truth="rest",
    checks=(
        Check(
            accelerometer_ideal_error,
            BORNE * G + EDGE * ARM,
            "a ground that carries the weight to one part in a hundred lets the box accelerate by that share of g, and "
            "where the share acts at an edge, turn by g/(2/3 a) of it, felt at the sensor's arm of .1 m",
            start=SETTLED,
        ),
        Check(
            gyroscope_ideal_error,
            EDGE / RATE,
            "that angular acceleration during one interval of the sensor, after which the other edge pushes back",
            start=SETTLED,
        ),
        Check(time_stamp_error, 8 * 2.0**-52 * DURATION, "a few roundings of the time"),
    ),
)
