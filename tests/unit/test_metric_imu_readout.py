"""The digits of an inertial channel: the harness's own read-out makes no error, and each planted fault is a step or more."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.cases import sensor_imu_readout
from plumbline.cases.sensor_imu_readout import ACCELEROMETER, GYROSCOPE, MOUNTING, RATE, SPIN_UP, G
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.readings import inertial_readout_error
from plumbline.harness.scene import AxisNoise
from plumbline.harness.sensors.imu import read_out, sensed
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate_back

CASE = sensor_imu_readout.CASE
SCENE = CASE.scene(CASE.parameters)


def heard(law: dict[str, AxisNoise] | None = None) -> Trajectory:
    """What the harness makes of the case's true signals by a law of each channel."""
    truth = CASE.expected(np.arange(0.0, CASE.duration + 1e-9, 1 / RATE), CASE.parameters)  # type: ignore[misc]
    streams = dict(truth.streams)
    for channel, own in (law or {"accelerometer": ACCELEROMETER, "gyroscope": GYROSCOPE}).items():
        streams[f"imu/{channel}"] = read_out(own, sensed(own, streams[f"imu/{channel}_ideal"]))
    return replace(truth, streams=streams)


def error(**changed: object) -> float:
    laws = {"accelerometer": replace(ACCELEROMETER, **changed), "gyroscope": replace(GYROSCOPE, **changed)}  # type: ignore[arg-type]
    return inertial_readout_error(SCENE, heard(laws))


def test_the_harness_reads_out_what_its_law_says() -> None:
    assert inertial_readout_error(SCENE, heard()) <= 1e-9


def test_signals_reach_their_bounds_and_many_levels() -> None:
    run = heard()
    for channel, law in (("accelerometer", ACCELEROMETER), ("gyroscope", GYROSCOPE)):
        reading = run.streams[f"imu/{channel}"]
        assert law.saturation is not None
        assert np.abs(reading).max() == pytest.approx(law.saturation, abs=law.quantisation)
        assert np.abs(run.streams[f"imu/{channel}_ideal"]).max() > 1.04 * law.saturation
    assert len(np.unique(run.streams["imu/gyroscope"])) > 100


@pytest.mark.parametrize(
    "changed",
    [
        {"misalignment": (0.0, 0.0, 0.0)},
        {"scale_error": 0.0},
        {"saturation": None},
        {"quantisation": 0.0},
    ],
)
def test_each_part_of_the_law_that_is_left_out_is_seen(changed: dict[str, object]) -> None:
    # A wrong level is a whole step; without rounding the distance to the next level comes near to half a step.
    assert error(**changed) > (0.4 if "quantisation" in changed else 0.9)


def test_rounding_down_is_seen() -> None:
    run = heard({"accelerometer": replace(ACCELEROMETER, quantisation=0.0), "gyroscope": replace(GYROSCOPE, quantisation=0.0)})
    streams = dict(run.streams)
    for channel, law in (("accelerometer", ACCELEROMETER), ("gyroscope", GYROSCOPE)):
        below: Floats = law.quantisation * np.floor(streams[f"imu/{channel}"] / law.quantisation)
        streams[f"imu/{channel}"] = below
    assert inertial_readout_error(SCENE, replace(run, streams=streams)) == pytest.approx(1.0)


def test_a_signal_half_way_between_two_levels_may_go_to_either() -> None:
    law = AxisNoise(quantisation=1.0)
    imu = replace(SCENE.sensors[0], noise=replace(SCENE.sensors[0].noise, accelerometer=law, gyroscope=law))  # type: ignore[union-attr,type-var,call-arg,arg-type]
    scene = replace(SCENE, sensors=(imu,))
    signal = np.array([[0.5, 1.5, -2.5], [0.25, 0.75, -0.6]])
    for reading in ([[0.0, 1.0, -3.0], [0.0, 1.0, -1.0]], [[1.0, 2.0, -2.0], [0.0, 1.0, -1.0]]):
        streams = {"imu/time": np.arange(2.0)}
        for channel in ("accelerometer", "gyroscope"):
            streams |= {f"imu/{channel}_ideal": signal, f"imu/{channel}": np.array(reading)}
        assert inertial_readout_error(scene, replace(Trajectory.of(np.zeros(1), 1), streams=streams)) <= 1e-9


def test_a_sensor_with_noise_or_without_digits_is_not_measured() -> None:
    with pytest.raises(NotMeasurable, match="no inertial channel"):
        inertial_readout_error(replace(SCENE, sensors=()), heard())


def test_the_truth_is_the_weight_and_the_spin_seen_from_the_mount() -> None:
    """By SciPy's rotations, at the end of the run, where the spin is at over T."""
    from scipy.spatial.transform import Rotation

    truth = heard()
    back = Rotation.from_quat(MOUNTING, scalar_first=True).inv()
    assert truth.streams["imu/accelerometer_ideal"][-1] == pytest.approx(back.apply([0.0, 0.0, G]))
    assert truth.streams["imu/gyroscope_ideal"][-1] == pytest.approx(back.apply([0.0, 0.0, SPIN_UP * CASE.duration]))
    assert np.allclose(rotate_back(np.array(MOUNTING), np.array([0.0, 0.0, G])), back.apply([0.0, 0.0, G]))
