"""A heavy box on a light one of the same size: does the light one bear it?

The contact at the ground must carry ratio + 1 times the weight of the body that it holds. A solver that goes from contact to
contact passes on, each time, only what the light body alone can take.
"""

from plumbline.harness.case import Axis, Case, Check, NotNegative, Parameters, Positive
from plumbline.harness.case.bounds import GIVE, G, settled_speed, stands, supported
from plumbline.harness.metrics import contacts, jitter, stack
from plumbline.harness.scene import Body, Scene, Surface
from plumbline.harness.truths.friction import resting

MASS, HALF = 1.0, 0.1
SETTLED, DURATION = 1.0, 2.0
SOFTNESS = 1e-5
"""What a solver of constraints may mix into the diagonal of its matrix, relative to it, to keep it regular: ODE's and DART's
default constraint force mixing. A contact gives by that share, times the load that it bears over the body that it holds."""


class P(Parameters):
    ratio: Positive = 1000.0
    friction: NotNegative = 0.5


def scene(p: P) -> Scene:
    """Two equal cubes, exactly touching: the lower of MASS, the upper of `ratio` times as much."""
    half, heavy = (HALF, HALF, HALF), p.ratio * MASS
    boxes = (
        Body.box("light", half, mass=MASS, p_WB=(0.0, 0.0, HALF)),
        Body.box("heavy", half, mass=heavy, p_WB=(0.0, 0.0, 3 * HALF)),
    )
    return Scene(bodies=(Body.ground("default"), *boxes), surfaces=(Surface.rough(p.friction),))


expected = resting(scene)

CASE = Case.of(
    globals(),
    title="Heavy on light",
    question="Does a light box bear one that is a thousand times heavier, and bear it still?",
    source="statics: the ground bears both weights, the light box the heavy one's; nothing moves, whatever the ratio",
    truth="rest",
    steady=SETTLED,
    hard=Axis(parameter="ratio", unit="1", easy=1, extreme=1e6),
    checks=(
        stands(DURATION, "the stack stands"),
        Check(
            stack.stack_height_error,
            lambda dt, p: 2 * (G * dt**2 * (1 + SOFTNESS * p.ratio) + GIVE) / (3 * HALF),
            "before a contact can push, a box falls for one step, g dt^2; if each of the two contacts gave as much, "
            "the top would sink by this share of the height of its centre, whatever the ratio; 1e-5 times the ratio more for a "
            "solver that keeps its matrix regular by such a share (ODE User Guide, Constraint Force Mixing); and a millimetre "
            "for each contact, which it may give way under weight",
        ),
        settled_speed(SETTLED, "a box"),
        supported(SETTLED, DURATION),
    ),
    observe=(contacts.penetration, jitter.rest_drift),
    insists={"friction": "nothing pushes sideways; under an engine's own noise friction is what keeps the boxes on each other"},
    headline="stack_height_error",
)
