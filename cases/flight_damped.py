"""A ball that falls and spins through a linear drag: does damping take what its coefficient says, and no other share?"""

import math

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.metrics import errors
from plumbline.harness.scene import EARTH_GRAVITY, Body, Scene
from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats, Trajectory

DURATION = 3.0
VELOCITY = (4.0, 0.0, 6.0)
SPIN = (0.0, 0.0, 5.0)
SINGLE = 1e-6
"""Rounding of single precision, times the few units that everything here measures."""


class P(Parameters):
    velocity: Vector3 = VELOCITY
    spin: Vector3 = SPIN
    linear_damping: NotNegative = 2.0
    angular_damping: NotNegative = 1.0


def scene(p: P) -> Scene:
    """A ball of 1 kg thrown from the origin; damping [1/s] is the rate at which velocity and angular velocity decay."""
    ball = Body.ball(
        "ball",
        0.1,
        touches=False,
        v_WB=p.velocity,
        w_WB=p.spin,
        linear_damping=p.linear_damping,
        angular_damping=p.angular_damping,
    )
    return Scene(bodies=(ball,))


def expected(time: Floats, p: P) -> Trajectory:
    """v = v_t + (v0 - v_t) exp(-c t) with the terminal velocity v_t = g/c; the same for the spin, which ends at rest."""
    truth = Trajectory.of(time, 1)
    t, g, v0, w0 = truth.time[:, None], np.array(EARTH_GRAVITY), np.array(p.velocity), np.array(p.spin)
    # (1 - exp(-c t))/c and its integral from 0, both with their limits for no damping.
    covered = _covered(t, p.linear_damping)
    fallen = (t - covered) / p.linear_damping if p.linear_damping > 0 else t**2 / 2
    truth.p_WB[:, 0] = v0 * covered + g * fallen
    truth.v_WB[:, 0] = v0 * np.exp(-p.linear_damping * t) + g * covered
    truth.w_WB[:, 0] = w0 * np.exp(-p.angular_damping * t)
    angle = np.linalg.norm(w0) * _covered(truth.time, p.angular_damping)
    axis = w0 / max(float(np.linalg.norm(w0)), 1e-300)
    truth.q_WB[:, 0, 0], truth.q_WB[:, 0, 1:] = np.cos(angle / 2), np.sin(angle / 2)[:, None] * axis
    return truth


def _covered(t: Floats, rate: float) -> Floats:
    """The integral of exp(-rate t) from 0 [s]."""
    covered: Floats = -np.expm1(-rate * t) / rate if rate > 0 else t
    return covered


def _change(velocity: Vector3, linear_damping: float) -> float:
    """How far [m/s] the velocity is from its end at the start: from the terminal one, without damping from that of the fall."""
    g = np.array(EARTH_GRAVITY)
    return float(np.linalg.norm(np.array(velocity) - g / linear_damping if linear_damping > 0 else g * DURATION))


def _velocity(dt: float, p: P) -> float:
    """g dt of the terminal velocity and a rate off by c^2 dt/2 at its worst instant, c t = 1; twice for higher orders."""
    return 2 * (-EARTH_GRAVITY[2] * dt + _change(p.velocity, p.linear_damping) * p.linear_damping * dt / (2 * math.e)) + SINGLE


CASE = Case.of(
    globals(),
    title="Damped fall",
    question="Does linear drag bring a body to its terminal speed, and a spin to rest, at the rate that was asked for?",
    source="Meriam and Kraige, Engineering Mechanics: Dynamics, 7th ed., section 2/2, problem of linear drag",
    truth="closed form",
    headline=errors.position_error_max.name,
    converges="smoothly",
    checks=(
        Check(
            errors.velocity_error_max,
            _velocity,
            "damping as a factor 1 - c dt after gravity ends g dt below the terminal speed and decays at c + c^2 dt/2; "
            "the two errors are added at their worst and taken twice for higher orders. A coefficient that is off by 5 % "
            "misses the terminal speed by 0.25 m/s",
        ),
        Check(
            errors.position_error_max,
            lambda dt, p: DURATION * _velocity(dt, p) + _change(p.velocity, p.linear_damping) * dt / 2,
            "the largest error of the velocity for the whole flight, and half a step of its change for a scheme that "
            "keeps position and velocity half a step apart",
        ),
        Check(
            errors.angular_velocity_error_max,
            lambda dt, p: 2 * float(np.linalg.norm(p.spin)) * p.angular_damping * dt / (2 * math.e) + SINGLE,
            "a factor 1 - c dt decays at c + c^2 dt/2, worst at c t = 1: w0 c dt/(2 e), taken twice for higher orders",
        ),
    ),
    observe=(errors.position_error_final,),
)
