"""A ball flies into a quadruped that floats, without gravity: whatever blow, friction, joints and drives do, p and L stay.

The drives hold the machine's pose from inside. A torque that an engine gives to one of a hinge's bodies it owes the other; a
joint that is pulled together by moving bodies, or a contact that is pushed apart, owes momentum to nobody.
"""

from functools import cache

import numpy as np

from plumbline.harness.case import Axis, Case, Check, NotNegative, Parameters, Positive
from plumbline.harness.case.bounds import GIVE
from plumbline.harness.metrics import conservation, jitter, joints, overlaps
from plumbline.harness.props.robots.quadruped import STIFFNESS, TRUNK_HALF, quadruped
from plumbline.harness.props.robots.robot import MATERIAL
from plumbline.harness.scene import Body, Scene, Surface, rotation_matrix
from plumbline.harness.trajectory import Floats

SPEED, SPIN = 3.0, 20.0
MASS, RADIUS, AWAY = 0.6, 0.12, 0.3
"""Of the ball, a basketball; its gap to the trunk's side at the start [m]."""
AHEAD, ABOVE = 0.10, 0.03
"""Where it aims: before and over the trunk's middle [m], so that the machine turns about every axis."""
DURATION = 1.5
HINGES, GAPE = 12, 1e-6
TURN = 0.4
"""Angular momentum [kg m2/s] about the common centre at the case's own speed and spin, .386 rounded up."""


class P(Parameters):
    speed: float = SPEED
    spin: float = SPIN
    friction: NotNegative = 0.5
    stiffness: Positive = STIFFNESS
    damping: NotNegative = 0.5


def scene(p: P) -> Scene:
    """The ball comes from the left at `speed` [m/s], spinning at `spin` [rad/s] about the vertical."""
    machine = quadruped(p.stiffness, p.damping)
    x, y, z = machine.bodies[0].p_WB
    ball = Body.ball(
        "ball",
        RADIUS,
        mass=MASS,
        material="ball",
        p_WB=(x + AHEAD, y + TRUNK_HALF[1] + AWAY + RADIUS, z + ABOVE),
        v_WB=(0.0, -p.speed, 0.0),
        w_WB=(0.0, 0.0, p.spin),
    )
    return Scene(
        bodies=(ball, *machine.bodies),
        joints=machine.hinges,
        surfaces=(Surface.rough(p.friction, ("ball", MATERIAL)),),
        apart=((MATERIAL, MATERIAL),),
        gravity=(0.0, 0.0, 0.0),
    )


def _turning(speed: float, spin: float) -> float:
    """Sum of the magnitudes of all bodies' angular momenta [kg m2/s] about the common centre, where the machine is at rest."""
    stage = scene(P(speed, spin))
    mass = np.array([body.mass for body in stage.bodies])
    p, v = (np.array([getattr(body, name) for body in stage.bodies]) for name in ("p_WB", "v_WB"))
    r, u = p - mass @ p / mass.sum(), v - mass @ v / mass.sum()
    parts = np.cross(r, mass[:, None] * u)
    parts[0] += np.array(stage.bodies[0].inertia) @ np.array(stage.bodies[0].w_WB)
    return float(np.linalg.norm(parts, axis=1).sum())


def _shifted(_dt: float, p: P) -> float:
    """The ball's momentum, handed on by each hinge over a micrometre, as a share of all the angular momentum there is."""
    turn = TURN if (p.speed, p.spin) == (SPEED, SPIN) else TURN * _turning(p.speed, p.spin) / _turning(SPEED, SPIN)
    return HINGES * MASS * p.speed * GAPE / turn


@cache
def _swung(speed: float, friction: float) -> tuple[float, float]:
    """The rate [rad/s] at which the machine would turn as one rigid body, and the sum of mass times way from the trunk [kg m].

    The blow is the ball's whole momentum, and friction's share of it across.
    """
    ball, *parts = scene(P(speed, friction=friction)).bodies
    mass, p = np.array([body.mass for body in parts]), np.array([body.p_WB for body in parts])
    centre = mass @ p / mass.sum()
    inertia = sum((_about(body, centre) for body in parts), np.zeros((3, 3)))
    arm = np.array(ball.p_WB) - (0.0, RADIUS, 0.0) - centre
    blow, across = np.array([0.0, -MASS * speed, 0.0]), np.array([friction * MASS * speed, 0.0, 0.0])
    rate = max(float(np.linalg.norm(np.linalg.solve(inertia, np.cross(arm, blow + way * across)))) for way in (-1.0, 1.0))
    return rate, float(mass @ np.linalg.norm(p - p[0], axis=1))


def _about(body: Body, centre: Floats) -> Floats:
    """The inertia (3, 3) kg m2 of a body about a point, in W."""
    r, turned = np.array(body.p_WB) - centre, np.array(rotation_matrix(body.q_WB))
    own: Floats = turned @ np.array(body.inertia) @ turned.T
    return own + body.mass * (r @ r * np.eye(3) - np.outer(r, r))


def _handed_on(dt: float, p: P) -> float:
    """One step of the pull w^2 sum m r by which parts are held to their circles, and single precision."""
    rate, lever = _swung(p.speed, p.friction)
    return dt * rate**2 * lever + 1e-6 * MASS * p.speed


CASE = Case.of(
    globals(),
    title="A ball hits a robot",
    question="Do momentum and angular momentum stay when a ball hits a floating robot whose drives hold its pose?",
    source="conservation of momentum and angular momentum (Goldstein, Classical Mechanics, 3rd ed., section 1.2)",
    truth="conservation",
    # A faster ball would be past the trunk within a step of 1/60 s.
    hard=Axis(parameter="speed", unit="m/s", easy=0.3, extreme=12.0, lost=0.1),
    sample_interval=1 / 240,
    checks=(
        Check(
            overlaps.inscribed_overlap,
            lambda dt, p: p.speed * dt + GIVE,
            "the ball does not pass through the trunk: one step's way may lie between the touch and its discovery, and "
            "a contact may give by a millimetre. Without this, a ball that never touches would pass",
        ),
        Check(
            conservation.momentum_drift_max,
            _handed_on,
            "what the ball loses the machine gets, and hinges and drives only hand it on. Joint coordinates do so to "
            "first order: parts that turn at w are held to their circles by m r w^2, in the direction of a step's start, and "
            "the pull that the blow begins is a step late, dt w^2 sum m r, where w is the turning that the blow gives to the "
            "machine as one body. Bodies with coordinates of their own need none of it; 1e-6 more for single precision",
        ),
        Check(
            conservation.angular_momentum_drift_max,
            lambda dt, p: _swung(p.speed, p.friction)[0] * dt + _shifted(dt, p),
            "in joint coordinates that pull acts in a direction which is a step old, w dt of what is handed on; the "
            "halves of an impulse act at a hinge's two anchors; where these are a micrometre apart, the ball's "
            "momentum, handed on once by every hinge, shifts so much of the angular momentum",
        ),
        Check(
            conservation.held_energy_gain_max,
            lambda _, p: 1e-6 * p.speed**2 / 2,
            "blows without restitution, friction and drives that hold a target take energy and give none; 1e-6 of the "
            "ball's, single precision",
        ),
    ),
    observe=(
        conservation.momentum_drift_final,
        conservation.angular_momentum_drift_final,
        joints.joint_gap_max,
        jitter.vibration_rms,
        jitter.vibration_frequency,
    ),
    headline=conservation.angular_momentum_drift_max.name,
)
