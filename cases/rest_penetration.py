"""One body on the ground: how deep does it sink in, and does the ground bear its weight?"""

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import GIVE, G, bears, settled_speed, supported
from plumbline.harness.metrics import contacts, jitter
from plumbline.harness.scene import Body, Box, Capsule, Cylinder, Scene, Shape, Sphere, Surface, axis_angle
from plumbline.harness.truths.friction import resting

MASS, HALF = 1.0, 0.1
SETTLED, DURATION = 1.0, 2.0


class P(Parameters):
    shape: str = "box"
    friction: NotNegative = 0.5


def scene(p: P) -> Scene:
    """A box, sphere or cylinder of half-height HALF standing on a plane, or a capsule lying on it; it just touches."""
    shapes: dict[str, Shape] = {
        "box": Box(half_extents=(HALF, HALF, HALF)),
        "sphere": Sphere(radius=HALF),
        "cylinder": Cylinder(radius=HALF, half_length=HALF),
        "capsule": Capsule(radius=HALF, half_length=HALF),
    }
    laid = axis_angle((0.0, 1.0, 0.0), 1.5707963267948966) if p.shape == "capsule" else (1.0, 0.0, 0.0, 0.0)
    body = Body.solid(p.shape, shapes[p.shape], mass=MASS, p_WB=(0.0, 0.0, HALF), q_WB=laid)
    return Scene(bodies=(Body.ground("default"), body), surfaces=(Surface.rough(p.friction),))


expected = resting(scene)

CASE = Case.of(
    globals(),
    title="One body at rest",
    question="How deep does a body at rest sink into the ground, and does the ground bear just its weight?",
    source="statics: a rigid body on a rigid plane neither sinks nor moves; its support equals its weight",
    truth="rest",
    # Every step: a body that sinks by its first step's fall is deepest then.
    sample_interval=0.0,
    steady=SETTLED,
    checks=(
        bears("the body"),
        Check(
            jitter.rest_drift,
            lambda dt, _: G * dt**2 + GIVE,
            "what stands on the ground stays: it neither hovers nor slides away by more than it may sink",
        ),
        settled_speed(SETTLED),
        supported(SETTLED, DURATION),
    ),
    observe=(
        contacts.reported_penetration,
        contacts.signorini_residual,
        contacts.cone_residual,
        contacts.dissipation_residual,
    ),
    insists={"friction": "nothing pushes sideways; under an engine's own noise friction is what keeps a body in its place"},
    scale=HALF,
)
