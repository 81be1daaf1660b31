"""Tall boxes on inclines: on rough ones they tip, on slippery ones they slide.

A box of half length b and half height h tips iff tan(angle) > b/h, if mu > b/h; else it slides iff tan(angle) > mu.
Source: Meriam and Kraige, Engineering Mechanics: Statics, 7th ed., section 6/3.
"""

import math

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics.statics import tipping_angle_error, wrong_fates
from plumbline.harness.scene import Body, Box, Effect, Scene, Surface, axis_angle, rotate

MASS = 1.0
HALF = (0.05, 0.05, 0.1)
THICKNESS, WIDTH, SPACING = 0.2, 0.2, 1.0
"""Half extents [m] of an incline along its normal and across the fall line, and the distance of one from the next."""
DURATION = 1.2


class P(Parameters):
    steepness: tuple[float, ...] = (0.8, 0.9, 0.95, 0.98, 1.02, 1.05, 1.1, 1.2)
    """tan(angle) of the inclines over that of the threshold: densest there, and never at it."""
    rough: float = 0.8
    slippery: float = 0.3


def scene(p: P) -> Scene:
    """Two rows along y of inclines with a box at rest on each, around the angles of tipping and of sliding; down is to +x.

    Args: steepness: tan(angle) over the smaller of b/h and mu; rough, slippery: friction of the two rows.
    """
    bodies = []
    rows = (("rough", p.rough), ("slippery", p.slippery))
    for row, (material, friction) in enumerate(rows):
        first = min(HALF[0] / HALF[2], friction)
        for i, steep in enumerate(p.steepness):
            angle = math.atan(steep * first)
            turn = axis_angle((0.0, 1.0, 0.0), angle)
            # Long enough for twice the way of a box that slides, or that tips and goes on without friction.
            length = 10 * HALF[2] + G * math.sin(angle) * DURATION**2
            below = rotate(turn, (0.0, 0.0, -THICKNESS - HALF[2]))
            here = SPACING * (i + row * len(p.steepness))
            bodies += [
                Body.fixed(
                    f"{material}_{i}",
                    Box(half_extents=(length, WIDTH, THICKNESS)),
                    material=material,
                    p_WB=(below[0], here, below[2]),
                    q_WB=turn,
                ),
                Body.box(f"box_{material}_{i}", HALF, mass=MASS, material=f"box_{material}", p_WB=(0.0, here, 0.0), q_WB=turn),
            ]
    laws = tuple(Surface.rough(mu, (f"box_{m}", m)) for m, mu in rows)
    among = (("box_rough", "box_rough"), ("box_rough", "box_slippery"), ("box_slippery", "box_slippery"))
    across = (("box_rough", "slippery"), ("box_slippery", "rough"))
    return Scene(bodies=tuple(bodies), surfaces=laws, apart=(*among, *across), narrow=Effect.GYROSCOPIC)


CASE = Case.of(
    globals(),
    title="Tipping or sliding",
    question="Does a tall box on an incline tip, slide or hold where it should?",
    source="Meriam and Kraige, Engineering Mechanics: Statics, 7th ed., section 6/3",
    truth="closed form",
    checks=(
        Check(
            tipping_angle_error,
            0.01,
            "the inclines next to the threshold stand 2 % of b/h to both sides; if they are told apart the middle lies "
            "within 0.1 % of it, and if not, the next bracket's lies 1.2 % off",
        ),
        Check(wrong_fates, 0.0, "no incline is at a threshold: on each one statics has one answer"),
    ),
)
