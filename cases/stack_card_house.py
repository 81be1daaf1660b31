"""Two houses of two cards each: one with a little more friction at its feet than it needs, one with a little less.

Cards of half length l and half thickness c at the angle a to the vertical, edge to edge at the top, stand iff the friction of
their feet is at least (tan a - c/l)/2, which is tan(a)/2 for thin cards.
Source: Beer, Johnston, Vector Mechanics: Statics, 12th ed., sections 6.3 and 8.1.
"""

import math

from plumbline.harness.case import Axis, Case, Check, Parameters, Share
from plumbline.harness.metrics import contacts, statics
from plumbline.harness.scene import Body, Box, Effect, Scene, Surface, axis_angle

GRIP, MASS = 1.0, 0.1
"""Friction of card on card; mass of a card [kg]."""
HALF = (0.01, 0.15, 0.2)
PLATE = (0.5, 0.3, 0.05)
SPACING, DURATION = 2.0, 2.0


class P(Parameters):
    margin: Share = 0.1
    angle: float = 20.0
    """Share of the critical friction by which one house has more and the other less; angle of a card to the vertical [deg]."""


def scene(p: P) -> Scene:
    """Both houses, each on a plate of its own, exactly touching; their gables point along y."""
    a = math.radians(p.angle)
    critical = statics.critical_friction(a, HALF[2], HALF[0])
    bodies, laws = [], []
    # A card leans by its inner edge on the foot, and by the upper inner edge of its face on the other card.
    across = HALF[2] * math.sin(a) + HALF[0] * math.cos(a)
    high = HALF[2] * math.cos(a) + HALF[0] * math.sin(a)
    for k, (name, friction) in enumerate((("firm", (1 + p.margin) * critical), ("loose", (1 - p.margin) * critical))):
        x = SPACING * k
        bodies.append(Body.fixed(f"plate_{name}", Box(half_extents=PLATE), material=f"plate_{name}", p_WB=(x, 0.0, -PLATE[2])))
        bodies += [
            Body.box(
                f"{side}_{name}",
                HALF,
                mass=MASS,
                material=name,
                p_WB=(x - way * across, 0.0, high),
                q_WB=axis_angle((0.0, 1.0, 0.0), way * a),
            )
            for side, way in (("left", 1.0), ("right", -1.0))
        ]
        laws += [Surface.rough(friction, (name, f"plate_{name}")), Surface.rough(GRIP, (name, name))]
    apart = (("firm", "loose"), ("firm", "plate_loose"), ("loose", "plate_firm"))
    return Scene(bodies=tuple(bodies), surfaces=tuple(laws), apart=apart, narrow=Effect.GYROSCOPIC)


CASE = Case.of(
    globals(),
    title="Houses of two cards",
    question="Does a house of two cards stand with a tenth more friction than it needs, and fall with a tenth less?",
    source="Beer, Johnston, Vector Mechanics: Statics, 12th ed., sections 6.3 and 8.1",
    truth="closed form",
    with_contacts=True,
    hard=Axis(parameter="margin", unit="1", easy=0.5, extreme=0.01, lost=0.99 * DURATION),
    checks=(
        Check(
            statics.frame_friction_error,
            lambda _, p: p.margin / 2,
            "the two frictions stand to both sides of the critical one; if the houses are told apart the middle is the "
            "critical one, and if not, it lies more than half of it off",
        ),
        Check(
            statics.frame_standing_time,
            lambda dt, _: DURATION - dt.outer,
            "the firm house stands for the whole run, which ends within a step of its nominal length",
        ),
    ),
    observe=(contacts.penetration,),
    headline="frame_standing_time",
)
