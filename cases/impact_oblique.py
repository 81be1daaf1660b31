"""Spinning balls thrown at rough level ground: do they grip or slip, and with which spin do they leave?

At the moment of impact the normal impulse is (1 + e) m v_n, and friction is bounded by mu times that: it stops the slip of the
point of contact where it can, else it gives all it has against the slip. Gravity has no time to act in an impact, so that there
is none here.
"""

from collections.abc import Callable, Sequence

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters, Positive, Share
from plumbline.harness.case.bounds import SPRING_STEPS, forces_keep_momentum
from plumbline.harness.metrics.errors import angular_velocity_error_final, position_error_final, velocity_error_final
from plumbline.harness.scene import Body, Scene, Surface, sphere_inertia
from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.friction import coulomb_impact

MASS, RADIUS, SPACING, APPROACH = 1.0, 0.2, 2.0, 2.0
HEIGHT, HIGHER = 0.25, 0.007
"""Of the first ball over the ground, and how much higher each next one starts, so that every ball comes at another phase of the
step [m]; the first one meets the ground at the very end of a step."""
VELOCITIES = ((1.0, 0.0), (2.0, 2.0), (6.0, 0.0), (-4.0, 4.0), (1.0, 0.0), (2.0, 0.0), (0.0, 0.0))
SPINS = (
    (0.0, 0.0, 0.0),
    (0.0, 0.0, 0.0),
    (0.0, 0.0, 0.0),
    (0.0, 0.0, 0.0),
    (0.0, -10.0, 0.0),
    (0.0, -30.0, 0.0),
    (10.0, 5.0, 15.0),
)
"""In turn: grip; grip askew, beyond what mu m v_n without the rebound could stop; slip; slip askew; backspin that grips;
backspin that slips; spin alone, askew and about the vertical, which one point of contact cannot change."""

Motion = tuple[tuple[float, float], Vector3]


class P(Parameters):
    velocities: tuple[tuple[float, ...], ...] = VELOCITIES
    spins: tuple[tuple[float, ...], ...] = SPINS
    approach: Positive = APPROACH
    friction: NotNegative = 0.3
    restitution: Share = 0.6


def _motions(
    velocities: Sequence[Sequence[float]], spins: Sequence[Sequence[float]], approach: float
) -> list[tuple[Floats, Floats]]:
    """Velocity [m/s] and angular velocity [rad/s] before the impact, one pair for each ball."""
    return [
        (np.array([*velocity, -approach]), np.array(spin, dtype=np.float64))
        for velocity, spin in zip(velocities, spins, strict=True)
    ]


def scene(p: P) -> Scene:
    """Balls side by side along y with horizontal `velocities` [m/s] and `spins` [rad/s], coming down at `approach` [m/s]."""
    balls = [
        Body.ball(
            f"ball_{i}",
            RADIUS,
            mass=MASS,
            material="ball",
            p_WB=(0.0, SPACING * i, RADIUS + HEIGHT + HIGHER * i),
            v_WB=v_W.tolist(),
            w_WB=w_W.tolist(),
        )
        for i, (v_W, w_W) in enumerate(_motions(p.velocities, p.spins, p.approach))
    ]
    law = Surface.rough(p.friction, ("ball", "ground"), restitution=p.restitution)
    return Scene(bodies=(Body.ground(), *balls), surfaces=(law,), gravity=(0.0, 0.0, 0.0), apart=(("ball", "ball"),))


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: straight flight, one impulse, straight flight.

    The attitude is left out: no check reads it.
    """
    stage = scene(p)
    truth = Trajectory.of(time, len(stage.bodies))
    for place, (v_W, w_W) in enumerate(_motions(p.velocities, p.spins, p.approach), start=1):
        meeting = (HEIGHT + HIGHER * (place - 1)) / p.approach
        since = np.maximum(truth.time - meeting, 0.0)[:, None]
        before = np.minimum(truth.time, meeting)[:, None]
        moment = sphere_inertia(MASS, RADIUS)[0][0]
        v_after, w_after = coulomb_impact(v_W, w_W, MASS, moment, RADIUS, p.restitution, p.friction)
        truth.p_WB[:, place] = np.array(stage.bodies[place].p_WB) + before * v_W + since * v_after
        truth.v_WB[:, place] = np.where(truth.time[:, None] < meeting, v_W, v_after)
        truth.w_WB[:, place] = np.where(truth.time[:, None] < meeting, w_W, w_after)
    return truth


def _caught_off_the_plane(dt: float, p: P) -> tuple[float, float]:
    """By how much v [m/s] and w [rad/s] after the impact change when the arm is off by one step's way, the worst ball.

    Or, where that is more, shorter by the depth v T/pi of a spring's impact.
    """
    moment, way = sphere_inertia(MASS, RADIUS)[0][0], p.approach * dt
    depth = max(1.0, SPRING_STEPS / np.pi) * way
    worst = np.zeros(2)
    for v_W, w_W in _motions(p.velocities, p.spins, p.approach):
        right = coulomb_impact(v_W, w_W, MASS, moment, RADIUS, p.restitution, p.friction)
        for arm in (RADIUS - depth, RADIUS + way):
            motion = coulomb_impact(v_W, w_W, MASS, moment, arm, p.restitution, p.friction)
            worst = np.maximum(worst, [np.linalg.norm(a - b) for a, b in zip(motion, right, strict=True)])
    return float(worst[0]), float(worst[1])


def _bound(column: int) -> Callable[[float, P], float]:
    """The bound over dt of v (0) or w (1), with single precision of the fastest ball beside it."""
    return lambda dt, p: _caught_off_the_plane(dt, p)[column] + 1e-5


def _way(dt: float, p: P) -> float:
    """The bound [m] over dt of the final place."""
    fastest = max(float(np.linalg.norm(velocity)) for velocity in p.velocities)
    change = (1 + p.restitution) * p.approach * (1 + p.friction)
    astray = max(change + fastest, SPRING_STEPS / 2 * change)
    speed = _caught_off_the_plane(dt, p)[0] + 1e-5
    return astray * dt + speed * max(0.0, DURATION - HEIGHT / p.approach) + 1e-5


DURATION = 0.5
ARM = (
    "without other forces Newton's and Coulomb's impulse leaves no error of the step, but for the lever: a ball may be caught "
    "one step's way v_n dt above the plane or below it, which makes its arm longer or shorter, or sink by v_n T/pi in the ten "
    "steps T of an impact that is a spring's; 1e-5 for single precision"
)

CASE = Case.of(
    globals(),
    title="Spinning balls on rough ground",
    question="Does a ball that meets rough ground askew grip or slip as one Coulomb impulse says, with the right spin?",
    source="Stronge, Impact Mechanics, 2nd ed., section 3.2; Maw, Barber, Fawcett, Wear 38 (1976) 101 (rigid limit)",
    truth="closed form",
    sample_interval=0.0,
    checks=(
        Check(velocity_error_final, _bound(0), ARM),
        Check(angular_velocity_error_final, _bound(1), ARM),
        Check(
            position_error_final,
            _way,
            "an impact may come one step early or late, in which the ball goes the change of its velocity times dt "
            "astray, or take a spring's ten steps, half of which it goes by that change astray; and then it errs by the bound "
            "on its velocity over the rest of the run",
        ),
        forces_keep_momentum(),
    ),
    scale=APPROACH,
)
