"""A box at rest on an incline that friction should hold: does it stay, or creep down?"""

import math
from typing import Annotated

from annotated_types import Interval

from plumbline.harness.case import Case, Check, NotNegative, Parameters, Positive
from plumbline.harness.case.bounds import GIVE, G, forces_obey_coulomb
from plumbline.harness.metrics import errors, jitter, slide
from plumbline.harness.scene import Body, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

DURATION, SETTLED = 2.5, 0.5
HALF = (0.1, 0.1, 0.05)


class P(Parameters):
    angle: Annotated[float, Interval(ge=0, lt=90)] = 10.0
    friction: NotNegative = 0.5
    mass: Positive = 1.0


def scene(p: P) -> Scene:
    """A box on ground from which gravity leans `angle` [degrees] towards +x: an incline seen from itself."""
    lean = math.radians(p.angle)
    box = Body.box("box", HALF, mass=p.mass, material="box", p_WB=(0.0, 0.0, HALF[2]))
    return Scene(
        bodies=(Body.ground(), box),
        gravity=(G * math.sin(lean), 0.0, -G * math.cos(lean)),
        surfaces=(Surface.rough(p.friction, ("box", "ground")),),
        # A box that lies still never turns.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """Rest, where tan(angle) <= mu.

    Raises:
        ValueError: friction does not hold the box.
    """
    if math.tan(math.radians(p.angle)) > p.friction:
        raise ValueError(f"angle {p.angle} degrees, expected at most atan({p.friction}): the box slides")
    return Trajectory.at_rest(scene(p), time)


FIRST_STEP = "a first step may pass before there is a contact to hold the box: g sin(angle) dt^2, twice for a staggered scheme"

CASE = Case.of(
    globals(),
    title="Creep on an incline",
    question="Does dry friction hold a box still, or is it a very thick oil?",
    source="Coulomb's law: at tan(angle) < mu a box at rest stays",
    truth="rest",
    scale=1e-3,
    checks=(
        Check(
            slide.creep_speed,
            1e-5,
            "ten micrometres a second, a millimetre in two minutes, is the least that a user who leaves a robot "
            "holding an object would see; Coulomb's law allows none",
            start=SETTLED,
        ),
        Check(
            errors.position_error_max,
            lambda dt, p: 2 * G * math.sin(math.radians(p.angle)) * dt**2 + GIVE,
            f"{FIRST_STEP}; and a millimetre for contacts that give way under the weight",
        ),
        *forces_obey_coulomb(),
    ),
    observe=(jitter.rms_speed, errors.position_error_final),
)
