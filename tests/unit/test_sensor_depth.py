"""Depth cameras: bounds, gaps and errors of each principle against geometry by hand and against their laws."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import (
    Appearance,
    Body,
    Box,
    Camera,
    DepthCamera,
    PlacedShape,
    Plane,
    Scene,
    Sphere,
    StereoNoise,
    StructuredLightNoise,
    Sun,
    TimeOfFlightNoise,
    axis_angle,
)
from plumbline.harness.sensors import time_of_flight
from plumbline.harness.sensors.depth_camera import answer, lost, picture_camera
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.recorder import SensorRecorder
from plumbline.harness.sensors.sight import Sight, in_view_of, signal, sunlight
from plumbline.harness.sensors.true_views import true_frames, true_sight
from plumbline.harness.trajectory import Floats, Hits, Image, State

WIDTH, HEIGHT, FOCAL = 80, 60, 60.0
CAMERA = DepthCamera(
    name="d", body="world", rate=10.0, width=WIDTH, height=HEIGHT, focal_x=FOCAL, focal_y=FOCAL, centre_x=40.0, centre_y=30.0
)
"""At the origin of W, looking along +z, x to the right, y down."""
FACING_BACK = axis_angle((1.0, 0.0, 0.0), np.pi)
"""A plane of this attitude has its outward normal along -z."""


def _wall(z: float, name: str = "wall", **look: Any) -> Body:
    return Body(
        name=name,
        motion="static",
        collision=(PlacedShape(shape=Plane()),),
        p_WB=(0, 0, z),
        q_WB=FACING_BACK,
        appearance=Appearance(**look),
    )


def _slab(
    name: str, x: tuple[float, float], z: float, thick: float = 0.05, y: tuple[float, float] = (-9.0, 9.0), **look: Any
) -> Body:
    """A box between two x [m] whose front stands at z."""
    half = ((x[1] - x[0]) / 2, (y[1] - y[0]) / 2, thick)
    place = ((x[0] + x[1]) / 2, (y[0] + y[1]) / 2, z + thick)
    shape = PlacedShape(shape=Box(half_extents=half))
    return Body(name=name, motion="static", collision=(shape,), p_WB=place, appearance=Appearance(**look))


def _sight(*bodies: Body, camera: DepthCamera = CAMERA, sun: Sun | None = None) -> Sight:
    scene = Scene(bodies=bodies, sensors=(camera,), sun=sun or Sun())
    return true_sight(scene, camera, State.initial(scene))


def _image(values: Floats) -> Floats:
    return values.reshape(HEIGHT, WIDTH)


class Still:
    """A simulation at rest with rays in closed form, and pictures that show what the rays meet."""

    def __init__(self, scene: Scene, normals: bool = True) -> None:
        self.scene, self.normals, self.asked = scene, normals, [True]

    def state(self, out: State) -> None:
        start = State.initial(self.scene)
        out.p_WB[:], out.q_WB[:] = start.p_WB, start.q_WB

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        hits = first_hits(self.scene, State.initial(self.scene), origins, directions, max_range)
        return hits if self.normals else replace(hits, normal_W=np.zeros_like(hits.normal_W))

    def render(self, camera: Camera, colour: bool = True) -> Image:
        self.asked.append(colour)
        sight = true_sight(self.scene, camera, State.initial(self.scene))
        shape = (camera.height, camera.width)
        return Image(depth=sight.depth.reshape(shape), body=sight.body.reshape(shape))


def _record(scene: Scene, frames: int, seed: int = 1, simulation: Any = None) -> dict[str, Floats]:
    still: Any = simulation or Still(scene)
    recorder = SensorRecorder(scene, still, seed, 0.1)
    for k in range(frames):
        recorder.read(0.1 * k, State.initial(scene))
    return recorder.streams()


def test_a_wall_across_the_axis_has_one_depth_though_its_ranges_differ() -> None:
    sight = _sight(_wall(3.0))
    np.testing.assert_allclose(sight.depth, 3.0, rtol=1e-15)
    corner = np.hypot(np.hypot(39.5, 29.5) / FOCAL, 1.0)
    assert sight.range[0] == pytest.approx(3.0 * corner, rel=1e-15)


def test_what_is_too_near_reads_minus_infinity_and_what_is_too_far_or_nothing_plus_infinity() -> None:
    camera = replace(CAMERA, near=1.0, far=4.0)
    near, far = _slab("near", (-9, -0.2), 0.5), _slab("far", (0.2, 1.0), 4.5)
    row = _image(_sight(near, far, _slab("within", (1.0, 2.0), 3.9), camera=camera).depth)[30]
    assert row[0] == -np.inf
    assert row[45] == np.inf
    assert row[39] == np.inf
    assert row[60] == pytest.approx(3.9, rel=1e-15)
    body = _image(_sight(near, far, camera=camera).body)[30]
    assert (body[0], body[45], body[39]) == (0, -1, -1)


@pytest.mark.parametrize("law", [StereoNoise(baseline=0.3), StructuredLightNoise(baseline=0.3)], ids=lambda law: law.type)
def test_the_second_view_misses_a_strip_beside_an_edge_and_a_strip_beside_its_own_picture(law: Any) -> None:
    """Left of a slab at depth a before a wall at c, f b (1/a - 1/c) columns of the wall; left of all, f b / depth columns."""
    a, c, b = 1.5, 4.0, 0.3
    hidden = _image(lost(law, _sight(_wall(c), _slab("slab", (0.02, 0.6), a))))[10]
    u = np.arange(WIDTH) + 0.5
    edge = 40.0 + FOCAL * 0.02 / a
    shadow = (u < edge) & (u > edge - FOCAL * b * (1 / a - 1 / c))
    margin = u < FOCAL * b / c
    np.testing.assert_array_equal(hidden, shadow | margin)
    # 40.8 - 7.5 < u < 40.8, and u < 4.5.
    assert shadow.sum() == 8
    assert margin.sum() == 4
    off = replace(law, **{"occlusion" if isinstance(law, StereoNoise) else "shadow": False})
    assert not lost(off, _sight(_wall(c), _slab("slab", (0.02, 0.6), a))).any()


def test_on_a_bare_convex_body_only_what_faces_away_from_the_second_eye_is_hidden() -> None:
    ball = Body(name="ball", motion="static", collision=(PlacedShape(shape=Sphere(radius=0.8)),), p_WB=(0.4, 0.1, 2.0))
    sight, b = _sight(ball), 0.4
    facing = np.sum(sight.normal_W * (sight.point_W - [b, 0.0, 0.0]), axis=1) < 0
    seen = in_view_of(sight, b) | (
        np.tile(np.arange(WIDTH) + 0.5, HEIGHT) < FOCAL * b / np.where(sight.measurable, sight.depth, 9)
    )
    on_ball = sight.measurable
    # A point within the slack of 1e-3 of 2 m behind the edge still counts as seen: sqrt(2 r d) = 6 cm of arc, 2 pixels.
    wrong = on_ball & (seen != facing)
    assert wrong.sum() < 0.06 * on_ball.sum()
    assert (seen | ~facing)[on_ball].all()


def test_mirrors_and_what_lets_all_light_through_have_no_depth_by_any_principle() -> None:
    bodies = (
        _wall(3.0),
        _slab("mirror", (-1.5, -0.8), 2.5, mirror=1.0),
        _slab("glass", (-0.5, 0.2), 2.5, transmission=1.0),
        _slab("half", (0.5, 1.2), 2.5, mirror=0.3, transmission=0.5),
    )
    sight = _sight(*bodies)
    for law in (
        StereoNoise(baseline=1e-3, occlusion=False),
        StructuredLightNoise(baseline=1e-3, shadow=False),
        TimeOfFlightNoise(),
    ):
        np.testing.assert_array_equal(lost(law, sight), np.isin(sight.body, (1, 2)))
    choosy = StereoNoise(baseline=1e-3, occlusion=False, least_texture=0.36)
    np.testing.assert_array_equal(lost(choosy, sight), np.isin(sight.body, (1, 2, 3)))


def test_light_comes_back_by_lamberts_law_over_the_squared_range() -> None:
    sight = _sight(_wall(2.0, reflectivity=0.6, mirror=0.25, transmission=0.2))
    cosine = 1.0 / np.hypot(1.0, np.linalg.norm(np.array([39.5, 29.5]) / FOCAL))
    # cos / r^2 with r = z / cos.
    assert signal(sight)[0] == pytest.approx(0.6 * 0.75 * 0.8 * cosine**3 / 4.0, rel=1e-14)
    least = 0.6 * 0.75 * 0.8 * 0.8**3 / 4.0
    faint = _image(lost(TimeOfFlightNoise(least_signal=least), sight))
    x, y = (np.arange(WIDTH) + 0.5 - 40) / FOCAL, (np.arange(HEIGHT) + 0.5 - 30) / FOCAL
    np.testing.assert_array_equal(faint, x[None, :] ** 2 + y[:, None] ** 2 > 1 / 0.8**2 - 1)


@pytest.mark.parametrize("kind", [StructuredLightNoise, TimeOfFlightNoise])
def test_sunlight_drowns_the_lamp_where_the_sun_shines_and_not_in_a_shadow(kind: Any) -> None:
    """The sun stands at 45 degrees to the left behind the camera: a slab before the wall throws its shadow to the right."""
    sun = Sun(towards_W=(-1.0, 0.0, -1.0), infrared=0.4)
    sight = _sight(_wall(3.0), _slab("slab", (0.0, 0.3), 2.0), sun=sun)
    row = slice(30 * WIDTH, 31 * WIDTH)
    point = sight.point_W[row]
    on_wall = sight.body[row] == 0
    # The slab's back stands at 2.1, its front at 2.0: light past both edges falls on the wall between these.
    shadow = on_wall & (point[:, 0] > 0.0 + 0.9) & (point[:, 0] < 0.3 + 1.0)
    lit = np.where(shadow, 0.0, np.sqrt(0.5))
    np.testing.assert_allclose(sunlight(sight)[row][on_wall], (0.4 * lit)[on_wall], atol=1e-14)
    fixed: dict[str, Any] = {} if kind is TimeOfFlightNoise else {"baseline": 1e-3, "shadow": False}
    dazzled = lost(kind(least_contrast=0.5, **fixed), sight)[row]
    bright = signal(sight)[row] >= 0.5 * 0.4 * lit
    np.testing.assert_array_equal(dazzled[on_wall], ~bright[on_wall])
    assert shadow.sum() > 5
    assert not dazzled[shadow].any()
    assert dazzled[on_wall & ~shadow].all()


def test_steep_surfaces_are_lost_to_triangulation() -> None:
    floor = Body(
        name="floor",
        motion="static",
        collision=(PlacedShape(shape=Plane()),),
        p_WB=(0, 0.5, 0),
        q_WB=axis_angle((1, 0, 0), np.pi / 2),
    )
    sight = _sight(floor)
    for law in (
        StereoNoise(baseline=0.1, occlusion=False, steepest=np.radians(70)),
        StructuredLightNoise(baseline=0.1, shadow=False, steepest=np.radians(70)),
    ):
        angle = np.arccos(np.abs(sight.directions_W[:, 1]))
        np.testing.assert_array_equal(lost(law, sight), sight.measurable & (angle > np.radians(70)))


@pytest.mark.parametrize("depth", [0.5, 2.0, 6.0])
def test_the_sigma_of_depth_by_disparity_is_z_squared_over_f_b(depth: float) -> None:
    camera = replace(CAMERA, width=400, height=300)
    law = StereoNoise(baseline=0.2, disparity_sigma=0.01)
    normal = np.random.default_rng(7).standard_normal(120_000)
    found = answer(law, _sight(_wall(depth), camera=camera), normal)
    expected = depth**2 / (FOCAL * 0.2) * 0.01
    # 120 000 samples know their spread to 0.2 %; the second order, (sigma z / f b)^2, is below 3e-5 of it.
    assert np.std(found) == pytest.approx(expected, rel=5 * 0.0021)
    assert np.mean(found) - depth == pytest.approx(0.0, abs=5 * expected / np.sqrt(120_000) + 3e-5 * depth)


def test_quantised_disparities_are_multiples_of_the_step_and_none_at_all_lies_too_far() -> None:
    law = StructuredLightNoise(baseline=0.05, disparity_sigma=0.3, disparity_step=0.25)
    sight = _sight(_wall(8.0))
    found = answer(law, sight, np.random.default_rng(1).standard_normal(len(sight.depth)))
    levels = FOCAL * 0.05 / found / 0.25
    np.testing.assert_allclose(levels, np.rint(levels), atol=1e-12)
    # The disparity is 0.375 px: with a sigma of 0.3 px a third is rounded down to 0 or below, which is infinitely far.
    share = np.mean(np.isinf(found))
    from scipy.stats import norm

    law_share = norm.cdf((0.125 - 0.375) / 0.3)
    assert share == pytest.approx(law_share, abs=5 * np.sqrt(law_share * (1 - law_share) / len(found)))
    assert (found > 0).all()


def test_a_range_beyond_half_a_wavelength_starts_from_nothing_again() -> None:
    sight = _sight(_wall(2.6))
    found = answer(TimeOfFlightNoise(unambiguous_range=3.0), sight, np.zeros(len(sight.depth)))
    np.testing.assert_allclose(found, np.mod(sight.range, 3.0) * sight.ahead, rtol=1e-14)
    assert (found[sight.range > 3.0] < 1.0).all()
    assert (sight.range > 3.0).sum() > 500
    np.testing.assert_allclose(answer(TimeOfFlightNoise(), sight, np.zeros(len(sight.depth))), sight.depth, rtol=1e-15)


def test_noise_pushes_a_range_over_the_wrap_in_both_directions() -> None:
    sight = _sight(_wall(3.0))
    law = TimeOfFlightNoise(unambiguous_range=3.0, range_sigma=0.01)
    found = answer(law, sight, np.where(np.arange(len(sight.depth)) % 2, 1.0, -1.0))
    centre = 30 * WIDTH + 40
    # The centre's range is 3.0004 m, that of its neighbour to the left the same by symmetry.
    assert found[centre] == pytest.approx(2.99, abs=1e-3)
    assert found[centre + 1] == pytest.approx(0.0104 + 0.0005, abs=1e-3)


def test_range_noise_grows_along_its_slope_and_with_lack_of_light() -> None:
    steady = TimeOfFlightNoise(range_sigma=0.01, range_sigma_slope=0.002)
    sight = _sight(_wall(4.0), sun=Sun(towards_W=(0.0, 0.0, -1.0), infrared=0.05))
    np.testing.assert_allclose(time_of_flight.sigma(steady, sight), 0.01 + 0.002 * sight.range, rtol=1e-14)
    middle = 30 * WIDTH + 40
    shot = TimeOfFlightNoise(range_sigma=0.003, shot_sigma=0.001)
    # At 4 m the lamp gives 1/16 and the sun 0.05: 0.001 sqrt(0.1125) 16, beside 0.003; the pixel looks 0.7 degrees askew.
    assert time_of_flight.sigma(shot, sight)[middle] == pytest.approx(np.hypot(0.003, 0.016 * np.sqrt(0.1125)), rel=1e-3)


@pytest.mark.parametrize(
    ("strength", "direct", "indirect"), [(0.3, 2.0, 2.9), (0.05, 0.4, 3.1), (0.9, 1.0, 1.0), (0.0, 4.9, 1.0)]
)
def test_two_paths_add_as_phasors(strength: float, direct: float, indirect: float) -> None:
    unambiguous = 5.0
    turn = 2 * np.pi / unambiguous
    real = np.cos(turn * direct) + strength * np.cos(turn * indirect)
    imaginary = np.sin(turn * direct) + strength * np.sin(turn * indirect)
    expected = np.arctan2(imaginary, real) / turn % unambiguous
    found = time_of_flight.mixed_range(np.array([direct]), np.array([indirect]), np.array([strength]), unambiguous)
    np.testing.assert_allclose(found, expected, rtol=1e-13)


def test_in_a_corner_the_second_path_goes_over_the_other_wall() -> None:
    """The middle pixel meets a wall at 45 degrees at 2 m; its mirror ray runs along +x to a side wall 1.5 m on."""
    oblique = Body(
        name="oblique",
        motion="static",
        collision=(PlacedShape(shape=Plane(normal=(1.0, 0.0, -1.0))),),
        p_WB=(0.0, 0.0, 2.0),
    )
    side = Body(
        name="side",
        motion="static",
        collision=(PlacedShape(shape=Plane(normal=(-1.0, 0.0, 0.0))),),
        p_WB=(1.5, 0.0, 0.0),
        appearance=Appearance(reflectivity=0.5),
    )
    camera = replace(CAMERA, width=1, height=1, centre_x=0.5, centre_y=0.5)
    law = TimeOfFlightNoise(unambiguous_range=7.5, multipath=0.4)
    found = answer(law, _sight(oblique, side, camera=camera), np.zeros(1))
    travelled = 2.0 + 1.5 + np.hypot(1.5, 2.0)
    expected = time_of_flight.mixed_range(np.array([2.0]), np.array([travelled / 2]), np.array([0.4 * 0.5]), 7.5)
    # The ray starts 1e-3 of 2 m off the wall along its normal: the way on is 1.4 mm shorter and 1.4 mm nearer.
    np.testing.assert_allclose(found, expected, atol=1e-3)
    assert found[0] > 2.1
    single = answer(law, _sight(oblique, camera=camera), np.zeros(1))
    np.testing.assert_allclose(single, 2.0, rtol=1e-14)


LAWS = (
    StereoNoise(baseline=0.1, disparity_sigma=0.05, missing=0.1),
    StructuredLightNoise(baseline=0.1, disparity_sigma=0.05, missing=0.1),
    TimeOfFlightNoise(range_sigma=0.02, unambiguous_range=5.0, missing=0.1),
)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.type)
def test_the_reader_gives_ideal_frames_noise_and_gaps_by_their_laws(law: Any) -> None:
    scene = Scene(bodies=(_wall(3.0), _slab("slab", (0.0, 0.5), 2.0, y=(-0.2, 9.0))), sensors=(replace(CAMERA, noise=law),))
    streams = _record(scene, 3)
    camera: Any = scene.sensors[0]
    truth = true_frames(scene, camera, np.arange(3) / 10)
    np.testing.assert_array_equal(streams["d/depth_ideal"], truth["d/depth_ideal"])
    np.testing.assert_array_equal(streams["d/body"], truth["d/body"])
    taken, silent = truth["d/lost"] > 0, np.isnan(streams["d/depth"])
    assert silent[taken].all()
    assert np.mean(silent[~taken]) == pytest.approx(0.1, abs=5 * np.sqrt(0.09 / (~taken).sum()))
    heard = streams["d/depth"][~silent]
    assert np.abs(heard - streams["d/depth_ideal"][~silent]).max() < 5.0
    assert len(np.unique(heard)) > 0.99 * heard.size


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.type)
def test_a_longer_run_begins_with_the_shorter_ones_noise_and_another_seed_or_name_differs(law: Any) -> None:
    scene = Scene(bodies=(_wall(3.0),), sensors=(replace(CAMERA, noise=law),))
    short, long = _record(scene, 2)["d/depth"], _record(scene, 4)["d/depth"]
    np.testing.assert_array_equal(short, long[:2])
    assert (long[0] != long[1]).mean() > 0.99
    assert (_record(scene, 2, seed=2)["d/depth"] != short).mean() > 0.99
    other = replace(scene, sensors=(replace(CAMERA, noise=law, name="e"),))
    assert (_record(other, 2)["e/depth"] != short).mean() > 0.99


def test_without_noise_depth_is_the_ideal_depth() -> None:
    streams = _record(Scene(bodies=(_wall(3.0),), sensors=(CAMERA,)), 1)
    np.testing.assert_array_equal(streams["d/depth"], streams["d/depth_ideal"])


@pytest.mark.parametrize("renderer", ["rasterised", "ray_traced"])
def test_a_depth_camera_may_see_by_the_engines_own_picture(renderer: Any) -> None:
    camera = replace(CAMERA, seen_by=renderer, far=2.5, noise=LAWS[2])
    scene = Scene(bodies=(_wall(3.0), _slab("slab", (0.0, 0.5), 2.0)), sensors=(camera,))
    still = Still(scene)
    streams = _record(scene, 1, simulation=still)
    assert still.asked[-1] is False
    by_rays = _record(replace(scene, sensors=(replace(camera, seen_by="rays"),)), 1)
    # A picture's z-depth has been through no bound yet; both are bounded alike.
    np.testing.assert_allclose(streams["d/depth_ideal"], by_rays["d/depth_ideal"], rtol=1e-15)
    np.testing.assert_array_equal(streams["d/body"], by_rays["d/body"])
    np.testing.assert_array_equal(np.isnan(streams["d/depth"]), np.isnan(by_rays["d/depth"]))
    assert picture_camera(camera).renderer == renderer
    with pytest.raises(ValueError, match="seen_by 'rays'"):
        picture_camera(CAMERA)


def test_noise_that_depends_on_the_angle_is_refused_where_rays_bring_no_normals() -> None:
    law = StructuredLightNoise(baseline=0.1, least_signal=0.01)
    scene = Scene(bodies=(_wall(3.0),), sensors=(replace(CAMERA, noise=law),))
    with pytest.raises(Unsupported, match=r"noise of sensor 'd'.*4800 pixels came back without a normal"):
        _record(scene, 1, simulation=Still(scene, normals=False))
    quiet = replace(scene, sensors=(CAMERA,))
    assert np.isfinite(_record(quiet, 1, simulation=Still(quiet, normals=False))["d/depth"]).all()


def test_a_depth_that_an_engine_gets_as_nan_stays_nan() -> None:
    scene = Scene(bodies=(_wall(3.0),), sensors=(CAMERA,))

    class Broken(Still):
        def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
            hits = super().cast(origins, directions, max_range)
            hits.distance[17] = np.nan
            return hits

    streams = _record(scene, 1, simulation=Broken(scene))
    assert np.isnan(streams["d/depth_ideal"].ravel()[17])
    assert np.isnan(streams["d/depth_ideal"]).sum() == 1
