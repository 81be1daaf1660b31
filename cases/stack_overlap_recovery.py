"""Two boxes that start a quarter of an edge inside each other: do they part quietly?

No mechanics begins like this, but designers do. What a rigid body can do is to leave the other on the shortest way and to be at
rest where they touch: an overlap is an error of position, and holds no energy.
"""

from plumbline.harness.case import Axis, Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import G, bears, settled_speed
from plumbline.harness.metrics import jitter, overlaps, stack
from plumbline.harness.scene import Body, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

MASS, HALF = 1.0, 0.1
SETTLED, DURATION = 2.0, 3.0


class P(Parameters):
    overlap: NotNegative = 0.25
    friction: NotNegative = 0.5


def _boxes(overlap: float) -> tuple[Body, Body]:
    return tuple(  # type: ignore[return-value]
        Body.box(name, (HALF, HALF, HALF), mass=MASS, p_WB=(0.0, 0.0, height))
        for name, height in (("lower", HALF), ("upper", HALF * (3 - 2 * overlap)))
    )


def scene(p: P) -> Scene:
    """Two equal cubes, the lower on the ground, the upper inside of it by the share `overlap` of an edge."""
    return Scene(bodies=(Body.ground("default"), *_boxes(p.overlap)), surfaces=(Surface.rough(p.friction),))


def expected(time: Floats, _: P) -> Trajectory:
    """At rest, one on the other, from the start."""
    truth = Trajectory.of(time, 3)
    truth.p_WB[:] = [(0.0, 0.0, 0.0), *(body.p_WB for body in _boxes(0.0))]
    return truth


CASE = Case.of(
    globals(),
    title="Starting inside each other",
    question="Do two boxes that start a quarter inside each other part quietly, and come to rest one on the other?",
    source="definition: an overlap holds no energy, so that none is left when it is gone",
    truth="rest",
    with_contacts=True,
    hard=Axis(parameter="overlap", unit="1", easy=0.0, extreme=0.45, lost=1.0),
    checks=(
        Check(
            overlaps.ejection_speed,
            lambda dt, _: G * dt,
            "g dt, what one step of gravity gives a box: a speed that the next step's gravity takes away again",
        ),
        Check(
            stack.residual_kinetic_energy,
            lambda dt, _: (G * dt) ** 2 / 2,
            "(g dt)^2/2, the energy that one step of gravity gives a box before its support takes it away",
            start=SETTLED,
        ),
        settled_speed(SETTLED, "a box"),
        bears("a box", SETTLED),
    ),
    observe=(stack.lean, jitter.rest_drift),
    insists={"friction": "what is pushed apart may come out askew; friction is what stops it then"},
)
