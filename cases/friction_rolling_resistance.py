"""Balls rolling on soft ground: do they slow down by the moment that the ground sets against rolling?

A moment c N against a rolling ball slows it by a = c g/(r (1 + k)), k = 2/5, until it stops after v0^2/(2 a).
"""

import numpy as np

from plumbline.harness.case import ByParameters, Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import G, forces_obey_coulomb
from plumbline.harness.metrics import errors, jitter
from plumbline.harness.scene import Body, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about

DURATION = 4.0
SPEED, FRICTION, RADIUS, MASS, SPACING = 1.0, 0.5, 0.1, 1.0, 1.0
COEFFICIENTS = (0.005, 0.01, 0.02)
"""Moment over normal force [m]."""
SOLID = 0.4
"""I/(m r^2) of a solid sphere."""


class P(Parameters):
    speed: Positive = SPEED
    coefficients: tuple[float, ...] = COEFFICIENTS


def deceleration(coefficient: float, radius: float = RADIUS) -> float:
    """c g/(r (1 + k)) [m/s2] of a solid sphere."""
    return coefficient * G / (radius * (1 + SOLID))


def lasting(p: P) -> float:
    """How long a run takes [s]: DURATION, stretched like the longest roll, v r (1 + k)/(c g)."""
    return DURATION * (p.speed / min(c for c in p.coefficients if c > 0)) / (SPEED / min(COEFFICIENTS))


def scene(p: P) -> Scene:
    """One ball for each coefficient [m], side by side along y, rolling along x at `speed` [m/s]."""
    materials = [f"ball_{i}" for i in range(len(p.coefficients))]
    balls = [
        Body.ball(
            material,
            RADIUS,
            mass=MASS,
            material=material,
            p_WB=(0.0, SPACING * i, RADIUS),
            v_WB=(p.speed, 0.0, 0.0),
            w_WB=(0.0, p.speed / RADIUS, 0.0),
        )
        for i, material in enumerate(materials)
    ]
    return Scene(
        bodies=(Body.ground(), *balls),
        surfaces=tuple(
            Surface.rough(FRICTION, (m, "ground"), rolling_friction=c) for m, c in zip(materials, p.coefficients, strict=True)
        ),
        apart=tuple((a, b) for i, a in enumerate(materials) for b in materials[i + 1 :]),
        # A ball's inertia is the same about every axis.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """Uniform deceleration without slip, then rest."""
    truth = Trajectory.at_rest(scene(p), time)
    for i, c in enumerate(p.coefficients, start=1):
        a = deceleration(c)
        t = truth.time if a == 0 else np.minimum(truth.time, p.speed / a)
        way = p.speed * t - a * t**2 / 2
        truth.p_WB[:, i, 0] = way
        truth.v_WB[:, i, 0] = p.speed - a * t
        truth.w_WB[:, i, 1] = truth.v_WB[:, i, 0] / RADIUS
        truth.q_WB[:, i] = about(1, way / RADIUS)
    return truth


def _speed(dt: float, p: P) -> float:
    """A first step without a contact, and a last one that would have stopped the ball before its end."""
    return 2 * deceleration(max(p.coefficients)) * dt


CASE = Case.of(
    globals(),
    title="Rolling resistance",
    question="Does a moment against rolling stop a ball where it should, and only where it was asked for?",
    source="Johnson, Contact Mechanics (1985), section 8.3: moment of rolling resistance over normal force",
    truth="closed form",
    duration=ByParameters(lasting),
    headline=errors.position_error_max.name,
    converges="once",
    checks=(
        Check(
            errors.velocity_error_max,
            _speed,
            "a first step without a contact and a last one that stops the ball too late or too early: c g dt/(r (1 + "
            "k)) each, for the largest coefficient",
        ),
        Check(
            errors.position_error_max,
            lambda dt, p: _speed(dt, p) * lasting(p) + p.speed * dt,
            "the error of the speed all the way, and a staggered scheme's half step of way, taken twice",
        ),
        Check(
            jitter.rms_speed,
            _speed,
            "all balls have come to rest (the slowest at t = 2.9 s from 1 m/s) and resistance takes any speed below that "
            "in a step",
            start=ByParameters(lambda p: lasting(p) - 0.25),
        ),
        *forces_obey_coulomb(),
    ),
    observe=(errors.position_error_final,),
)
