"""Boxes left alone: a single one and a short column, watched after they had time to settle.

Nothing acts but weight and support, so nothing moves. What moves is the engine's jitter.
"""

from plumbline.harness.case import Case, Check, FloatCount, NotNegative, Parameters
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import contacts, jitter
from plumbline.harness.scene import Body, Scene, Surface
from plumbline.harness.truths.friction import resting

MASS, HALF = 1.0, 0.1
SETTLED, DURATION = 5.0, 6.0
SHARE = 0.01
"""Share of g that a jitter may reach: the noise of a consumer accelerometer over its band (300 micro-g/sqrt(Hz) over 1 kHz is
0.0095 g), so that a sensor mounted on a resting box shows its own noise and not the engine's."""


class P(Parameters):
    n: FloatCount = 5
    friction: NotNegative = 0.5


def scene(p: P) -> Scene:
    """A single box and, beside it, a column of n; all start exactly touching."""
    places = [(-1.0, 0.0, HALF)] + [(0.0, 0.0, HALF * (2 * i + 1)) for i in range(round(p.n))]
    boxes = [Body.box(f"box_{i}", (HALF, HALF, HALF), mass=MASS, p_WB=centre) for i, centre in enumerate(places)]
    return Scene(bodies=(Body.ground("default"), *boxes), surfaces=(Surface.rough(p.friction),))


expected = resting(scene)

CASE = Case.of(
    globals(),
    title="Standing still",
    question="Does what should rest, rest?",
    source="statics: each box in equilibrium under its weight and the forces of its neighbours",
    truth="rest",
    # Every step: a jitter from step to step is invisible, or takes the look of a slow one, between samples further apart.
    sample_interval=0.0,
    checks=(
        Check(
            jitter.rms_speed,
            lambda dt, _: SHARE * G * dt,
            "0.01 g, the noise of a consumer accelerometer, over one step",
            start=SETTLED,
        ),
        Check(
            jitter.rms_spin,
            lambda dt, _: SHARE * G * dt / HALF,
            "the speed of 0.01 g over one step, at the edge of a box",
            start=SETTLED,
        ),
        Check(
            jitter.rms_second_difference,
            lambda dt, _: SHARE * G * dt**2,
            "0.01 g, the noise of a consumer accelerometer: one mounted on the box would see no more than its own",
            start=SETTLED,
        ),
        Check(
            jitter.height_spread,
            lambda dt, _: 2 * SHARE * G * dt**2,
            "up and down by the way of 0.01 g over one step",
            start=SETTLED,
        ),
        Check(
            jitter.rest_drift,
            lambda dt, _: SHARE * G * dt * (DURATION - SETTLED),
            "the speed of 0.01 g over one step, kept up in one direction for the whole window",
            start=SETTLED,
        ),
        Check(contacts.contact_flips, 0.0, "a body at rest neither gains nor loses a point of contact", start=SETTLED),
        Check(
            contacts.support_force_error,
            lambda dt, _: SHARE * dt / (DURATION - SETTLED) + 1e-6,
            "the mean force over the window misses the weight by the change of momentum, m times the speed of 0.01 g "
            "over one step; 1e-6 for a solver's tolerance",
            start=SETTLED,
        ),
    ),
    observe=(contacts.penetration,),
    scale=G / 240,
)
