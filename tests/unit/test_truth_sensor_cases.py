"""Truths of the sensor cases: the ideal signals against independent routes, and the premises of their bounds."""

import mpmath
import numpy as np
import pytest

from plumbline.cases.sensor_imu_noise import CASE as IMU
from plumbline.cases.sensor_imu_noise import RATE
from plumbline.cases.sensor_lidar_noise import CASE as LIDAR
from plumbline.cases.sensor_lidar_noise import GRAZING, REFLECTIVITY
from plumbline.harness.scene import Imu, Lidar, rotation_matrix
from plumbline.harness.sensors import lidar as scanning
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.trajectory import State, Trajectory


@pytest.mark.parametrize(("spin", "lever"), [(2.0, 0.3), (-7.0, 1.5), (0.01, 0.05)])
def test_the_mean_specific_force_on_a_circle_equals_its_integral_in_mpmath(spin: float, lever: float) -> None:
    truth = IMU.truth_at(np.array([0.0, 0.5]), {"spin": spin, "lever": lever})
    assert isinstance(truth, Trajectory)
    imu = IMU.scene(IMU.at(spin=spin, lever=lever)).sensors[0]
    assert isinstance(imu, Imu)
    # The acceleration -w^2 r (cos, sin) over one interval, averaged, seen from the attitude in its middle (angle 0).
    with mpmath.workdps(30):
        half = mpmath.mpf(1) / (2 * mpmath.mpf(RATE))
        mean = mpmath.quad(lambda t: -(mpmath.mpf(spin) ** 2) * lever * mpmath.cos(spin * t), [-half, half]) / (2 * half)
    turn = np.array(rotation_matrix(imu.q_BS)).T
    expected = turn @ np.array([float(mean), 0.0, 0.0])
    np.testing.assert_allclose(truth.streams["imu/accelerometer_ideal"], np.tile(expected, (60, 1)), rtol=1e-12, atol=1e-15)
    expected_rate = np.tile(turn @ np.array([0, 0, spin]), (60, 1))
    np.testing.assert_allclose(truth.streams["imu/gyroscope_ideal"], expected_rate, atol=1e-14)
    np.testing.assert_allclose(truth.streams["imu/time"], np.arange(1, 61) / RATE, atol=1e-15)


def _scan(tilt: float) -> tuple[Lidar, np.ndarray, np.ndarray]:
    scene = LIDAR.scene(LIDAR.at(tilt=tilt))
    lidar = scene.sensors[0]
    assert isinstance(lidar, Lidar)
    carrier = scene.body("carrier")
    return lidar, *scanning.in_world(lidar, np.array(carrier.p_WB), np.array(carrier.q_WB))


def test_the_truth_of_the_room_has_one_scan_for_each_reading_and_no_open_beam() -> None:
    truth = LIDAR.truth_at(np.linspace(0.0, LIDAR.duration, 11), LIDAR.parameters)
    assert isinstance(truth, Trajectory)
    assert truth.streams["lidar/range_ideal"].shape == (11, 32, 360)
    assert np.isfinite(truth.streams["lidar/range_ideal"]).all()


def test_all_shapes_of_the_room_are_seen() -> None:
    scene = LIDAR.scene(LIDAR.parameters)
    _, origins, directions = _scan(0.1)
    seen = set(first_hits(scene, State.initial(scene), origins, directions, 20.0).body.tolist())
    assert {scene.bodies[i].name for i in seen} >= {
        "floor",
        "east",
        "west",
        "north",
        "south",
        "ball",
        "box",
        "capsule",
        "cylinder",
    }


def test_no_beam_grazes_more_than_the_bound_says_and_none_hangs_on_an_edge() -> None:
    scene = LIDAR.scene(LIDAR.parameters)
    start = State.initial(scene)
    _, origins, directions = _scan(0.1)
    hits = first_hits(scene, start, origins, directions, 20.0)
    assert np.abs(np.sum(hits.normal_W * directions, axis=1)).min() > GRAZING
    # Beams turned by 1e-6 rad, sixteen times the rounding of a direction in single precision, meet the same bodies.
    rng = np.random.default_rng(1)
    for _ in range(4):
        moved = directions + 1e-6 * rng.uniform(-1, 1, directions.shape)
        moved /= np.linalg.norm(moved, axis=1, keepdims=True)
        np.testing.assert_array_equal(first_hits(scene, start, origins, moved, 20.0).body, hits.body)


def test_intensity_is_lamberts_cosine_of_the_closed_form_normal() -> None:
    scene = LIDAR.scene(LIDAR.parameters)
    lidar, origins, directions = _scan(0.1)
    hits = first_hits(scene, State.initial(scene), origins, directions, 20.0)
    floor = hits.body == scene.index("floor")
    _, intensity = scanning.ideal(lidar, scene, directions, hits)
    np.testing.assert_allclose(intensity.ravel()[floor], REFLECTIVITY * -directions[floor, 2], atol=1e-14)
    assert (intensity <= REFLECTIVITY + 1e-14).all()


@pytest.mark.parametrize("case", [IMU, LIDAR], ids=lambda c: c.name)
def test_every_step_of_the_ladder_is_a_divisor_of_the_sensors_interval(case: object) -> None:
    from plumbline.harness.case import Case
    from plumbline.harness.sensors.recorder import steps_between_readings

    assert isinstance(case, Case)
    scene = case.scene(case.parameters)
    for dt in (case.dt, *case.ladder):
        assert all(steps_between_readings(sensor, dt) >= 1 for sensor in scene.sensors)
