"""A range finder in front of each primitive: does every beam end where geometry says, on curved surfaces too?"""

from plumbline.harness.case import Case, Check, Count, Parameters
from plumbline.harness.metrics import ranges
from plumbline.harness.scene import (
    WORLD,
    Appearance,
    Body,
    Box,
    Capsule,
    Cylinder,
    Lidar,
    Plane,
    Quaternion,
    Scene,
    Shape,
    Sphere,
    Vector3,
    axis_angle,
)
from plumbline.harness.sensors.true_views import seen

DURATION, RATE = 0.2, 10.0
REACH = 6.0
UNTURNED: Quaternion = (1.0, 0.0, 0.0, 0.0)
GRAZING = 0.005
"""No beam of the default pattern meets a surface at a smaller cosine of incidence; a test holds this."""
EXACT = 1e-9


class P(Parameters):
    channels: Count = 32
    columns: Count = 360


def _fixture(name: str, shape: Shape, p_WB: Vector3, q_WB: Quaternion = UNTURNED, reflectivity: float = 1.0) -> Body:
    look = Appearance(reflectivity=reflectivity)
    return Body.fixed(name, shape, p_WB=p_WB, q_WB=q_WB, appearance=look)


def scene(p: P) -> Scene:
    """Five primitives around a range finder that hangs in the world, tilted; a wall partly beyond its reach, and the sky."""
    shapes = (
        _fixture("floor", Plane(), (0.0, 0.0, 0.0), reflectivity=0.3),
        _fixture("ball", Sphere(radius=0.6), (2.2, 0.4, 1.1), reflectivity=0.9),
        _fixture("box", Box(half_extents=(0.4, 0.3, 0.6)), (0.5, 2.4, 0.9), axis_angle((0.3, 0.2, 1.0), 0.6), 0.5),
        _fixture("capsule", Capsule(radius=0.3, half_length=0.6), (-2.1, 0.9, 1.2), axis_angle((1.0, 0.4, 0.0), 0.8), 0.7),
        _fixture("cylinder", Cylinder(radius=0.4, half_length=0.7), (-0.7, -2.3, 1.0), axis_angle((0.2, 1.0, 0.1), 0.5), 0.6),
        _fixture("wall", Box(half_extents=(0.1, 8.0, 3.0)), (5.6, 0.0, 3.0), reflectivity=0.8),
    )
    lidar = Lidar(
        name="lidar",
        body=WORLD,
        rate=RATE,
        p_BS=(0.05, 0.02, 1.2),
        q_BS=axis_angle((0.6, 1.0, 0.3), 0.1),
        channels=p.channels,
        columns=p.columns,
        max_range=REACH,
    )
    return Scene(bodies=shapes, sensors=(lidar,), gravity=(0.0, 0.0, 0.0))


expected = seen(scene)

CASE = Case.of(
    globals(),
    title="A range finder and the primitives",
    question="Do an engine's rays end exactly on sphere, box, capsule, cylinder and plane, and on nothing beyond their reach?",
    source="Haines et al., Ray Tracing Gems (2019), chapter 7; Ericson, Real-Time Collision Detection, section 5.3",
    truth="closed form",
    sample_interval=0.1,
    checks=(
        Check(
            ranges.range_error_max,
            EXACT,
            "a root of a quadratic in double precision: 20 roundings of 6 m and of its ratio to the smallest radius, "
            "enlarged by 1/cos^2 of the most grazing beam, 20 * 2^-53 * 6 * 20/.005^2; an approximate ray is off by more",
        ),
        Check(
            ranges.range_false_return_share,
            0.0,
            "no beam passes the edge of a shape, or the end of its reach, so closely that rounding decides",
        ),
        Check(
            ranges.intensity_error_max,
            EXACT / (0.3 * GRAZING),
            "a hit that is off by the bound of the range, and by 1/cos of it along the surface, turns the normal of "
            "the most curved shape (radius .3 m) by that over the radius",
        ),
    ),
    observe=(ranges.range_error_rms, ranges.range_error_median),
)
