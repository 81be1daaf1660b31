"""Pinhole, lens and frames of a camera: by hand, against sections of cones, and there and back again."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial import ConvexHull

from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import (
    Body,
    Box,
    Camera,
    Capsule,
    Cylinder,
    Distortion,
    PlacedShape,
    Scene,
    Shape,
    Sphere,
    axis_angle,
)
from plumbline.harness.sensors import camera as camera_reader
from plumbline.harness.sensors.camera import (
    RESIDUAL,
    distort,
    intrinsics,
    pixel_centres,
    pixel_rays,
    project,
    undistort,
    unproject,
)
from plumbline.harness.sensors.recorder import SensorRecorder
from plumbline.harness.sensors.true_views import true_frames, true_sight
from plumbline.harness.trajectory import Floats, Image, State
from plumbline.harness.trajectory.kinematics import rotate

CAMERA = Camera(
    name="c", body="world", rate=10.0, width=640, height=480, focal_x=500.0, focal_y=520.0, centre_x=311.0, centre_y=247.0
)
LENS = Distortion(k1=-0.28, k2=0.07, k3=-0.004, p1=0.0009, p2=-0.0006)
TURNED = axis_angle((0.3, 1.0, -0.4), 0.8)


def test_points_are_projected_as_by_hand() -> None:
    points = np.array([[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, -1.0, 4.0], [0.3, 0.4, 0.5]])
    by_hand = [(311, 247), (311 + 250, 247), (311, 247 - 130), (311 + 300, 247 + 416)]
    np.testing.assert_allclose(project(CAMERA, points), by_hand, rtol=1e-15)
    homogeneous = points @ intrinsics(CAMERA).T
    np.testing.assert_allclose(project(CAMERA, points), homogeneous[:, :2] / homogeneous[:, 2:], rtol=1e-15)


def test_what_lies_behind_the_camera_or_beside_its_lens_has_no_pixel() -> None:
    assert np.isnan(project(CAMERA, np.array([[0.1, 0.2, -1.0], [0.1, 0.2, 0.0]]))).all()


def test_the_first_pixels_centre_lies_half_a_pixel_from_the_pictures_corner() -> None:
    centres = pixel_centres(CAMERA)
    np.testing.assert_array_equal(centres[[0, 1, 640]], [(0.5, 0.5), (1.5, 0.5), (0.5, 1.5)])
    np.testing.assert_array_equal(centres[-1], (639.5, 479.5))
    middle = replace(CAMERA, width=3, height=1, centre_x=1.5, centre_y=0.5)
    np.testing.assert_array_equal(pixel_rays(middle)[1], (0.0, 0.0, 1.0))


@pytest.mark.parametrize("lens", [None, LENS], ids=["pinhole", "lens"])
def test_unprojected_pixels_project_onto_themselves(lens: Distortion | None) -> None:
    camera = replace(CAMERA, distortion=lens, renderer="ray_traced")
    rays = pixel_rays(camera)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0, rtol=1e-15)
    # A residual of RESIDUAL and rounding in normalised coordinates is 520 times that in pixels, beside that of 640 pixels.
    np.testing.assert_allclose(project(camera, 3.7 * rays), pixel_centres(camera), atol=1e3 * RESIDUAL)


def test_the_lens_is_browns_polynomial_and_its_inverse_agrees_with_another_solver() -> None:
    x, y = 0.31, -0.22
    s = x * x + y * y
    radial = 1 + LENS.k1 * s + LENS.k2 * s**2 + LENS.k3 * s**3
    by_hand = (
        x * radial + 2 * LENS.p1 * x * y + LENS.p2 * (s + 2 * x * x),
        y * radial + LENS.p1 * (s + 2 * y * y) + 2 * LENS.p2 * x * y,
    )
    np.testing.assert_allclose(distort(LENS, np.array([x, y])), by_hand, rtol=1e-15)
    wanted = np.array([[0.5, 0.4], [-0.6, 0.1], [0.0, 0.0]])
    for point, found in zip(wanted, undistort(LENS, wanted), strict=True):
        other = root(lambda p, point=point: distort(LENS, p) - point, point, method="lm", tol=1e-14)
        np.testing.assert_allclose(found, other.x, atol=1e-12)


def test_the_inverse_of_the_lens_keeps_its_stated_residual_over_the_whole_picture() -> None:
    x, y = np.meshgrid(np.linspace(-0.7, 0.7, 201), np.linspace(-0.5, 0.5, 151))
    points = np.stack([x, y], axis=-1)
    missed = np.linalg.norm(distort(LENS, undistort(LENS, points)) - points, axis=-1)
    assert missed.max() <= RESIDUAL + 16 * np.finfo(float).eps


def test_a_point_that_no_ray_reaches_is_refused_with_its_place() -> None:
    # x (1 - x^2) is 0.385 at most; what lies beyond its fold has roots, which belong to no lens.
    barrel = Distortion(k1=-1.0)
    cubic = np.roots([-1.0, 0.0, 1.0, -0.3])
    np.testing.assert_allclose(undistort(barrel, np.array([0.3, 0.0]))[0], min(cubic[cubic > 0]), atol=1e-14)
    with pytest.raises(ValueError, match=r"no ray comes to the normalised point \(0\.5, 0\)"):
        undistort(barrel, np.array([[0.1, 0.0], [0.5, 0.0]]))
    with pytest.raises(ValueError, match="no ray comes"):
        unproject(replace(CAMERA, distortion=barrel, renderer="ray_traced"), np.array([639.5, 247.0]))


def _mask(shape: Shape, p_S: tuple[float, float, float], q_S: tuple[float, float, float, float]) -> Floats:
    """Pixels that show a shape placed in S, by closed-form rays."""
    body = Body(name="b", motion="static", collision=(PlacedShape(shape=shape, p_BS=p_S, q_BS=q_S),), q_WB=TURNED)
    scene = Scene(bodies=(body,), sensors=(replace(CAMERA, q_BS=TURNED),))
    sensor = scene.sensors[0]
    assert isinstance(sensor, Camera)
    return true_sight(scene, sensor, State.initial(scene)).body.reshape(480, 640) == 0


def _inside_hull(corners_S: Floats) -> Floats:
    """Pixels whose centre lies in the convex hull of the projected points."""
    points = project(CAMERA, corners_S)
    around = points[ConvexHull(points).vertices]
    around = np.roll(around, -int(np.argmin(around[:, 0])), axis=0)
    # Counter-clockwise from the leftmost corner: along one side of the hull to the rightmost, and back along the other.
    far = int(np.argmax(around[:, 0]))
    there, back = around[: far + 1], np.concatenate([around[far:], around[:1]])[::-1]
    x, y = pixel_centres(CAMERA).T
    beside = (around[0, 0] <= x) & (x <= around[far, 0])
    return (beside & (np.interp(x, *there.T) <= y) & (y <= np.interp(x, *back.T))).reshape(480, 640)


@pytest.mark.parametrize("centre", [(0.0, 0.0, 2.5), (-0.9, -0.6, 3.0), (1.4, 1.1, 2.9)])
def test_the_silhouette_of_a_ball_is_the_conic_of_its_dual_quadric(centre: tuple[float, float, float]) -> None:
    """Hartley and Zisserman, equation 8.5: C* = P Q* P^T, with Q* = (r^2 I - c c^T) left of it for a camera at the origin."""
    radius, K, c = 0.5, intrinsics(CAMERA), np.array(centre)
    conic = np.linalg.inv(K @ (radius**2 * np.eye(3) - np.outer(c, c)) @ K.T)
    homogeneous = np.column_stack([pixel_centres(CAMERA), np.ones(640 * 480)])
    level = np.einsum("ri,ij,rj->r", homogeneous, conic, homogeneous).reshape(480, 640)
    middle = K @ c
    sign = np.sign(middle @ conic @ middle)
    np.testing.assert_array_equal(_mask(Sphere(radius=radius), centre, (1, 0, 0, 0)), sign * level >= 0)


def test_the_silhouette_of_a_box_is_the_hull_of_its_projected_corners() -> None:
    half, place, turn = np.array([0.4, 0.3, 0.5]), np.array([0.9, -0.5, 3.2]), np.array(axis_angle((1.0, 0.5, 0.2), 0.7))
    signs = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), axis=-1).reshape(-1, 3)
    corners = place + rotate(np.tile(turn, (8, 1)), signs * half)
    shown = _mask(Box(half_extents=tuple(half)), tuple(place), tuple(turn))
    np.testing.assert_array_equal(shown, _inside_hull(corners))


def test_the_silhouettes_of_cylinder_and_capsule_are_hulls_of_their_rims() -> None:
    turn = axis_angle((1.0, 0.3, 0.0), 1.0)
    place, radius, half = np.array([0.3, 0.2, 2.9]), 0.35, 0.4
    angle = np.linspace(0, 2 * np.pi, 4_000, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1) * radius
    q = np.tile(turn, (len(ring), 1))
    rims = np.concatenate([place + rotate(q, ring + np.array([0.0, 0.0, z])) for z in (-half, half)])
    shown = _mask(Cylinder(radius=radius, half_length=half), tuple(place), turn)
    # An inscribed polygon of 4000 corners lies 3e-7 of its radius, 60 pixels, inside: no pixel's centre falls between.
    np.testing.assert_array_equal(shown, _inside_hull(rims))

    def outline(centre: Floats) -> Floats:
        """The circle of a ball in which the cone from the camera touches it."""
        away = np.linalg.norm(centre)
        axis = centre / away
        side = np.cross(axis, [0.0, 1.0, 0.3])
        side /= np.linalg.norm(side)
        touch = radius * np.sqrt(1 - (radius / away) ** 2)
        along = centre * (1 - (radius / away) ** 2)
        return along + touch * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * np.cross(axis, side))

    ends = [outline(place + rotate(np.array(turn), np.array([0.0, 0.0, z]))) for z in (-half, half)]
    shown = _mask(Capsule(radius=radius, half_length=half), tuple(place), turn)
    np.testing.assert_array_equal(shown, _inside_hull(np.concatenate(ends)))


class Painter:
    """A simulation at rest that draws by closed forms: depth and bodies, each body in a grey of its own."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    def state(self, out: State) -> None:
        start = State.initial(self.scene)
        out.p_WB[:], out.q_WB[:] = start.p_WB, start.q_WB

    def render(self, camera: Camera, colour: bool = True) -> Image:
        sight = true_sight(self.scene, camera, State.initial(self.scene))
        shape = (camera.height, camera.width)
        grey = np.repeat((sight.body.reshape(shape) / 3)[..., None], 3, axis=-1)
        return Image(depth=sight.depth.reshape(shape), body=sight.body.reshape(shape), colour=grey if colour else None)


def _ball_before(camera: Camera) -> Scene:
    ball = Body(name="ball", motion="static", collision=(PlacedShape(shape=Sphere(radius=0.5)),), p_WB=(0.1, 0.0, 3.0))
    far = Body(name="far", motion="static", collision=(PlacedShape(shape=Sphere(radius=0.5)),), p_WB=(1.1, 0.4, 5.0))
    return Scene(bodies=(far, ball), sensors=(camera,))


def test_frames_come_at_the_cameras_rate_with_depth_bodies_and_colour() -> None:
    camera = replace(CAMERA, width=64, height=48, focal_x=50.0, focal_y=50.0, centre_x=32.0, centre_y=24.0)
    scene = _ball_before(camera)
    painter: Any = Painter(scene)
    recorder = SensorRecorder(scene, painter, 1, 0.05)
    assert recorder.interval_steps == 2
    for step in (0, 2, 4):
        recorder.read(step * 0.05, State.initial(scene))
    streams = recorder.streams()
    truth = true_frames(scene, camera, np.array([0.0, 0.1, 0.2]))
    np.testing.assert_allclose(streams["c/time"], truth["c/time"], atol=1e-15)
    np.testing.assert_array_equal(streams["c/depth"], truth["c/depth"])
    np.testing.assert_array_equal(streams["c/body"], truth["c/body"])
    assert set(np.unique(streams["c/body"])) == {-1, 0, 1}
    assert streams["c/colour"].shape == (3, 48, 64, 3)
    np.testing.assert_allclose(streams["c/colour"][..., 1], truth["c/body"] / 3, rtol=1e-7)
    assert {streams[f"c/{channel}"].dtype.name for channel in ("colour", "depth", "body")} == {"float32", "float64", "int32"}


def test_frames_that_would_fill_the_memory_are_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = replace(CAMERA, width=64, height=48, focal_x=50.0, focal_y=50.0, centre_x=32.0, centre_y=24.0)
    scene = _ball_before(camera)
    painter: Any = Painter(scene)
    recorder = SensorRecorder(scene, painter, 1, 0.05)
    # A frame of 64 x 48 pixels takes 8 + 4 + 3 x 4 bytes each.
    monkeypatch.setattr(camera_reader, "LARGEST", 2 * 64 * 48 * 24)
    recorder.read(0.0, State.initial(scene))
    recorder.read(0.1, State.initial(scene))
    with pytest.raises(Unsupported, match=r"sensor 'c': frame 3.*221184 bytes, expected at most 147456"):
        recorder.read(0.2, State.initial(scene))
