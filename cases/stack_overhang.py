"""Bricks laid on each other over the edge of a table: how far do they reach before they fall?

Laid so that the common centre of mass of the k highest lies over the edge below, brick k stands 1/(2 k) of its length beyond
brick k + 1, and n bricks reach (1 + 1/2 + ... + 1/n)/2 lengths: the harmonic stack. Scaled by a factor, all its edges fail
together: the centre of mass of all bricks above any edge lies (factor - 1)/2 lengths beyond it.
Source: Hall, Fun with Stacking Blocks, Am. J. Phys. 73 (2005) 1107.
"""

from plumbline.harness.case import Axis, Case, Check, FloatCount, NotNegative, Parameters
from plumbline.harness.case.symmetries import Retelling, other_starts
from plumbline.harness.metrics import contacts, statics
from plumbline.harness.scene import Body, Box, Effect, Scene, Surface

MASS = 1.0
FACTORS = (0.8, 0.9, 0.95, 0.98, 1.02, 1.05, 1.1, 1.2)
"""Overhang over the limit: densest there, and never at it."""
HALF = (0.2, 0.1, 0.05)
TABLE = (0.3, 0.15, 0.2)
SPACING, DURATION = 1.0, 1.5


class P(Parameters):
    n: FloatCount = 4
    factors: tuple[float, ...] = FACTORS
    friction: NotNegative = 0.5


def scene(p: P) -> Scene:
    """One table with n bricks for each factor, side by side along y; the tables end at x = 0, and the bricks lean to +x."""
    bodies = []
    count = round(p.n)
    for i, factor in enumerate(p.factors):
        y = SPACING * i
        bodies.append(Body.fixed(f"table_{i}", Box(half_extents=TABLE), material="table", p_WB=(-TABLE[0], y, TABLE[2])))
        end = 0.0
        for level in range(count):
            end += factor * HALF[0] / (count - level)
            bodies.append(
                Body.box(
                    f"brick_{i}_{level}",
                    HALF,
                    mass=MASS,
                    material="brick",
                    p_WB=(end - HALF[0], y, 2 * TABLE[2] + HALF[2] * (2 * level + 1)),
                )
            )
    laws = tuple(Surface.rough(p.friction, pair) for pair in (("brick", "brick"), ("brick", "table")))
    return Scene(bodies=tuple(bodies), surfaces=laws, narrow=Effect.GYROSCOPIC)


def retellings(p: P) -> tuple[Retelling, ...]:
    """Whether what stands a hundredth beside its limit falls may hang on the last bits of where all stood."""
    return other_starts(scene(p))


CASE = Case.of(
    globals(),
    title="Bricks over an edge",
    question="How far beyond the edge of a table can n bricks reach before they fall?",
    source="Hall, Fun with Stacking Blocks, Am. J. Phys. 73 (2005) 1107",
    truth="closed form",
    with_contacts=True,
    hard=Axis(parameter="n", unit="1", easy=1, extreme=30),
    checks=(
        Check(
            statics.overhang_limit_error,
            0.01,
            "the stacks next to the limit stand 2 % to both sides; if they are told apart the middle is the limit, and "
            "if not, the next bracket's lies 1.5 % off; judged is the middle of eight starts that nobody could tell apart",
        ),
    ),
    observe=(contacts.penetration,),
)
