"""Thin rods that spin between two posts: their centres stand still, so that what looks at the speed of centres sees no danger.

Both ends meet a post at the same time, so that the blows make a pure couple, and without restitution the rod stops dead.
Whether a discrete test sees the posts depends on where in a step the ends arrive: every rod starts its own random angle
before them, uniform over spin/240, a whole number of steps' angles for each step that divides 1/240 s.
Source: Ericson, Real-Time Collision Detection, sections 2.4.3 and 5.5.1 (interval halving); Mirtich, Impulse-based Dynamic
Simulation of Rigid Body Systems (1996; bounds on the time of impact of bodies that turn).
"""

import numpy as np

from plumbline.harness.case import Axis, Case, Check, Count, Parameters, Positive
from plumbline.harness.metrics import errors, passage
from plumbline.harness.scene import Body, Capsule, Effect, Scene, Surface, axis_angle, multiply
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about, product

MASS, RADIUS, HALF_LENGTH, POST_RADIUS, LEVER = 0.5, 0.01, 0.5, 0.01, 0.4
SPACING, CLEARANCE, DURATION = 0.1, 0.15, 0.25


class P(Parameters):
    spin: Positive = 60.0
    phases: Count = 64
    continuous: bool = True
    seed: int = 0


def _meeting() -> float:
    """Angle [rad] between a post and the rod where they touch, both seen from the rod's centre."""
    return float(np.arcsin((RADIUS + POST_RADIUS) / LEVER))


def _angles(spin: float, phases: int, seed: int) -> Floats:
    """Angles (phases,) rad through which each rod turns until it meets the posts."""
    # In time, and not yet past the other post.
    low, high = CLEARANCE / (DURATION / 2 - 1 / 240), 240 * (np.pi - 2 * _meeting() - 2 * CLEARANCE)
    if not low <= spin <= high:
        raise ValueError(f"tunnel_rod: spin {spin} rad/s, expected {low:.3g}..{high:.3g}")
    return CLEARANCE + np.random.default_rng(seed).uniform(0.0, spin / 240, phases)


def scene(p: P) -> Scene:
    """`phases` rods, one above the other, turning about the vertical at `spin` [rad/s] between two common posts; no gravity.

    `continuous` calls for continuous collision detection; an engine that lacks it, or leaves it off by default, runs without
    and says so, and with False every engine gives what its plain contacts give.
    """
    rods = []
    for i, angle in enumerate(_angles(p.spin, p.phases, p.seed)):
        # The rod's axis, z of its shape, lies level at the azimuth -(angle + meeting) before the posts on the x axis.
        azimuth = -(float(angle) + _meeting())
        rods.append(
            Body.solid(
                f"rod_{i}",
                Capsule(radius=RADIUS, half_length=HALF_LENGTH),
                mass=MASS,
                material="rod",
                p_WB=(0.0, 0.0, SPACING * i),
                q_WB=multiply(axis_angle((0.0, 0.0, 1.0), azimuth), axis_angle((0.0, 1.0, 0.0), np.pi / 2)),
                w_WB=(0.0, 0.0, p.spin),
            )
        )
    middle = SPACING * (p.phases - 1) / 2
    posts = [
        Body.fixed(
            name, Capsule(radius=POST_RADIUS, half_length=middle + SPACING), material="post", p_WB=(side * LEVER, 0.0, middle)
        )
        for name, side in (("right", 1.0), ("left", -1.0))
    ]
    return Scene(
        bodies=(*posts, *rods),
        surfaces=(Surface(between=("rod", "post")),),
        gravity=(0.0, 0.0, 0.0),
        apart=(("rod", "rod"),),
        widen=Effect.CONTINUOUS_COLLISION if p.continuous else Effect.NONE,
        # A body that turns about a principal axis feels no gyroscopic torque.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: an even turn, then rest against both posts (no restitution)."""
    truth = Trajectory.at_rest(scene(p), time)
    for place, angle in enumerate(_angles(p.spin, p.phases, p.seed), start=2):
        turn = about(2, np.minimum(p.spin * truth.time, angle))
        truth.q_WB[:, place] = product(turn, truth.q_WB[:, place])
        truth.w_WB[:, place, 2] = np.where(p.spin * truth.time < angle, p.spin, 0.0)
    return truth


CASE = Case.of(
    globals(),
    title="Rods spinning between posts",
    question="With what probability does the end of a spinning rod get through a thin post, and how deep does it stick?",
    source="Ericson, Real-Time Collision Detection, sections 2.4.3 and 5.5.1; Mirtich, Impulse-based Dynamic Simulation (1996)",
    truth="closed form",
    hard=Axis(parameter="spin", unit="rad/s", easy=2, extreme=500, lost=0.0),
    # Angles are followed through more than a turn: half a turn between two samples is the most.
    sample_interval=1 / 240,
    ladder=(1 / 240, 1 / 480, 1 / 960, 1 / 1920, 1 / 3840, 1 / 7680),
    checks=(
        Check(
            passage.passage_probability,
            0.0,
            "a post stops every rod, at any phase: none turns its middle beyond a post's; 0 of 64 put the probability "
            "under 5.7 % (Wilson, 95 %)",
        ),
    ),
    observe=(
        passage.passage_probability_low,
        passage.passage_probability_high,
        passage.sink_depth,
        errors.angular_velocity_error_final,
        errors.position_error_final,
    ),
    insists={
        "continuous_collision": "a step of 1/240 s turns a rod by .25 rad, and within .1 rad it has passed a post: an engine "
        "that divides its steps by four or more sees the posts all the same"
    },
)
