"""Truths of the camera cases: against independent routes, and the premises of their bounds."""

from dataclasses import replace
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest

from plumbline.cases import sensor_camera_optics
from plumbline.cases.sensor_camera_optics import CASE as OPTICS
from plumbline.cases.sensor_camera_optics import HALF_THICKNESS, INDEX, _fresnel, _in_mirror, _in_pane
from plumbline.cases.sensor_camera_pinhole import CASE as PINHOLE
from plumbline.cases.sensor_depth_noise import BLOCK, FOCAL, PATTERN, PHASE, STEREO, WALL, WIDTH
from plumbline.cases.sensor_depth_noise import CASE as NOISE
from plumbline.cases.sensor_depth_noise import GRAZING as HALL_GRAZING
from plumbline.cases.sensor_depth_plane import CASE as PLANE
from plumbline.cases.sensor_depth_plane import GRAZING as PLANE_GRAZING
from plumbline.cases.sensor_depth_spheres import BALLS, LONGEST
from plumbline.cases.sensor_depth_spheres import CASE as SPHERES
from plumbline.harness.case import Case
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.cameras import colour_error_max, colour_error_median
from plumbline.harness.scene import DepthCamera
from plumbline.harness.sensors.camera import intrinsics, pixel_centres
from plumbline.harness.sensors.depth_camera import lost
from plumbline.harness.sensors.recorder import steps_between_readings
from plumbline.harness.sensors.sight import signal, sunlight
from plumbline.harness.sensors.true_views import true_frames, true_sight
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import rotate_back


def _worked_out(case: Case, **parameters: Any) -> Trajectory:
    found = case.truth_at(np.linspace(0.0, case.duration, 4), dict(case.parameters) | parameters)
    assert isinstance(found, Trajectory)
    return found


CASES = {case.name: case for case in (OPTICS, PINHOLE, NOISE, PLANE, SPHERES)}


@cache
def _named(name: str) -> Trajectory:
    return _worked_out(CASES[name])


def _truth(case: Case) -> Trajectory:
    """Worked out once, for all who only read it."""
    return _named(case.name)


@pytest.mark.parametrize(("tilt", "speed"), [(0.6, 1.5), (-0.4, -2.0), (0.0, 0.0)])
def test_the_planes_equation_gives_what_rays_from_the_moving_camera_meet(tilt: float, speed: float) -> None:
    truth = _worked_out(PLANE, tilt=tilt, speed=speed)
    scene = PLANE.scene(PLANE.at(tilt=tilt, speed=speed))
    camera: Any = scene.sensors[0]

    def state_at(time: float) -> State:
        state = State.initial(scene)
        state.p_WB[1, 0] += speed * time
        return state

    frames = true_frames(scene, camera, truth.streams["depth/time"], state_at)
    assert len(frames["depth/time"]) == 3
    for channel in ("depth_ideal", "body"):
        np.testing.assert_allclose(truth.streams[f"depth/{channel}"], frames[f"depth/{channel}"], rtol=1e-13)


def test_the_plane_is_seen_to_its_far_end_and_never_grazes_more_than_the_bound_says() -> None:
    depth = _truth(PLANE).streams["depth/depth_ideal"]
    assert 0.02 < np.isinf(depth).mean() < 0.5
    scene = PLANE.scene(PLANE.parameters)
    camera: Any = scene.sensors[0]
    sight = true_sight(scene, camera, State.initial(scene))
    assert sight.cosine[sight.measurable].min() > PLANE_GRAZING


def test_each_balls_silhouette_is_its_conic_and_its_depth_solves_the_quadric() -> None:
    """A pixel's ray s K^-1 (u, v, 1) meets |p - c| = r at the smaller root of a quadratic in s, which is z itself."""
    truth = _truth(SPHERES)
    scene = SPHERES.scene(SPHERES.parameters)
    camera: Any = scene.sensors[0]
    K = intrinsics(camera)
    homogeneous = np.column_stack([pixel_centres(camera), np.ones(640 * 480)])
    along = homogeneous @ np.linalg.inv(K).T
    nearest = np.full(len(along), np.inf)
    union = np.zeros(len(along), dtype=bool)
    for radius, centre in BALLS:
        c = np.array(centre)
        a, b, rest = np.sum(along**2, axis=1), along @ c, c @ c - radius**2
        under = b * b - a * rest
        depth = np.where(under >= 0, (b - np.sqrt(np.maximum(under, 0))) / a, np.inf)
        nearest = np.minimum(nearest, depth)
        conic = np.linalg.inv(K @ (radius**2 * np.eye(3) - np.outer(c, c)) @ K.T)
        level = np.sum((homogeneous @ conic) * homogeneous, axis=1)
        middle = K @ c
        union |= level * np.sign(middle @ conic @ middle) >= 0
    found = truth.streams["depth/depth_ideal"][0].ravel()
    np.testing.assert_array_equal(np.isfinite(found), union)
    # A grazing ray loses half the digits under the root.
    np.testing.assert_allclose(found[union], nearest[union], atol=1e-7)
    assert np.median(np.abs(found[union] - nearest[union])) < 1e-14
    assert (found * np.linalg.norm(along, axis=1))[union].max() < LONGEST


@pytest.mark.parametrize(("case", "least"), [(SPHERES, 13_800), (PINHOLE, 22_000)], ids=["spheres", "pinhole"])
def test_every_body_shows_in_as_many_pixels_as_the_bounds_assume(case: Case, least: int) -> None:
    for name, stream in _truth(case).streams.items():
        if name.endswith("/body"):
            counts = {place: int((stream[0] == place).sum()) for place in range(len(case.scene(case.parameters).bodies))}
            assert min(counts.values()) >= least, counts
            for place, count in counts.items():
                mask = np.pad(stream[0] == place, 1)
                inner = mask[1:-1, 1:-1] & mask[:-2, 1:-1] & mask[2:, 1:-1] & mask[1:-1, :-2] & mask[1:-1, 2:]
                # The pixels of the outline, which a diagonal one crosses at most sqrt(2) times as long.
                assert count - inner.sum() < 620


def test_the_solids_of_the_picture_stand_in_the_cameras_frame() -> None:
    scene = PINHOLE.scene(PINHOLE.parameters)
    camera: Any = scene.sensors[0]
    body = _truth(PINHOLE).streams["camera/body"][0]
    for place, solid in enumerate(scene.bodies):
        placed = solid.collision[0]
        u, v = camera.focal_x * placed.p_BS[0] / placed.p_BS[2] + 311, camera.focal_y * placed.p_BS[1] / placed.p_BS[2] + 247
        assert body[int(v), int(u)] == place
        np.testing.assert_allclose(rotate_back(np.array(camera.q_BS), np.array(solid.p_WB)), 0.0)


def _column(name: str, row: int) -> Floats:
    return _truth(NOISE).streams[f"{name}/lost"][0][row]


@pytest.mark.parametrize(("name", "baseline"), [("stereo", STEREO.baseline), ("pattern", PATTERN.baseline)])
def test_the_blocks_shadow_on_the_wall_is_as_wide_as_its_disparity_says(name: str, baseline: float) -> None:
    """Beside the block's left edge f b (1/BLOCK - 1/WALL) columns are hidden; a row over mirror and panel, within the light."""
    row = _column(name, 58)
    body = _truth(NOISE).streams[f"{name}/body"][0][58]
    left = float(WIDTH / 2 - FOCAL * 0.54 / BLOCK)
    u = np.arange(WIDTH) + 0.5
    shadow = (u < left) & (u > left - FOCAL * baseline * (1 / BLOCK - 1 / WALL))
    assert (body[shadow] == 1).all()
    near = (u > left - 15) & (u < left)
    np.testing.assert_array_equal(row[near] > 0, shadow[near])
    assert shadow.sum() >= 3


OBLIQUE = 1e-9 * np.array([[0.8, 0.5, -0.3], [-0.8, -0.5, 0.3]])
"""Ways [m] across all edges that do not happen to lie along them."""
ALONG_AXES = 1e-9 * np.concatenate([np.eye(3), -np.eye(3)])
WAYS = pytest.mark.parametrize("ways", [OBLIQUE, pytest.param(ALONG_AXES, marks=pytest.mark.slow)], ids=["oblique", "axes"])


@cache
def _sights() -> list[tuple[DepthCamera, Any, Any]]:
    scene = NOISE.scene(NOISE.parameters)
    cameras = [camera for camera in scene.sensors if isinstance(camera, DepthCamera)]
    return [(camera, camera.noise, true_sight(scene, camera, State.initial(scene))) for camera in cameras]


def test_the_halls_gaps_have_all_their_causes() -> None:
    scene = NOISE.scene(NOISE.parameters)
    names = [body.name for body in scene.bodies]
    for _, noise, sight in _sights():
        gone = lost(noise, sight)
        share = {
            name: float(gone[sight.body == place].mean()) for place, name in enumerate(names) if (sight.body == place).any()
        }
        assert share["mirror"] == 1.0
        assert share["pane"] == 1.0
        assert share["panel"] == (0.0 if noise is STEREO else 1.0)
        assert 0.0 <= share["block"] < 0.05
        assert 0.1 < share["floor"] < 0.6
        assert 0.0 < share["wall"] < 0.5


@WAYS
def test_no_pixel_of_the_hall_hangs_on_an_edge_or_a_bound(ways: Floats) -> None:
    """A camera moved by 1e-9 m there and back loses the same pixels: a thousand roundings of the longest ray."""
    scene = NOISE.scene(NOISE.parameters)
    rig = scene.index("rig")
    for camera, noise, sight in _sights():
        for way in ways:
            state = State.initial(scene)
            state.p_WB[rig] += way
            np.testing.assert_array_equal(lost(noise, true_sight(scene, camera, state)), lost(noise, sight))


def test_no_pixel_of_the_hall_grazes_more_than_the_bound_says_and_the_far_part_wraps() -> None:
    for _, _, sight in _sights():
        assert sight.cosine.min() > HALL_GRAZING
        assert sight.measurable.all()
    _, _, sight = _sights()[2]
    assert PHASE.unambiguous_range is not None
    beyond = sight.range > PHASE.unambiguous_range
    assert 0.3 < beyond.mean() < 0.95


def test_sunlight_takes_only_what_it_falls_on() -> None:
    _, noise, sight = _sights()[1]
    dark = NOISE.scene(NOISE.at(infrared=0.0))
    camera: Any = dark.sensors[1]
    without = lost(noise, true_sight(dark, camera, State.initial(dark)))
    more = lost(noise, sight) & ~without
    assert (without <= lost(noise, sight)).all()
    assert more.sum() > 500
    assert (signal(sight)[more] < noise.least_contrast * sunlight(sight)[more]).all()
    shaded = (sunlight(sight) == 0.0) & (sight.body == 0)
    assert shaded.sum() > 20


@pytest.mark.parametrize("case", [PLANE, SPHERES, PINHOLE, OPTICS, NOISE], ids=lambda c: c.name)
def test_every_step_of_the_ladder_is_a_divisor_of_the_sensors_interval(case: Case) -> None:
    scene = case.scene(case.parameters)
    for dt in (case.dt, *case.ladder):
        assert all(steps_between_readings(sensor, dt) >= 1 for sensor in scene.sensors)


@cache
def _optics(tilt: float = 0.5) -> tuple[Any, dict[str, Any]]:
    scene = OPTICS.scene(OPTICS.at(tilt=tilt))
    return scene, {camera.name: (camera, true_sight(scene, camera, State.initial(scene))) for camera in scene.sensors}


def test_a_mirror_shows_balls_where_their_images_behind_it_would_stand() -> None:
    scene, sights = _optics()
    camera, sight = sights["facing"]
    normal = sight.normal_W[np.flatnonzero(sight.body == 0)[0]]
    face = sight.point_W[np.flatnonzero(sight.body == 0)[0]]
    images = []
    for body in scene.bodies[1:4]:
        p_WB = np.array(body.p_WB)
        place = p_WB - 2.0 * ((p_WB - face) @ normal) * normal
        images += [replace(body, p_WB=tuple(place), name=f"image of {body.name}"), body]
    direct = replace(scene, bodies=tuple(images), sensors=(camera,))
    dark = true_sight(direct, camera, State.initial(direct)).body >= 0
    colour = _truth(OPTICS).streams["facing/colour"][0, :, :, 0].ravel()
    np.testing.assert_array_equal(colour == 0.0, dark)
    np.testing.assert_array_equal(colour == 1.0, ~dark)
    assert 0.05 < dark.mean() < 0.5


def test_a_pane_moves_a_ray_sideways_as_snell_says_and_takes_no_light_away() -> None:
    """d = t sin a (1 - cos a / sqrt(n^2 - sin^2 a)), in mpmath, for the ray through the middle of the picture."""
    scene, sights = _optics()
    sight = sights["through"][1]
    middle = 60 * 160 + 80
    normal, direction = sight.normal_W[middle], sight.directions_W[middle]
    cosine = -normal @ direction
    with mpmath.workdps(30):
        a = mpmath.acos(cosine)
        shift = 2 * HALF_THICKNESS * mpmath.sin(a) * (1 - mpmath.cos(a) / mpmath.sqrt(INDEX**2 - mpmath.sin(a) ** 2))
    # The same by the way through the pane: along the refracted ray to the back, then beside the undisturbed one.
    inside = direction / INDEX + (cosine / INDEX - np.sqrt(1 - (1 - cosine**2) / INDEX**2)) * normal
    out = sight.point_W[middle] + 2 * HALF_THICKNESS / -(inside @ normal) * inside
    off = out - sight.point_W[middle]
    assert np.linalg.norm(off - (off @ direction) * direction) == pytest.approx(float(shift), rel=1e-12)
    # The ray from there meets the ball or passes it just as the picture says; the pixels at the ball's edge tell.
    colour = _truth(OPTICS).streams["through/colour"][0, :, :, 0]
    beyond = scene.body("beyond")
    cosines = -np.sum(sight.normal_W * sight.directions_W, axis=1)
    inner = sight.directions_W / INDEX + (cosines / INDEX - np.sqrt(1 - (1 - cosines**2) / INDEX**2))[:, None] * sight.normal_W
    steps = 2 * HALF_THICKNESS / -np.sum(inner * sight.normal_W, axis=1)
    outs = sight.point_W + steps[:, None] * inner
    to_ball = np.array(beyond.p_WB) - outs
    miss = np.linalg.norm(to_ball - np.sum(to_ball * sight.directions_W, axis=1)[:, None] * sight.directions_W, axis=1)
    dark = (miss < 0.5).reshape(120, 160)
    # What is left in front of a black ball is what the pane sends back, 0.04 at the least and 0.25 at most here.
    assert (colour[dark] < 0.25).all()
    assert dark.sum() > 400
    assert colour.max() == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.9, 1.2])
def test_fresnels_share_agrees_with_his_sines_and_tangents(angle: float) -> None:
    share, inside = _fresnel(np.cos(np.array([angle])))
    with mpmath.workdps(30):
        refracted = mpmath.asin(mpmath.sin(angle) / INDEX)
        if angle == 0.0:
            expected = ((INDEX - 1) / (INDEX + 1)) ** 2
        else:
            across = (mpmath.sin(angle - refracted) / mpmath.sin(angle + refracted)) ** 2
            along = (mpmath.tan(angle - refracted) / mpmath.tan(angle + refracted)) ** 2
            expected = float((across + along) / 2)
    assert share[0] == pytest.approx(expected, rel=1e-12)
    assert inside[0] == pytest.approx(float(mpmath.cos(refracted)), rel=1e-14)


@WAYS
def test_light_of_one_camera_never_comes_from_the_others_scene_and_no_pixel_hangs_on_an_edge(ways: Floats) -> None:
    scene, _ = _optics()
    colours = {name: stream for name, stream in _truth(OPTICS).streams.items() if name.endswith("colour")}
    alone = {
        "facing": replace(scene, bodies=scene.bodies[:4], sensors=scene.sensors[:1]),
        "through": replace(scene, bodies=scene.bodies[4:], sensors=scene.sensors[1:]),
    }
    for name, part in alone.items():
        camera: Any = part.sensors[0]
        sheet, light = ("mirror", _in_mirror) if name == "facing" else ("pane", _in_pane)
        for way in ways:
            moved = replace(camera, p_BS=tuple(np.array(camera.p_BS) + way))
            sight = true_sight(part, moved, State.initial(part))
            grey = np.where(sight.body == part.index(sheet), light(part, sight), 0.0)
            np.testing.assert_allclose(grey, colours[f"{name}/colour"][0, :, :, 0].ravel(), atol=1e-7)
            # Sides of the sheets, 9 m off, are never met.
            assert (np.abs(sight.normal_W[sight.body == part.index(sheet)] @ sight.normal_W[0]) > 0.99).all()


def test_a_wrong_index_and_a_mirror_that_does_not_mirror_are_seen_in_the_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = _truth(OPTICS)
    scene = OPTICS.scene(OPTICS.parameters)
    assert colour_error_max(scene, truth, truth) == 0.0
    assert colour_error_median(scene, truth, truth) == 0.0
    colour = truth.streams["through/colour"]
    with monkeypatch.context() as patch:
        patch.setattr(sensor_camera_optics, "INDEX", INDEX + 0.01)
        assert colour_error_max(scene, _worked_out(OPTICS), truth) > 1e-3
    unmirrored = replace(truth, streams={**truth.streams, "facing/colour": np.ones_like(truth.streams["facing/colour"])})
    assert colour_error_max(scene, unmirrored, truth) == 1.0
    assert colour_error_median(scene, unmirrored, truth) == 0.0
    gamma = replace(truth, streams={**truth.streams, "through/colour": (0.9 * colour) ** (1 / 2.2)})
    assert colour_error_median(scene, gamma, truth) > 0.01
    bad = colour.copy()
    bad[0, 3, 4, 1] = np.nan
    for metric in (colour_error_max, colour_error_median):
        assert np.isnan(metric(scene, replace(truth, streams={**truth.streams, "through/colour": bad}), truth))
    with pytest.raises(NotMeasurable, match="no colour camera"):
        colour_error_max(SPHERES.scene(SPHERES.parameters), truth, truth)
