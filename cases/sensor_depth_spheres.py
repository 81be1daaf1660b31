"""Balls before nothing, seen by a depth camera: z-depth and not range, and silhouettes that are the cone's sections."""

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics.cameras import depth_error_max, depth_error_median, depth_error_rms, pixel_error, silhouette_iou
from plumbline.harness.scene import Body, DepthCamera, Scene, Sphere
from plumbline.harness.sensors.true_views import seen

RATE = 10.0
BALLS = (
    (0.5, (0.0, 0.0, 2.6)),
    (0.45, (-1.05, -0.55, 2.9)),
    (0.6, (1.5, 0.4, 3.9)),
    (0.3, (0.55, -0.75, 2.0)),
    (0.7, (-1.6, 1.25, 4.4)),
    (0.25, (-0.35, 0.55, 1.6)),
)
"""Radius [m] and centre [m] in S, x to the right and y down; two overlap, three are cut by the picture's edge."""
LONGEST = 5.0
"""No pixel sees a ball at a greater range [m]; a test holds this."""


class P(Parameters):
    seen_by: str = "rays"


def scene(p: P) -> Scene:
    """Six balls around a camera at the origin that looks along +z of W."""
    balls = [Body.fixed(f"ball_{k}", Sphere(radius=radius), p_WB=centre) for k, (radius, centre) in enumerate(BALLS)]
    camera = DepthCamera(name="depth", body="world", rate=RATE, far=8.0, seen_by=p.seen_by)  # type: ignore[arg-type]  # checked there
    return Scene(bodies=tuple(balls), sensors=(camera,), gravity=(0.0, 0.0, 0.0))


expected = seen(scene)

CASE = Case.of(
    globals(),
    title="Depth of balls",
    question="Is the depth of a curved surface z-depth, and are silhouettes in the right pixels?",
    source="closed-form intersection of rays and balls; Hartley, Zisserman, Multiple View Geometry, 2nd ed., section 8.3",
    truth="closed form",
    duration=0.05,
    sample_interval=0.05,
    # What is seen does not depend on the time step: one is enough.
    ladder=(1 / 240,),
    checks=(
        Check(
            depth_error_median,
            4 * SINGLE * LONGEST,
            "single precision: four roundings of the longest range, which at half of a ball's pixels a lean of less "
            "than 45 degrees does not enlarge; range taken for depth errs by centimetres",
        ),
        Check(
            silhouette_iou,
            0.999,
            "the least ball shows in 13 900 pixels with an outline of 450: a silhouette wrong by 0.03 pixels all round",
        ),
        Check(
            pixel_error,
            0.1,
            "a tenth of the half pixel by which a wrong centre of pixels moves everything, and the shift of a ball of "
            "100 pixels' radius of which a thousandth of all pixels is wrong on one side",
        ),
    ),
    observe=(depth_error_rms, depth_error_max),
)
