"""A heavy box dropped on two small ones: do they bear it, half the load each?"""

import math

from plumbline.harness.case import Axis, Case, Check, NotNegative, Parameters, Positive
from plumbline.harness.case.bounds import G, settles_from_most_starts, stands
from plumbline.harness.case.symmetries import Retelling, other_starts
from plumbline.harness.metrics import contacts, jitter, stack
from plumbline.harness.scene import Body, Box, Effect, PlacedShape, Scene, Surface, box_inertia
from plumbline.harness.trajectory import Floats, Trajectory

MASS = 1.0
SMALL, APART = 0.1, 0.4
"""Half edge of the small cubes, and their centres' distance from the middle [m]."""
LARGE = (0.5, 0.25, 0.25)
SETTLED, DURATION = 1.0, 2.0


class P(Parameters):
    ratio: Positive = 400.0
    friction: NotNegative = 0.5
    drop: NotNegative = 0.02


def scene(p: P) -> Scene:
    """Two cubes of MASS on the ground; a box `ratio` times as heavy starts at rest, `drop` [m] above both."""
    cube = (PlacedShape(shape=Box(half_extents=(SMALL, SMALL, SMALL))),)
    small = [
        Body(name=name, mass=MASS, inertia=box_inertia(MASS, (SMALL, SMALL, SMALL)), collision=cube, p_WB=(x, 0.0, SMALL))
        for name, x in (("left", -APART), ("right", APART))
    ]
    heavy = Body.box("heavy", LARGE, mass=p.ratio * MASS, p_WB=(0.0, 0.0, 2 * SMALL + LARGE[2] + p.drop))
    return Scene(
        bodies=(Body.ground("default"), *small, heavy),
        surfaces=(Surface.rough(p.friction),),
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """Free fall, then rest: a blow of plastic bodies that stands on three levels takes all speed away."""
    truth = Trajectory.at_rest(scene(p), time)
    fall = math.sqrt(2 * p.drop / G)
    falls = truth.time < fall
    truth.p_WB[:, 3, 2] -= (G * truth.time**2 / 2) * falls + p.drop * ~falls
    truth.v_WB[:, 3, 2] = -G * truth.time * falls
    return truth


def retellings(p: P) -> tuple[Retelling, ...]:
    """Whether small boxes that have stopped a blow still tremble a second later hangs on the last bits of where all stood."""
    return other_starts(scene(p))


CASE = Case.of(
    globals(),
    title="A heavy box dropped on two small ones",
    question="Do two small boxes stop a box of four hundred times their mass, and then bear one half of it each?",
    source="statics: each support bears half of the load where pressures act at mid-face; plastic impact",
    truth="closed form",
    with_contacts=True,
    steady=SETTLED,
    hard=Axis(parameter="ratio", unit="1", easy=1, extreme=1e6),
    checks=(
        stands(DURATION, "the stack stands"),
        settles_from_most_starts(SETTLED, "boxes that come to rest"),
        Check(
            contacts.load_split_error,
            lambda dt, _: SMALL / (2 * APART) + dt / (DURATION - SETTLED) * (0.5 + LARGE[0] / (2 * APART)),
            "statics leaves open where on a face its pressure acts: moved by the half edge s of a support at the "
            "distance d, it changes the shares by s/(2 d); and the mean forces of the window miss those of rest by the change "
            "of the load's momentum, m g dt, and of its angular momentum, m g dt times the half length",
            start=SETTLED,
        ),
    ),
    observe=(contacts.penetration, jitter.rest_drift, stack.stack_height_error),
    insists={"friction": "nothing pushes sideways; under an engine's own noise friction is what keeps the boxes on each other"},
    headline="load_split_error",
)
