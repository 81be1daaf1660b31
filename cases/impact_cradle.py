"""Rows of equal elastic balls, hit at one end: with gaps one ball leaves at the other end; touching, only conservation counts.

With gaps the blow is a chain of pairs, each of which hands the whole velocity on. Touching balls take a blow together, and
Newton's law with one number e says nothing on how they share it: momentum and energy stay, the rest is the engine's choice.
Source: Herrmann, Schmaelzle, Am. J. Phys. 49 (1981) 761.
"""

import math

from plumbline.harness.case import Case, Check, Count, Parameters
from plumbline.harness.case.bounds import SOLVED
from plumbline.harness.metrics import conservation
from plumbline.harness.metrics.impacts import last_share_error, touching_last_share
from plumbline.harness.scene import Body, Scene, Surface

BALLS, SPEED = 5, 0.5
MASS, RADIUS, SPACING, RUN_UP = 0.1, 0.02, 0.5, 0.0313
DURATION = 0.25
SWEEPS = 10
"""Iterations of an iterative solver that its users get without asking (btContactSolverInfo)."""


class P(Parameters):
    gaps: tuple[float, ...] = (1e-3, 0.0)
    balls: Count = BALLS
    speed: float = SPEED


def scene(p: P) -> Scene:
    """For each gap [m] a row of `balls` along x at rest, but for the first, which comes at `speed` [m/s]; no gravity."""
    bodies = []
    for row, gap in enumerate(p.gaps):
        for i in range(p.balls):
            x = (2 * RADIUS + gap) * i
            bodies.append(
                Body.ball(
                    f"ball_{row}_{i}",
                    RADIUS,
                    mass=MASS,
                    material=f"row_{row}",
                    p_WB=(x if i else x - RUN_UP, SPACING * row, 0.0),
                    v_WB=(0.0 if i else p.speed, 0.0, 0.0),
                )
            )
    rows = [f"row_{row}" for row in range(len(p.gaps))]
    return Scene(
        bodies=tuple(bodies),
        surfaces=tuple(Surface(between=(row, row), restitution=1.0) for row in rows),
        gravity=(0.0, 0.0, 0.0),
        apart=tuple((a, b) for i, a in enumerate(rows) for b in rows[i + 1 :]),
    )


def _handed_on(_dt: float, p: P) -> float:
    """By how much the speed of the last ball may be off, as a share."""
    return SOLVED * (p.balls - 1) + 1e-6


CASE = Case.of(
    globals(),
    title="Newton's cradle",
    question="Does one ball leave a row of balls with gaps, and do momentum and energy stay where the balls touch?",
    source="Herrmann, Schmaelzle, Am. J. Phys. 49 (1981) 761",
    truth="conservation",
    sample_interval=1 / 240,
    # The ball must not cross a gap within a step: 0.5 m/s in 1/960 s is half of 1 mm.
    dt=1 / 960,
    ladder=(1 / 960, 1 / 1920, 1 / 3840, 1 / 7680, 1 / 15360, 1 / 30720),
    checks=(
        Check(
            last_share_error,
            _handed_on,
            "where a step is shorter than the way across a gap there is one pair at a time, whose exchange has no "
            "error of the step: each of the n - 1 blows hands on all but the share to which forces are solved for, 1e-4; 1e-6 "
            "for single precision",
        ),
        Check(
            conservation.momentum_drift_max,
            lambda _, p: 1e-6 * len(p.gaps) * MASS * p.speed,
            "a blow gives to one what it takes from the other; 1e-6 of all momentum there is, single precision",
        ),
        Check(
            conservation.energy_gain_max,
            lambda dt, p: 2 * _handed_on(dt, p),
            "no impact makes energy, however many balls touch; energy, being a square, errs by twice what the speeds "
            "handed on may err by",
        ),
        Check(
            conservation.energy_drift_final,
            lambda _, p: 2 * math.cos(math.pi / p.balls) ** (2 * SWEEPS),
            "with e = 1 Newton's law keeps the energy of any set of contacts that are struck together, since each "
            "impulse works on as much approach as parting; ten sweeps of Gauss and Seidel, the fewest in use, leave the share "
            "cos^2(pi/n)^10 of the blow on the n - 1 contacts of a row unsettled, and energy, being a square, twice that",
        ),
    ),
    observe=(touching_last_share,),
)
