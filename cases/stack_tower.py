"""A tower of n boxes, built exactly touching: does it stand, at its height, with its weight on the ground?"""

from plumbline.harness.case import Axis, Case, Check, FloatCount, NotNegative, Parameters
from plumbline.harness.case.bounds import GIVE, G, settled_speed, supported
from plumbline.harness.metrics import contacts, stack
from plumbline.harness.scene import Body, Scene, Surface
from plumbline.harness.truths.friction import resting

MASS, HALF = 1.0, 0.1
DURATION, SETTLED = 5.0, 4.0
STEADY = 1.0
"""By then [s] a soft contact has found its depth; what a step costs does not change any more."""


class P(Parameters):
    n: FloatCount = 10
    friction: NotNegative = 0.5


def scene(p: P) -> Scene:
    """n equal cubes, one on the other."""
    boxes = [
        Body.box(f"box_{i}", (HALF, HALF, HALF), mass=MASS, p_WB=(0.0, 0.0, HALF * (2 * i + 1))) for i in range(round(p.n))
    ]
    return Scene(bodies=(Body.ground("default"), *boxes), surfaces=(Surface.rough(p.friction),))


expected = resting(scene)

CASE = Case.of(
    globals(),
    title="A tower of boxes",
    question="Does a tower of n boxes stand, keep its height, come to rest and bear n weights on the ground?",
    source="statics: box k bears the weight of the n - k above it; the ground bears n m g",
    truth="rest",
    steady=STEADY,
    hard=Axis(parameter="n", unit="1", easy=1, extreme=30),
    checks=(
        Check(stack.standing_height, 0.5, "the definition of a collapse: the top below half its height"),
        Check(
            stack.stack_height_error,
            lambda dt, p: (G * dt**2 * p.n * (p.n + 1) / 2 + p.n * GIVE) / ((2 * p.n - 1) * HALF),
            "boxes that touch exactly may be seen to touch only once they overlap. All fall alike in the first step, "
            "so that the ground shows first and box k sees its support only after k steps, in which it falls "
            "k (k + 1)/2 g dt^2; the top, k = n, over the height of its centre; and a millimetre for each contact, which it "
            "may give way under weight",
        ),
        Check(
            stack.residual_kinetic_energy,
            lambda dt, _: (G * dt) ** 2 / 2,
            "(g dt)^2/2, the energy that one step of gravity gives a box before its support takes it away",
            start=SETTLED,
        ),
        settled_speed(SETTLED, "a box"),
        supported(SETTLED, DURATION),
    ),
    observe=(
        stack.lean,
        contacts.penetration,
        contacts.signorini_residual,
        contacts.cone_residual,
        contacts.dissipation_residual,
    ),
    headline="stack_height_error",
)
