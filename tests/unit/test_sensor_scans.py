"""Scans: patterns, clouds, beams that spread, columns fired on the way, and noise in the order of time."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.scene import (
    Appearance,
    Body,
    Box,
    Lidar,
    LidarNoise,
    PlacedShape,
    Plane,
    Scene,
    Sphere,
    Vector3,
    axis_angle,
)
from plumbline.harness.sensors.lidar import SUB_RAYS, beams, ideal, in_world, noisy, spread
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.recorder import SensorRecorder
from plumbline.harness.sensors.spinning import pose_between
from plumbline.harness.trajectory import Floats, Hits, State

CARRIER = Body(name="c")
WALL = Body(name="wall", motion="static", collision=(PlacedShape(shape=Box(half_extents=(0.5, 50, 50))),), p_WB=(10.5, 0, 0))
ROUND = Body(name="ball", motion="static", collision=(PlacedShape(shape=Sphere(radius=1.0)),), p_WB=(5, 0, 0))
ONE = Lidar(name="l", body="c", rate=10.0, channels=1, columns=4, elevation_low=0.0, elevation_high=0.0)


class Carried:
    """A simulation whose first body moves as it is told, with rays in closed form."""

    def __init__(self, scene: Scene, motion: Any, dt: float) -> None:
        self.scene, self.motion, self.dt, self.steps = scene, motion, dt, 0
        self.casts: list[int] = []

    def step(self, count: int = 1) -> None:
        self.steps += count

    def state(self, out: State) -> None:
        start = State.initial(self.scene)
        for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
            getattr(out, name)[:] = getattr(start, name)
        for name, value in self.motion(self.steps * self.dt).items():
            getattr(out, name)[0] = value

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        state = State.initial(self.scene)
        self.state(state)
        self.casts.append(len(origins))
        return first_hits(self.scene, state, origins, directions, max_range)


def _record(scene: Scene, motion: Any, dt: float, steps: int, seed: int = 1) -> dict[str, Floats]:
    simulation = Carried(scene, motion, dt)
    recorder = SensorRecorder(scene, simulation, seed, dt)  # type: ignore[arg-type]
    state = State.initial(scene)
    simulation.state(state)
    recorder.read(0.0, state)
    while simulation.steps < steps:
        simulation.step(recorder.interval_steps)
        simulation.state(state)
        recorder.read(simulation.steps * dt, state)
    return recorder.streams()


def _still(_t: float) -> dict[str, Any]:
    return {}


def _beam(scene: Scene, lidar: Lidar) -> tuple[float, float]:
    """Range and intensity of the beam along x."""
    origins, directions = in_world(lidar, np.zeros(3), np.array([1.0, 0, 0, 0]))
    hits = first_hits(scene, State.initial(scene), origins, directions, 100.0)
    ranges, intensities = ideal(lidar, scene, directions, hits)
    return float(ranges[0, 0]), float(intensities[0, 0])


def test_channels_take_their_own_elevations() -> None:
    lidar = replace(ONE, channels=3, elevations=(-0.3, 0.1, 0.15))
    np.testing.assert_allclose(np.arcsin(beams(lidar)[:, 0, 2]), (-0.3, 0.1, 0.15), atol=1e-15)


def test_the_cloud_is_the_noisy_range_along_the_beam_and_nothing_where_nothing_returned() -> None:
    lidar = replace(ONE, columns=8, noise=LidarNoise(range_sigma=0.1, dropout=0.2))
    scene = Scene(bodies=(CARRIER, WALL), sensors=(lidar,))
    streams = _record(scene, _still, 0.1, 30)
    ranges, points = streams["l/range"], streams["l/points"]
    assert points.shape == (31, 1, 8, 3)
    lost = np.isinf(ranges)
    assert lost.any()
    assert np.isnan(points[lost]).all()
    np.testing.assert_allclose(np.linalg.norm(points[~lost], axis=-1), np.abs(ranges[~lost]), rtol=1e-14)
    along = np.broadcast_to(beams(lidar), points.shape)
    np.testing.assert_allclose(points[~lost], ranges[~lost][:, None] * along[~lost], rtol=1e-14, atol=1e-15)


def test_a_cloud_without_noise_lies_on_the_wall() -> None:
    scene = Scene(bodies=(CARRIER, WALL), sensors=(replace(ONE, columns=360, channels=5, elevation_high=0.3),))
    points = _record(scene, _still, 0.1, 1)["l/points"]
    found = points[~np.isnan(points).any(axis=-1)]
    assert len(found) > 1000
    np.testing.assert_allclose(found[:, 0], 10.0, atol=1e-13)


def test_a_spread_beam_samples_its_cone_evenly() -> None:
    axis = np.array([[0.2, -0.5, 0.9]]) / np.linalg.norm([0.2, -0.5, 0.9])
    rays = spread(axis, 0.02)[:, 0]
    assert rays.shape == (SUB_RAYS, 3)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0, atol=1e-15)
    off = np.arccos(np.clip(rays @ axis[0], -1, 1))
    # The mean square of the angle over an even disc of radius a is a^2/2.
    assert np.mean(off**2) == pytest.approx(0.02**2 / 2, rel=1e-6)
    np.testing.assert_allclose(rays.mean(axis=0) / np.linalg.norm(rays.mean(axis=0)), axis[0], atol=1e-15)


def test_a_spread_beam_on_a_slanted_wall_has_the_mean_range_of_its_cone() -> None:
    """Against the integral over the disc, weighted by the cosine as intensities are."""
    angle, tilt = 0.01, 0.8
    slab = Body(
        name="slab", motion="static", collision=(PlacedShape(shape=Box(half_extents=(0.1, 40, 40))),),
        p_WB=(10.0, 0, 0), q_WB=axis_angle((0, 0, 1), tilt),
    )  # fmt: skip
    found, heard = _beam(Scene(bodies=(CARRIER, slab)), replace(ONE, divergence=angle))
    normal = np.array([-np.cos(tilt), -np.sin(tilt), 0.0])
    place = np.array([10.0, 0, 0]) + 0.1 * normal
    radius, turn = np.meshgrid(angle * np.sqrt((np.arange(400) + 0.5) / 400), 2 * np.pi * np.arange(400) / 400)
    rays = np.stack([np.cos(radius), np.sin(radius) * np.cos(turn), np.sin(radius) * np.sin(turn)], axis=-1)
    cosine = -(rays @ normal)
    ranges = -(place @ normal) / cosine
    # Seven rays have the disc's moments up to the third order: what is left is of the fourth.
    assert found == pytest.approx(np.sum(ranges * cosine) / cosine.sum(), abs=30 * 10 * angle**4)
    assert heard == pytest.approx(cosine.mean(), rel=1e-6)
    narrow, _ = _beam(Scene(bodies=(CARRIER, slab)), ONE)
    assert abs(found - narrow) > 1e-5


@pytest.mark.parametrize(("bright", "expected"), [(1.0, 4.0), (0.05, 10.0)])
def test_at_an_edge_a_spread_beam_returns_the_strongest_echo(bright: float, expected: float) -> None:
    """A plate covers the beam's upper half: four of seven sub-rays, if its reflectivity lets it win."""
    plate = Body(
        name="plate", motion="static", collision=(PlacedShape(shape=Box(half_extents=(0.5, 5, 5))),),
        p_WB=(4.5, 0, 5.0 - 1e-6), appearance=Appearance(reflectivity=bright),
    )  # fmt: skip
    lidar = replace(ONE, divergence=0.02)
    found, heard = _beam(Scene(bodies=(CARRIER, plate, WALL)), lidar)
    # Ranges along the cone exceed the axis's by its angle's square at most.
    assert found == pytest.approx(expected, rel=0.02**2)
    assert heard < 1.0
    far, lone = _beam(Scene(bodies=(CARRIER, plate)), lidar)
    assert far == pytest.approx(4.0, rel=0.02**2)
    assert lone < bright


def test_a_spread_beam_that_meets_nothing_returns_nothing() -> None:
    assert _beam(Scene(bodies=(CARRIER,)), replace(ONE, divergence=0.02)) == (np.inf, 0.0)


def test_columns_of_a_spinning_sensor_are_fired_on_the_way() -> None:
    """Flying at the wall with acceleration, three times as many columns as steps, and fewer."""
    speed, push, dt = 2.0, 3.0, 0.005

    def place(t: Any) -> Any:
        return speed * t + push * t * t / 2

    for columns in (60, 6):
        lidar = replace(ONE, columns=columns, spinning=True, max_range=300.0)
        scene = Scene(bodies=(CARRIER, WALL), sensors=(lidar,))
        streams = _record(scene, lambda t: {"p_WB": (place(t), 0, 0), "v_WB": (speed + push * t, 0, 0)}, dt, 60)
        np.testing.assert_allclose(streams["l/time"], (0.1, 0.2, 0.3), atol=1e-15)
        azimuth = 2 * np.pi * np.arange(columns) / columns
        for scan, stamp in enumerate((0.1, 0.2, 0.3)):
            fired = stamp - 0.1 * (columns - 1 - np.arange(columns)) / columns
            with np.errstate(divide="ignore"):
                expected = (10.0 - place(fired)) / np.cos(azimuth)
            seen = np.isfinite(streams["l/range_ideal"][scan, 0])
            assert (seen == (np.cos(azimuth) > 0.19)).all() or columns == 6
            np.testing.assert_allclose(streams["l/range_ideal"][scan, 0][seen], expected[seen], rtol=1e-12)


def test_a_turning_sensor_sees_the_wall_where_it_looked_when_it_fired() -> None:
    rate, dt, columns = 1.5, 0.005, 90
    lidar = replace(ONE, columns=columns, spinning=True, p_BS=(0.3, 0.0, 0.0), max_range=300.0)
    scene = Scene(bodies=(CARRIER, WALL), sensors=(lidar,))
    motion = lambda t: {"q_WB": axis_angle((0, 0, 1), rate * t), "w_WB": (0, 0, rate)}  # noqa: E731 -- one line of algebra
    found = _record(scene, motion, dt, 40)["l/range_ideal"][1, 0]
    turn = rate * (0.2 - 0.1 * (columns - 1 - np.arange(columns)) / columns)
    heading = turn + 2 * np.pi * np.arange(columns) / columns
    expected = (10.0 - 0.3 * np.cos(turn)) / np.cos(heading)
    seen = np.isfinite(found)
    assert seen.sum() > 30
    np.testing.assert_allclose(found[seen], expected[seen], rtol=1e-12)


def test_a_spinning_sensor_at_rest_sees_what_one_does_that_fires_at_once() -> None:
    lidar = replace(ONE, channels=3, columns=20, elevation_high=0.2, divergence=0.01)
    scene = Scene(bodies=(CARRIER, WALL, ROUND), sensors=(lidar, replace(lidar, name="s", spinning=True)))
    streams = _record(scene, _still, 0.01, 20)
    for channel in ("range", "intensity"):
        np.testing.assert_allclose(streams[f"s/{channel}"], streams[f"l/{channel}"][1:], rtol=1e-13)


def test_a_pose_between_two_steps_is_exact_for_steady_acceleration_and_steady_turning() -> None:
    def row(t: float) -> Floats:
        p, v = (
            np.array([1.0, 2.0, 0.0]) * t + np.array([0.0, 0.5, -4.9]) * t * t,
            np.array([1, 2, 0]) + np.array([0, 1, -9.8]) * t,
        )
        return np.concatenate([p, axis_angle((1, 2, 2), 0.7 * t), v, np.zeros(3)])

    share = np.array([0.0, 0.3, 1.0])
    p_WB, q_WB = pose_between(row(1.0), row(1.5), 0.5, share)
    expected = np.array([row(1.0 + 0.5 * s) for s in share])
    np.testing.assert_allclose(p_WB, expected[:, :3], atol=1e-14)
    np.testing.assert_allclose(q_WB, expected[:, 3:7], atol=1e-15)


def _noise(scans: int, law: LidarNoise, seed: int = 1) -> tuple[Floats, Floats]:
    return noisy(law, np.full((scans, 4, 50), 5.0), np.full((scans, 4, 50), 0.3), seed, "l")


def test_a_longer_record_of_scans_begins_with_the_shorter_one_bit_by_bit() -> None:
    law = LidarNoise(range_sigma=0.02, range_sigma_slope=0.001, dropout=0.1, intensity_sigma=0.1)
    for short, long, again in zip(_noise(3, law), _noise(7, law), _noise(3, law), strict=True):
        assert long[:3].tobytes() == short.tobytes() == again.tobytes()
        assert not np.array_equal(long[0], long[1])


def test_intensity_noise_has_its_spread_and_is_never_negative() -> None:
    _, light = _noise(200, LidarNoise(intensity_sigma=0.05))
    n = light.size
    assert light.mean() == pytest.approx(0.3, abs=5 * 0.05 / np.sqrt(n))
    assert light.std() == pytest.approx(0.05, rel=5 / np.sqrt(2 * n))
    _, dim = _noise(200, LidarNoise(intensity_sigma=0.5))
    assert dim.min() == 0.0
    # P(0.3 + 0.5 z < 0) = P(z < -0.6) = .2743.
    assert np.mean(dim == 0.0) == pytest.approx(0.27425, abs=5 * np.sqrt(0.2743 * 0.7257 / n))


def test_a_beam_below_the_least_intensity_returns_nothing_whatever_its_noise() -> None:
    law = LidarNoise(intensity_sigma=0.5, least_intensity=0.3)
    ranges, light = np.full((1, 1, 3), 5.0), np.array([[[0.29, 0.3, 0.31]]])
    found, heard = noisy(law, ranges, light, 1, "l")
    assert np.isinf(found).tolist() == [[[True, False, False]]]
    assert heard[0, 0, 0] == 0.0


def test_a_dark_body_is_not_heard_and_its_ideal_range_is_told_all_the_same() -> None:
    dark = replace(WALL, appearance=Appearance(reflectivity=0.05))
    lidar = replace(ONE, noise=LidarNoise(least_intensity=0.1))
    streams = _record(Scene(bodies=(CARRIER, dark), sensors=(lidar,)), _still, 0.1, 2)
    assert np.isinf(streams["l/range"][:, 0, 0]).all()
    np.testing.assert_allclose(streams["l/range_ideal"][:, 0, 0], 10.0)


def test_what_a_beam_meets_is_nothing_to_the_noise_of_the_others() -> None:
    law = LidarNoise(range_sigma=0.02, dropout=0.1)
    ranges = np.full((4, 2, 10), 5.0)
    some = ranges.copy()
    some[:, 0, 3] = np.inf
    whole, part = (noisy(law, r, np.where(np.isinf(r), 0.0, 0.5), 1, "l")[0] for r in (ranges, some))
    same = np.isfinite(some)
    np.testing.assert_array_equal(whole[same], part[same])


def test_a_floor_under_a_mounted_sensor_is_seen_from_the_world() -> None:
    from plumbline.harness.scene import WORLD

    up: Vector3 = (0.0, 0.0, 2.0)
    floor = Body(name="f", motion="static", collision=(PlacedShape(shape=Plane()),))
    lidar = replace(ONE, body=WORLD, p_BS=up, elevation_low=-0.5, elevation_high=-0.5)
    streams = _record(Scene(bodies=(floor,), sensors=(lidar,)), _still, 0.1, 1)
    np.testing.assert_allclose(streams["l/range"], 2.0 / np.sin(0.5), rtol=1e-14)
