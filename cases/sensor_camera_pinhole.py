"""Solids before nothing, photographed: does each appear in the pixels where the pinhole puts it, at its depth?"""

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.metrics.cameras import depth_error_max, depth_error_median, depth_error_rms, pixel_error, silhouette_iou
from plumbline.harness.scene import (
    Appearance,
    Body,
    Box,
    Camera,
    Capsule,
    Cylinder,
    PlacedShape,
    Quaternion,
    Scene,
    Shape,
    Sphere,
    Vector3,
    axis_angle,
)
from plumbline.harness.sensors.true_views import seen

RATE = 10.0
UNTURNED = (1.0, 0.0, 0.0, 0.0)
LOOK = axis_angle((0.3, 1.0, -0.2), 0.9)
"""Attitude of the camera; the solids are placed in its frame, x to the right, y down, z ahead."""


class P(Parameters):
    renderer: str = "rasterised"


def _solid(name: str, shape: Shape, p_S: Vector3, q_S: Quaternion, colour: Vector3) -> Body:
    """A solid placed in the frame S of the camera: S lies turned by LOOK in the carrier's frame, which is W's."""
    return Body(
        name=name,
        motion="static",
        collision=(PlacedShape(shape=shape, p_BS=p_S, q_BS=q_S),),
        q_WB=LOOK,
        appearance=Appearance(colour=colour),
    )


def scene(p: P) -> Scene:
    """A ball, a box, a capsule and a cylinder; the principal point is off the middle and pixels are not square."""
    solids = (
        _solid("ball", Sphere(radius=0.5), (-0.9, -0.6, 3.0), UNTURNED, (0.8, 0.2, 0.2)),
        _solid("box", Box(half_extents=(0.4, 0.3, 0.5)), (0.9, -0.5, 3.2), axis_angle((1.0, 0.5, 0.2), 0.7), (0.2, 0.7, 0.3)),
        _solid(
            "capsule", Capsule(radius=0.3, half_length=0.4), (-0.8, 0.8, 3.1), axis_angle((0.2, 1.0, 0.1), 1.1), (0.2, 0.4, 0.9)
        ),
        _solid(
            "cylinder",
            Cylinder(radius=0.35, half_length=0.4),
            (0.8, 0.7, 2.9),
            axis_angle((1.0, 0.3, 0.0), 1.0),
            (0.8, 0.7, 0.2),
        ),
    )
    camera = Camera(
        name="camera",
        body="world",
        rate=RATE,
        q_BS=LOOK,
        focal_x=500.0,
        focal_y=520.0,
        centre_x=311.0,
        centre_y=247.0,
        renderer=p.renderer,  # type: ignore[arg-type]  # checked there
    )
    return Scene(bodies=solids, sensors=(camera,), gravity=(0.0, 0.0, 0.0))


expected = seen(scene)

CASE = Case.of(
    globals(),
    title="Pictures of solids",
    question="Does a picture show each solid in the pixels where a pinhole puts it, and at its depth?",
    source="Hartley, Zisserman, Multiple View Geometry, 2nd ed., section 6.1; closed-form intersection of rays and solids",
    truth="closed form",
    duration=0.05,
    sample_interval=0.05,
    # What is seen does not depend on the time step: one is enough.
    ladder=(1 / 240,),
    checks=(
        Check(
            pixel_error,
            0.1,
            "a picture shifted by half a pixel shows five times this; a silhouette of 100 pixels' radius of which a "
            "thousandth of all pixels is wrong on one side shows this much",
        ),
        Check(
            silhouette_iou,
            0.999,
            "the least solid shows in 22 000 pixels with an outline of 600: wrong by 0.04 pixels all round",
        ),
        Check(
            depth_error_median,
            1e-6,
            "single precision at 4 m, four roundings; a curve drawn as flat facets errs by millimetres",
        ),
    ),
    observe=(depth_error_rms, depth_error_max),
)
