"""A scanning range finder in a room of primitives: are the ideal ranges right, and does their noise follow its law?"""

import numpy as np

from plumbline.harness.case import Case, Check, Count, Parameters
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics import ranges
from plumbline.harness.scene import (
    Appearance,
    Body,
    Box,
    Capsule,
    Cylinder,
    Lidar,
    LidarNoise,
    Plane,
    Quaternion,
    Scene,
    Shape,
    Sphere,
    Vector3,
    axis_angle,
)
from plumbline.harness.sensors.true_views import seen

DURATION = 1.0
RATE = 10.0
HALF = (4.0, 3.0, 1.5)
"""Half extents of the inside of the room [m]; the floor is at z = 0."""
NOISE = LidarNoise(range_sigma=0.02, range_sigma_slope=0.002, dropout=0.05)
REFLECTIVITY = 0.8
UNTURNED = (1.0, 0.0, 0.0, 0.0)
GRAZING = 0.015
"""No beam of the default pattern meets a surface at a smaller cosine of incidence; a test holds this."""


class P(Parameters):
    channels: Count = 32
    columns: Count = 360
    tilt: float = 0.1


def _fixture(name: str, shape: Shape, p_WB: Vector3, q_WB: Quaternion = UNTURNED) -> Body:
    look = Appearance(reflectivity=REFLECTIVITY)
    return Body.fixed(name, shape, p_WB=p_WB, q_WB=q_WB, appearance=look)


def scene(p: P) -> Scene:
    """A room with a ball, a box, a capsule and a cylinder, seen from a resting carrier tilted by `tilt` [rad]."""
    x, y, z = HALF
    t = 0.1
    walls = (
        _fixture("floor", Plane(), (0.0, 0.0, 0.0)),
        _fixture("ceiling", Box(half_extents=(x + 2 * t, y + 2 * t, t)), (0.0, 0.0, 2 * z + t)),
        _fixture("east", Box(half_extents=(t, y + 2 * t, z)), (x + t, 0.0, z)),
        _fixture("west", Box(half_extents=(t, y + 2 * t, z)), (-x - t, 0.0, z)),
        _fixture("north", Box(half_extents=(x, t, z)), (0.0, y + t, z)),
        _fixture("south", Box(half_extents=(x, t, z)), (0.0, -y - t, z)),
    )
    contents = (
        _fixture("ball", Sphere(radius=0.5), (2.1, 1.2, 0.9)),
        _fixture("box", Box(half_extents=(0.4, 0.3, 0.6)), (-2.0, 1.4, 0.8), axis_angle((0.3, 0.2, 1.0), 0.6)),
        _fixture("capsule", Capsule(radius=0.25, half_length=0.5), (-1.8, -1.5, 1.0), axis_angle((1.0, 0.4, 0.0), 0.8)),
        _fixture("cylinder", Cylinder(radius=0.35, half_length=0.7), (1.7, -1.6, 1.1), axis_angle((0.2, 1.0, 0.1), 0.5)),
    )
    half = (0.1, 0.1, 0.05)
    carrier = Body.box("carrier", half, touches=False, p_WB=(0.23, -0.17, 1.15), q_WB=axis_angle((0.6, 1.0, 0.3), p.tilt))
    lidar = Lidar(
        name="lidar",
        body="carrier",
        rate=RATE,
        p_BS=(0.05, 0.02, 0.08),
        q_BS=axis_angle((0.0, 0.0, 1.0), 0.3),
        channels=p.channels,
        columns=p.columns,
        max_range=20.0,
        noise=NOISE,
    )
    return Scene(bodies=(*walls, *contents, carrier), sensors=(lidar,), gravity=(0.0, 0.0, 0.0))


expected = seen(scene)

LONGEST = 2.0 * float(np.linalg.norm(HALF))
RANGE_BOUND = 8 * SINGLE * LONGEST / GRAZING
WITHIN = "five standard deviations: a false alarm in 6 of 10 million runs"

CASE = Case.of(
    globals(),
    title="Noise of a range finder",
    question="Do an engine's rays meet the primitives where geometry says, and has the noise laid over them its law?",
    source="Thrun, Burgard, Fox, Probabilistic Robotics, section 6.3; closed-form intersection of rays and primitives",
    truth="statistics",
    sample_interval=0.1,
    checks=(
        Check(
            ranges.range_error_max,
            RANGE_BOUND,
            "single precision: eight roundings of the room's diagonal, enlarged by 1/cos of the most grazing beam; "
            "rays in double precision stay below 1e-12 m",
        ),
        Check(
            ranges.range_false_return_share,
            0.0,
            "no beam passes the edge of a shape so closely that rounding decides what it meets",
        ),
        Check(
            ranges.intensity_error_max,
            RANGE_BOUND / 0.25,
            "a hit that lies wrong by the bound of the range turns the normal of the most curved shape (radius 0.25 m) "
            "by that over the radius",
        ),
        Check(ranges.range_mean_score, 5.0, WITHIN),
        Check(ranges.range_spread_score, 5.0, f"chi-squared of the squares as a normal score; {WITHIN}"),
        Check(
            ranges.range_distribution_distance,
            2.73,
            "Kolmogorov: sqrt(n) D exceeds x with probability 2 exp(-2 x^2), 7 in 10 million at 2.73",
        ),
        Check(ranges.range_correlation_score, 5.0, f"largest of three; {WITHIN} each"),
        Check(ranges.dropout_score, 5.0, f"Wilson's interval at z = 5 holds the law; {WITHIN}"),
    ),
    observe=(ranges.range_error_rms, ranges.range_error_median),
)
