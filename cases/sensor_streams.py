"""Random streams of several sensors: is each axis of each one alone, normal and white, and are the time stamps exact?"""

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.metrics import inertial_noise, ranges, readings
from plumbline.harness.scene import WORLD, AxisNoise, Body, Imu, ImuNoise, Lidar, LidarNoise, Plane, Scene, axis_angle
from plumbline.harness.trajectory import Floats, Trajectory

DURATION, RATE, SCANS, LATENCY = 30.0, 200.0, 10.0, 0.015
GYROSCOPE = AxisNoise(density=2e-4, bias=0.01, scale_error=2e-3, misalignment=(0.01, -0.02, 0.005))
ACCELEROMETER = AxisNoise(
    density=2e-3, bias=0.1, random_walk=1e-3, scale_error=-1e-3, misalignment=(-0.02, 0.01, 0.0), saturation=40.0
)


class P(Parameters):
    density: NotNegative = GYROSCOPE.density


def scene(p: P) -> Scene:
    """Two inertial sensors of one law and a range finder, hung in the world above a floor; one inertial sensor is late."""
    law = ImuNoise(
        accelerometer=ACCELEROMETER,
        gyroscope=AxisNoise(
            density=p.density, bias=GYROSCOPE.bias, scale_error=GYROSCOPE.scale_error, misalignment=GYROSCOPE.misalignment
        ),
    )
    mount = axis_angle((1.0, 2.0, -0.5), 0.7)
    floor = Body.fixed("floor", Plane())
    sensors = (
        Imu(name="left", body=WORLD, rate=RATE, q_BS=mount, noise=law),
        Imu(name="right", body=WORLD, rate=RATE, q_BS=mount, latency=LATENCY, noise=law),
        Lidar(
            name="lidar",
            body=WORLD,
            rate=SCANS,
            p_BS=(0.0, 0.0, 2.0),
            channels=4,
            columns=8,
            elevation_low=-0.8,
            elevation_high=-0.4,
            noise=LidarNoise(range_sigma=0.02),
        ),
    )
    return Scene(bodies=(floor,), sensors=sensors)


def expected(time: Floats, _: P) -> Trajectory:
    """Nothing moves."""
    return Trajectory.of(time, 1)


PAIRS = 66
"""Of twelve noisy axes."""
FIVE = "five standard deviations: each comparison raises a false alarm in 6 of 10 million runs, "

CASE = Case.of(
    globals(),
    title="Random streams of sensors",
    question="Is the noise of two sensors, of two channels and of two axes independent, and do readings come when they should?",
    source="Bartlett (1935); Welch (1967); Kolmogorov (1933); Pearson (1900)",
    truth="statistics",
    sample_interval=1.0,
    dt=1 / 200,
    ladder=(1 / 200, 1 / 400, 1 / 600, 1 / 800),
    checks=(
        Check(
            inertial_noise.inertial_correlation_score,
            4.0,
            f"4/sqrt(N): the largest of {PAIRS} pairs of independent axes exceeds it under 4 of 1000 seeds, and the "
            "seed is the run's own; equal streams reach sqrt(N)",
        ),
        Check(inertial_noise.inertial_spectrum_score, 5.0, FIVE + f"the largest of {12 * 6} octaves in 4 of 100 000"),
        Check(
            inertial_noise.inertial_distribution_distance,
            2.73,
            "Kolmogorov: sqrt(n) D exceeds x with probability 2 exp(-2 x^2), 7 in 10 million at 2.73",
        ),
        Check(inertial_noise.inertial_histogram_score, 5.0, FIVE + "the largest of 12 in 7 of a million"),
        Check(ranges.range_mean_score, 5.0, FIVE + "of one"),
        Check(ranges.range_spread_score, 5.0, FIVE + "of one"),
        Check(ranges.range_correlation_score, 5.0, FIVE + "the largest of three"),
        Check(
            readings.time_stamp_error,
            8 * float(np.finfo(np.float64).eps) * DURATION,
            "stamps are multiples of the interval to a few roundings, with none left out",
        ),
    ),
)
