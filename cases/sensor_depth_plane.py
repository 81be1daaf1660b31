"""A depth camera that is carried towards a tilted plane: is z-depth what the plane's equation says, at every pixel and time?"""

from dataclasses import replace

import numpy as np

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics.cameras import depth_error_max, depth_error_median, depth_error_rms, silhouette_iou
from plumbline.harness.scene import Body, DepthCamera, Plane, Scene, axis_angle, multiply
from plumbline.harness.sensors.camera import intrinsics, pixel_centres
from plumbline.harness.sensors.true_views import stamps_up_to
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate, rotate_back

DURATION, RATE = 0.2, 10.0
FAR = 8.0
EYE = (0.0, 0.3, 2.0)
ALONG_X = axis_angle((-1.0, 1.0, -1.0), 2 * np.pi / 3)
"""Turns S so that its optical axis z looks along +x of W, x to the right (-y) and y down (-z)."""
GRAZING = 0.5
"""No pixel of the default scene meets the plane at a smaller cosine of incidence; a test holds this."""


class P(Parameters):
    tilt: float = 0.6
    speed: float = 1.5


def scene(p: P) -> Scene:
    """A plane through (6, 0, 0), upright but for `tilt` [rad], and a camera that comes nearer at `speed` [m/s]."""
    plane = Body.fixed("plane", Plane(normal=(-1.0, 0.0, 0.0)), p_WB=(6.0, 0.0, 0.0), q_WB=axis_angle((0.2, 1.0, 0.3), p.tilt))
    carrier = Body(
        name="carrier", motion="kinematic", p_WB=EYE, q_WB=axis_angle((1.0, 0.3, 0.2), 0.2), v_WB=(p.speed, 0.0, 0.0)
    )
    camera = DepthCamera(
        name="depth",
        body="carrier",
        rate=RATE,
        p_BS=(0.1, 0.05, -0.02),
        q_BS=multiply(axis_angle((0.0, 0.0, 1.0), 0.1), ALONG_X),
        width=160,
        height=120,
        focal_x=140.0,
        focal_y=150.0,
        centre_x=83.0,
        centre_y=57.0,
        far=FAR,
    )
    return Scene(bodies=(plane, carrier), sensors=(camera,), gravity=(0.0, 0.0, 0.0))


def expected(time: Floats, p: P) -> Trajectory:
    """z = d / (n . K^-1 (u, v, 1)) for a plane n . p = d in the frame of the camera; the carrier moves evenly."""
    stage = scene(p)
    camera, plane, carrier = stage.sensors[0], stage.bodies[0], stage.bodies[1]
    assert isinstance(camera, DepthCamera)
    truth = Trajectory.at_rest(stage, time)
    truth.p_WB[:, 1, 0] += p.speed * truth.time
    truth.v_WB[:, 1, 0] = p.speed
    stamps = stamps_up_to(float(truth.time[-1]), RATE) if len(truth) else np.zeros(0)
    q_WS = np.array(multiply(carrier.q_WB, camera.q_BS))
    normal_W = -rotate(np.array(plane.q_WB), np.array([1.0, 0.0, 0.0]))
    eye_W = np.array(EYE) + rotate(np.array(carrier.q_WB), np.array(camera.p_BS))
    eyes_W = eye_W + stamps[:, None] * np.array([p.speed, 0.0, 0.0])
    offset = (np.array(plane.p_WB) - eyes_W) @ normal_W
    pixels = np.column_stack([pixel_centres(camera), np.ones(camera.width * camera.height)])
    along = pixels @ np.linalg.inv(intrinsics(camera)).T @ rotate_back(q_WS, normal_W)
    depth = offset[:, None] / along
    seen = (along < 0) & (depth >= camera.near) & (depth <= camera.far)
    shape = (len(stamps), camera.height, camera.width)
    streams = {
        "depth/time": stamps,
        "depth/depth_ideal": np.where(seen, depth, np.inf).reshape(shape),
        "depth/body": np.where(seen, 0.0, -1.0).reshape(shape),
    }
    return replace(truth, streams=streams)


CASE = Case.of(
    globals(),
    title="Depth of a plane",
    question="Is the depth of a plane what its equation says at every pixel, from a camera that moves?",
    source="Hartley, Zisserman, Multiple View Geometry, 2nd ed., section 6.1: z = d / (n . K^-1 (u, v, 1))",
    truth="closed form",
    sample_interval=0.1,
    # Steady motion is the same at every step; two steps show that the frames keep their times.
    ladder=(1 / 60, 1 / 240),
    headline=depth_error_median.name,
    checks=(
        Check(
            depth_error_max,
            8 * SINGLE * FAR / GRAZING,
            "single precision: eight roundings of the longest depth, enlarged by 1/cos of the most grazing pixel; rays "
            "in double precision stay below 1e-12 m",
        ),
        Check(
            silhouette_iou,
            0.9995,
            "where the plane lies farther than `far` it ends in the picture: along that line of at most 160 pixels "
            "rounding may decide some, 9 of 19 200",
        ),
    ),
    observe=(depth_error_median, depth_error_rms),
)
