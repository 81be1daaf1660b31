"""A hall seen by a stereo, a structured-light and a time-of-flight camera: has each the noise and the gaps of its principle?"""

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics import cameras
from plumbline.harness.scene import (
    Appearance,
    Body,
    Box,
    DepthCamera,
    DepthNoise,
    Plane,
    Scene,
    Shape,
    StereoNoise,
    StructuredLightNoise,
    Sun,
    TimeOfFlightNoise,
    Vector3,
    axis_angle,
)
from plumbline.harness.sensors.true_views import seen

DURATION, RATE = 0.3, 10.0
WIDTH, HEIGHT, FOCAL = 128, 96, 120.0
FAR = 10.0
WALL, BLOCK = 6.0, 2.0
"""Where the wall and the front of the block before it stand along x [m]."""
EYE = (0.0, 0.0, 1.2)
ALONG_X = axis_angle((-1.0, 1.0, -1.0), 2 * np.pi / 3)
"""Turns S so that its optical axis z looks along +x of W, x to the right (-y) and y down (-z)."""
GRAZING = 0.13
"""No pixel meets a surface at a smaller cosine of incidence; a test holds this."""

STEREO = StereoNoise(
    baseline=0.12, disparity_sigma=0.1, disparity_step=0.125, least_texture=0.5, steepest=np.radians(76.0), missing=0.02
)
PATTERN = StructuredLightNoise(
    baseline=0.077,
    disparity_sigma=0.06,
    disparity_step=0.0625,
    least_signal=0.005,
    least_contrast=0.25,
    steepest=np.radians(76.0),
    missing=0.05,
)
PHASE = TimeOfFlightNoise(
    range_sigma=0.01, range_sigma_slope=0.002, unambiguous_range=4.0, least_signal=0.003, least_contrast=0.2, missing=0.03
)


class P(Parameters):
    infrared: NotNegative = 0.1


def _fixture(name: str, shape: Shape, p_WB: Vector3, look: Appearance) -> Body:
    return Body.fixed(name, shape, p_WB=p_WB, appearance=look)


def _camera(name: str, noise: DepthNoise) -> DepthCamera:
    return DepthCamera(
        name=name,
        body="rig",
        rate=RATE,
        q_BS=ALONG_X,
        width=WIDTH,
        height=HEIGHT,
        focal_x=FOCAL,
        focal_y=FOCAL,
        centre_x=WIDTH / 2,
        centre_y=HEIGHT / 2,
        far=FAR,
        noise=noise,
    )


def scene(p: P) -> Scene:
    """A floor, a wall with a mirror, a pane of glass and a black panel on it, a block before them; a low sun from behind."""
    pale = Appearance(reflectivity=0.8)
    on_wall = Box(half_extents=(0.05, 0.6, 0.5))
    bodies = (
        _fixture("floor", Plane(), (0.0, 0.0, 0.0), pale),
        _fixture("wall", Box(half_extents=(0.1, 6.0, 3.0)), (WALL + 0.1, 0.0, 3.0), pale),
        _fixture("block", Box(half_extents=(0.2, 0.31, 0.45)), (BLOCK + 0.2, 0.23, 0.95), pale),
        _fixture("mirror", on_wall, (WALL - 0.05, 2.1, 2.3), Appearance(mirror=1.0)),
        _fixture("pane", on_wall, (WALL - 0.05, -1.9, 2.4), Appearance(transmission=0.9)),
        _fixture("panel", on_wall, (WALL - 0.05, -1.7, 1.0), Appearance(reflectivity=0.04)),
        Body(name="rig", motion="static", p_WB=EYE),
    )
    cameras = (_camera("stereo", STEREO), _camera("pattern", PATTERN), _camera("phase", PHASE))
    sun = Sun(towards_W=(-1.0, 0.5, 0.5), infrared=p.infrared)
    return Scene(bodies=bodies, sensors=cameras, gravity=(0.0, 0.0, 0.0), sun=sun)


expected = seen(scene)

WITHIN = "five standard deviations: a false alarm in 6 of 10 million runs"

CASE = Case.of(
    globals(),
    title="Noise of depth cameras",
    question="Have depths by stereo, structured light and time of flight the noise, steps and gaps of their principle?",
    source="Khoshelham, Elberink, Sensors 12 (2012) 1437; Gallup et al., CVPR 2008; Hansard et al., Time-of-Flight Cameras",
    truth="statistics",
    sample_interval=0.1,
    # What is seen does not depend on the time step: one is enough.
    ladder=(1 / 240,),
    checks=(
        Check(
            cameras.depth_error_max,
            8 * SINGLE * FAR / GRAZING,
            "single precision: eight roundings of the longest depth, enlarged by 1/cos of the most grazing pixel; rays "
            "in double precision stay below 1e-12 m",
        ),
        Check(cameras.depth_mean_score, 5.0, f"{WITHIN}; the worst of 24 bands in 1 of 70 000"),
        Check(
            cameras.depth_spread_score,
            5.0,
            f"chi-squared of the squares as a normal score; {WITHIN}; the worst of 24 bands in 1 of 70 000",
        ),
        Check(cameras.depth_correlation_score, 5.0, f"largest of nine; {WITHIN} each"),
        Check(cameras.depth_missing_score, 5.0, f"Wilson's interval at z = 5 holds the law; {WITHIN}, of three"),
        Check(
            cameras.depth_lost_but_answered_share,
            0.0,
            "no pixel lies so close to the edge of a shadow, or to a bound of light or angle, that rounding decides it",
        ),
        Check(
            cameras.disparity_step_error,
            1e-12,
            "f b over a depth that was f b over a multiple of the step: three roundings in double precision of at most "
            "200 steps stay below 2e-13",
        ),
        Check(cameras.range_unwrapped_share, 0.0, "a phase has no second turn"),
    ),
    observe=(cameras.depth_error_median,),
)
