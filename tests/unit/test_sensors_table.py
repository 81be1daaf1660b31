"""The findings of sensors on planted readings: each planted fault is seen, and what keeps its law is left alone."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.harness.findings.sensor_readings.channel import Channel, channels, rays_of
from plumbline.harness.findings.sensor_readings.depth import depth_sigma, range_histogram
from plumbline.harness.findings.sensor_readings.findings import SensorFinding, findings
from plumbline.harness.findings.sensor_readings.ideal import ideal_errors, lag_of
from plumbline.harness.findings.sensor_readings.inertial import allan_curve, inertial_noise
from plumbline.harness.findings.tables import sensors as table
from plumbline.harness.scene import AxisNoise, Camera, DepthCamera, Imu, ImuNoise, Lidar
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Trajectory
from tests.sensor_folder import BEAMS, CASE, LATENCY, PIXELS, scene, sensing, told, write_sensor_folder


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(write_sensor_folder(tmp_path_factory.mktemp("sensors") / "run"))


def of(store: Store, engine: str, sensor: str, channel: str) -> SensorFinding:
    return next(one for one in findings(store) if (one.engine, one.sensor, one.channel) == (engine, sensor, channel))


def arrays_of(run: Trajectory, truth: Mapping[str, Any] | None = None) -> dict[str, Any]:
    states = {name: getattr(run, name) for name in ("time", "p_WB", "q_WB", "v_WB", "w_WB")}
    signals = {f"stream:{name}": signal for name, signal in run.streams.items()}
    return states | signals | {f"truth_stream:{name}": signal for name, signal in (told() if truth is None else truth).items()}


def channel_of(run: Trajectory, sensor: str, channel: str, truth: Mapping[str, Any] | None = None) -> Channel:
    found = channels(scene(), arrays_of(run, truth))
    return next(one for one in found if (one.name, one.channel) == (sensor, channel))


def test_every_channel_of_every_sensor_is_a_row_with_the_named_columns(store: Store) -> None:
    rows = table.TABLE.rows(store)
    mine = [(row["sensor"], row["channel"]) for row in rows if row["engine"] == "reference"]
    assert mine == [
        ("imu", "accelerometer"), ("imu", "gyroscope"), ("lidar", "range"), ("lidar", "intensity"),
        ("depth", "depth"), ("camera", "colour"), ("camera", "depth"), ("camera", "body"),
    ]  # fmt: skip
    assert all(tuple(row) == table.TABLE.columns for row in rows)
    assert [len(table.TABLE.brief(row)) for row in table.TABLE.objects(store)] == [len(table.TABLE.shown)] * len(rows)


def test_a_trial_without_readings_is_a_row_with_its_outcome_and_its_reason(store: Store) -> None:
    silent = {one.engine: one for one in findings(store) if not one.channel}
    assert silent["bullet"].status == "unsupported"
    assert silent["bullet"].reason == "image of camera 'camera': no renderer"
    assert silent["dart"].reason == "by step 3 of 9: the state is not finite"


def test_a_clean_engine_keeps_every_law_and_a_planted_fault_breaks_its_own(store: Store) -> None:
    """At 99.99 % of a known spread: the planted faults are ten times farther off."""
    for sensor, channel in (("imu", "gyroscope"), ("lidar", "range"), ("depth", "depth")):
        clean, loud = (of(store, engine, sensor, channel) for engine in ("reference", "mujoco"))
        assert clean.noise.sigma_law is not None
        assert clean.noise.sigma is not None
        assert clean.noise.sigma.value == pytest.approx(clean.noise.sigma_law, rel=4 / math.sqrt(2 * 4000))
        assert loud.noise.sigma is not None
        if sensor != "depth":
            assert loud.noise.sigma.ends[0] > 1.5 * clean.noise.sigma_law
            assert loud.noise.sigma.value == pytest.approx(2 * clean.noise.sigma_law, rel=0.1)


def test_a_share_of_lost_returns_lies_in_its_interval_and_a_biased_one_does_not(store: Store) -> None:
    clean, biased = (of(store, engine, "lidar", "range") for engine in ("reference", "mujoco"))
    assert clean.noise.lost is not None
    assert biased.noise.lost is not None
    assert clean.noise.lost.ends[0] < 0.1 < clean.noise.lost.ends[1]
    assert biased.noise.lost.ends[0] > 0.2
    # Beams that meet nothing have nothing to lose: 8 of 512 in each of ten scans.
    assert clean.noise.lost.value * 5040 == pytest.approx(round(clean.noise.lost.value * 5040), abs=1e-9)


def test_pixels_that_got_lost_are_counted_among_those_that_could_answer(store: Store) -> None:
    depth = of(store, "reference", "depth", "depth")
    assert depth.noise.lost_law == 0.05
    assert depth.noise.lost is not None
    assert depth.noise.lost.ends[0] < 0.05 < depth.noise.lost.ends[1]


def test_the_error_of_an_ideal_signal_is_the_planted_one_and_stands_beside_its_check(store: Store) -> None:
    exact, off = (of(store, engine, "lidar", "range") for engine in ("reference", "mujoco"))
    assert exact.error_max == 0.0
    assert exact.passed
    assert off.error_max == pytest.approx(1e-3, rel=1e-9)
    assert off.error_median == pytest.approx(1e-3, rel=1e-9)
    assert (off.metric, off.at_most, off.passed) == ("range_error_max", 1e-6, False)
    turning = of(store, "mujoco", "imu", "gyroscope")
    assert turning.error_max == pytest.approx(math.sqrt(3) * 1e-3, rel=1e-9)
    assert of(store, "reference", "camera", "body").disagree == 0.0


def test_a_latency_is_found_and_a_steady_motion_tells_none(store: Store) -> None:
    turning, force = (of(store, "reference", "imu", channel) for channel in ("gyroscope", "accelerometer"))
    # Samples of 50 ms under a swing of 1.3 rad/s: a spline through them is good to (1.3 * 0.05)^4, under a ten thousandth.
    assert turning.lag == pytest.approx(LATENCY, abs=1e-4)
    assert turning.lag_law == LATENCY
    assert force.lag_law == pytest.approx(LATENCY + 0.005)
    late = channel_of(sensing(1, late=0.01), "imu", "gyroscope")
    assert lag_of(late, scene(), arrays_of(sensing(1))) == pytest.approx(LATENCY + 0.01, abs=1e-4)
    still = dataclasses.replace(late, ideal=np.ones_like(late.ideal))
    assert lag_of(still, scene(), arrays_of(sensing(1))) is None
    trembling = dataclasses.replace(late, ideal=1e-5 * late.ideal)
    assert lag_of(trembling, scene(), arrays_of(sensing(1))) is None


def test_a_motion_that_the_signal_does_not_tell_of_has_no_lag() -> None:
    run = sensing(1)
    other = dataclasses.replace(channel_of(run, "imu", "gyroscope"), ideal=np.random.default_rng(0).standard_normal((6000, 3)))
    assert lag_of(other, scene(), arrays_of(run)) is None


def test_rays_a_second_come_from_the_trials_that_clocked_them(store: Store) -> None:
    one = of(store, "reference", "lidar", "range")
    rays = sum(rays_of(sensor) for sensor in scene().sensors)
    assert rays == BEAMS[0] * BEAMS[1] + 2 * PIXELS[0] * PIXELS[1]
    assert one.rays_per_s == pytest.approx(rays / 2e-3)
    assert one.bare_rays_per_s == pytest.approx(1e7)
    assert one.trial_bare != one.trial == one.trial_sensing
    assert of(store, "reference", "imu", "gyroscope").rays_per_s is None


def test_a_range_that_is_no_number_leaves_no_finite_error() -> None:
    run = sensing(1)
    run.streams["lidar/range_ideal"][3, 2, 5] = np.nan  # type: ignore[index]
    errors = ideal_errors(channel_of(run, "lidar", "range"))
    assert errors.error_max is not None
    assert math.isnan(errors.error_max)
    assert errors.disagree == pytest.approx(1 / (10 * 512))


def test_a_beam_that_meets_another_surface_disagrees_and_spoils_no_error() -> None:
    run = sensing(1)
    run.streams["lidar/range_ideal"][0, 1, 0] = 3.0  # type: ignore[index]
    run.streams["lidar/range_ideal"][0, 1, 1] = np.inf  # type: ignore[index]
    errors = ideal_errors(channel_of(run, "lidar", "range"))
    assert errors.error_max == 0.0
    assert errors.disagree == pytest.approx(2 / (10 * 512))


def test_a_truth_at_other_times_is_told_and_gives_no_error() -> None:
    truth = told()
    truth["lidar/time"] = truth["lidar/time"] + 1e-3
    errors = ideal_errors(channel_of(sensing(1), "lidar", "range", truth))
    assert errors.error_max is None
    assert errors.why == "the truth stands at other times than the readings"


def test_normals_that_an_engine_does_not_give_are_told() -> None:
    run = sensing(1)
    run.streams["lidar/intensity_ideal"][:] = np.nan  # type: ignore[index]
    assert ideal_errors(channel_of(run, "lidar", "intensity")).why == "the engine gives no normals where its rays hit"


def test_an_allan_deviation_lies_in_the_band_of_its_law_and_doubled_noise_twice_above_it() -> None:
    clean, loud = (allan_curve(channel_of(sensing(3, louder=k), "imu", "gyroscope")) for k in (1.0, 2.0))
    assert clean is not None
    assert loud is not None
    # White noise of density N: N / sqrt(tau), by IEEE Std 952.
    assert clean.law == pytest.approx(2e-3 / np.sqrt(clean.at), rel=1e-9)
    assert clean.found[:6] == pytest.approx(clean.law[:6], rel=0.1)
    assert loud.found[:6] == pytest.approx(2 * loud.law[:6], rel=0.1)
    assert (clean.low < clean.law).all()
    assert (clean.law < clean.high).all()


def _inertial(law: AxisNoise, read: Any, ideal: Any) -> Channel:
    base = channel_of(sensing(1), "imu", "gyroscope")
    imu = Imu(name="imu", body="carrier", rate=100.0, noise=ImuNoise(gyroscope=law))
    return dataclasses.replace(base, sensor=imu, read=read, ideal=ideal)


def test_a_turned_and_stretched_triad_is_taken_off_before_its_noise_is_told() -> None:
    law = AxisNoise(density=1e-3, bias=0.1, misalignment=(0.0, 0.0, np.pi / 2), scale_error=0.5)
    ideal = np.random.default_rng(5).uniform(1.0, 2.0, (4000, 3))
    # A triad turned by a quarter about z reads (y, -x, z) of a vector (x, y, z).
    turned = 1.5 * np.stack([ideal[:, 1], -ideal[:, 0], ideal[:, 2]], axis=1)
    noise = inertial_noise(_inertial(law, turned + 0.1 + 1e-2 * np.random.default_rng(6).standard_normal((4000, 3)), ideal))
    assert noise is not None
    assert noise.sigma is not None
    assert noise.bias is not None
    assert noise.sigma.value == pytest.approx(1e-2, rel=0.05)
    assert noise.bias.value == pytest.approx(0.1, abs=4e-4)


def test_readings_at_the_bound_are_told_and_give_no_spread() -> None:
    law = AxisNoise(density=1e-3, saturation=2.0)
    noise = inertial_noise(_inertial(law, np.full((200, 3), 2.0), np.full((200, 3), 2.5)))
    assert noise is not None
    assert noise.sigma is None
    assert noise.why == "100 % of the readings end at the bound of 2 rad/s"


def test_a_histogram_of_range_errors_is_a_density_and_sees_a_doubled_spread() -> None:
    clean, loud = (range_histogram(channel_of(sensing(4, louder=k), "lidar", "range")) for k in (1.0, 2.0))
    assert clean is not None
    assert loud is not None
    width = clean.at[1] - clean.at[0]
    assert float(clean.found.sum() * width) + clean.beyond / clean.count == pytest.approx(1.0)
    # 19 of 20 bins: of 32, fewer than 24 inside would be one in a hundred thousand.
    assert np.sum((clean.found >= clean.low) & (clean.found <= clean.high)) >= 24
    assert np.sum((loud.found >= loud.low) & (loud.found <= loud.high)) < 12


def test_the_spread_of_depth_grows_as_each_principle_says() -> None:
    camera = DepthCamera(name="c", body="b", rate=1.0, width=2, height=1, focal_x=1.0, focal_y=1.0, centre_x=0.5, centre_y=0.5)
    depth = np.full((1, 1, 2), 2.0)
    # z^2 sigma / (f b) with a step's variance of 1/12 beside it.
    stereo = depth_sigma(camera, {"disparity_sigma": 0.5, "disparity_step": 1.0, "baseline": 0.25}, depth)
    assert stereo == pytest.approx(np.full((1, 1, 2), 16.0 * math.sqrt(0.25 + 1 / 12)))
    # The second pixel looks aside by 45 degrees: its range is sqrt(2) times its depth.
    phase = depth_sigma(camera, {"range_sigma": 0.01, "range_sigma_slope": 0.1}, depth)
    assert phase is not None
    assert phase[0, 0] == pytest.approx([0.01 + 0.2, 0.01 / math.sqrt(2) + 0.2])
    assert depth_sigma(camera, {"range_sigma": 0.01, "shot_sigma": 0.1}, depth) is None


def test_depth_errors_over_depth_follow_the_law(store: Store) -> None:
    levels = of(store, "reference", "depth", "depth").curve
    assert levels is not None
    assert (np.diff(levels.at) > 0).all()
    assert levels.found == pytest.approx(levels.law, rel=0.25)
    assert np.mean((levels.low < levels.law) & (levels.law < levels.high)) > 0.7


def test_rays_are_counted_by_beams_and_pixels() -> None:
    assert rays_of(Lidar(name="l", body="b", rate=1.0, channels=32, columns=1024)) == 32768
    assert rays_of(Camera(name="c", body="b", rate=1.0, width=64, height=48)) == 3072
    assert rays_of(Imu(name="i", body="b", rate=1.0)) == 0


def test_the_sentences_say_who_keeps_its_bounds_and_what_a_read_ray_costs(store: Store) -> None:
    said = table.TABLE.said(store)
    assert "reference: 2 of 2 ideal signals stay within their bounds." in said
    assert "mujoco: 0 of 2 ideal signals stay within their bounds." in said
    assert "bullet: no readings in 1 run." in said
    # Cameras share the price of this scene, so it says nothing of a beam.
    assert not any("bare" in text for text in said)
    (row,) = [row for row in table.TABLE.objects(store) if (row.engine, row.channel) == ("reference", "range")]
    assert row.times_bare is None
    said = table.sentences([replace(row, times_bare=1.9)])
    assert f"{CASE}: on reference, tuned, a ray that is read costs 1.9 bare ones." in said
    titles = {CASE: "Room with a wall", "reference": "Plumbline reference engine"}
    spoken = table.sentences([replace(row, times_bare=1.9)], titles)
    assert spoken == [
        "Plumbline reference engine: 1 of 1 ideal signals stay within their bounds.",
        "Room with a wall: on Plumbline reference engine, tuned, a ray that is read costs 1.9 bare ones.",
    ]


def test_a_store_without_sensors_has_no_findings(tmp_path: Path) -> None:
    from tests.run_folder import write_run_folder

    assert table.TABLE.rows(Store(write_run_folder(tmp_path / "run"))) == []
