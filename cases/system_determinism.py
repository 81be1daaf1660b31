"""The same scene once more, and again from a saved state in mid-contact: is every bit the same?

Boxes and balls fall on each other askew. Blows multiply what differs: an engine that is not told to repeat itself, or that
forgets a part of its state (a warm start, a contact's age, the order of its pairs), shows it within tenths of a second.

The order in which bodies are listed is observed, not checked: no law says in which order a solver takes contacts, and every
solver that sweeps through them ends, after a finite number of sweeps, with an answer that depends on it.
"""

import numpy as np

from plumbline.harness.case import Case, Check, FloatCount, Parameters
from plumbline.harness.case.symmetries import Retelling, reordered, repeated, restored
from plumbline.harness.metrics.equivalence import AGREEING_SAMPLES, DIFFERENCE, POSITION_DIFFERENCE
from plumbline.harness.scene import Body, Box, Scene, Shape, Sphere, Surface, axis_angle

FRICTION, MASS, HALF, RADIUS = 0.5, 1.0, (0.1, 0.08, 0.06), 0.08
SAVED, DURATION = 0.5, 1.0
FLOOR = (2.0, 2.0, 0.5)


class P(Parameters):
    n: FloatCount = 6
    seed: int = 0


def scene(p: P) -> Scene:
    """n boxes and balls by turns, one above the other, turned and shifted at random, falling on a floor."""
    draw = np.random.default_rng(p.seed)
    bodies = [Body.fixed("floor", Box(half_extents=FLOOR), p_WB=(0.0, 0.0, -FLOOR[2]))]
    for k in range(round(p.n)):
        shape: Shape = Sphere(radius=RADIUS) if k % 2 else Box(half_extents=HALF)
        axis, (x, y) = draw.standard_normal(3), draw.uniform(-0.04, 0.04, 2)
        bodies.append(
            Body.solid(
                f"body_{k}",
                shape,
                mass=MASS,
                p_WB=(float(x), float(y), 0.2 + 0.22 * k),
                q_WB=axis_angle((axis[0], axis[1], axis[2]), float(draw.uniform(0.0, np.pi))),
            )
        )
    return Scene(bodies=tuple(bodies), surfaces=(Surface.rough(FRICTION),))


def retellings(p: P) -> tuple[Retelling, ...]:
    """Once more; from what was saved half-way; in the other order."""
    stage = scene(p)
    return repeated(stage), restored(stage, SAVED), reordered(stage)


CASE = Case.of(
    globals(),
    title="The same again",
    question="Does the same scene give the same bits, run again and taken up again from a saved state in mid-contact?",
    source="definition: arithmetic of IEEE 754 is a function of its operands and their order",
    truth="conservation",
    # Every step, to name the first that differs.
    sample_interval=0.0,
    ladder=(1 / 60, 1 / 90, 1 / 120, 1 / 240, 1 / 480, 1 / 960),
    checks=(
        Check(DIFFERENCE["repeated"], 0.0, "the same operations on the same numbers give the same bits"),
        Check(
            DIFFERENCE["restored"],
            0.0,
            "a saved state is all that decides the future, so that the same operations follow on the same numbers",
        ),
    ),
    observe=(
        AGREEING_SAMPLES["repeated"],
        AGREEING_SAMPLES["restored"],
        AGREEING_SAMPLES["reordered"],
        POSITION_DIFFERENCE["reordered"],
    ),
)
