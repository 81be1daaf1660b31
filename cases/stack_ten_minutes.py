"""A small tower left alone for ten minutes: what a short run cannot show, a creep, a slow gain of energy, an early sleep.

A box that creeps by a micrometre a second passes every check of a few seconds; here it has left its place by half a millimetre.
"""

from plumbline.harness.case import Case, Check, FloatCount, NotNegative, Parameters
from plumbline.harness.case.bounds import GIVE, G, settled_speed, stands
from plumbline.harness.metrics import conservation, jitter, stack
from plumbline.harness.scene import Body, Scene, Surface
from plumbline.harness.truths.friction import resting

MASS, HALF = 1.0, 0.1
DURATION, SETTLED = 600.0, 60.0


class P(Parameters):
    n: FloatCount = 4
    friction: NotNegative = 0.5


def scene(p: P) -> Scene:
    """n equal cubes, one on the other."""
    half = (HALF, HALF, HALF)
    boxes = tuple(Body.box(f"box_{k}", half, mass=MASS, p_WB=(0.0, 0.0, HALF * (2 * k + 1))) for k in range(round(p.n)))
    return Scene(bodies=(Body.ground("default"), *boxes), surfaces=(Surface.rough(p.friction),))


expected = resting(scene)

CASE = Case.of(
    globals(),
    title="A tower for ten minutes",
    question="Does a small tower stand for ten minutes without creeping away, sinking in or coming to life?",
    source="statics: nothing moves, however long one looks",
    truth="rest",
    sample_interval=0.5,
    # Ten minutes at the finer steps of other cases would cost more than all of those together.
    ladder=(1 / 30, 1 / 40, 1 / 60, 1 / 90, 1 / 120, 1 / 240),
    checks=(
        stands(DURATION, "the tower stands"),
        Check(
            stack.stack_height_error,
            lambda dt, p: (G * dt**2 * p.n * (p.n + 1) / 2 + p.n * GIVE) / ((2 * p.n - 1) * HALF),
            "boxes that touch exactly may be seen to touch only once they overlap: the top one, k = n, sees its "
            "support after k steps, in which it falls k (k + 1)/2 g dt^2, over the height of its centre; and a millimetre for "
            "each contact, which it may give way under weight. Neither grows in ten minutes",
        ),
        settled_speed(SETTLED, "a box"),
    ),
    observe=(jitter.rest_drift, stack.lean, conservation.energy_gain_max),
    headline="rest_drift",
    scale=HALF,
)
