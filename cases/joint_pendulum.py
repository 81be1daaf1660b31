"""A pendulum on a hinge, released from rest: does it keep its period, its energy and its hinge?"""

from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Interval

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import conservation, errors, joints, periods
from plumbline.harness.scene import WORLD, Body, Box, Effect, Revolute, Scene, Sphere
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.pendulum import hanging, swinging

Kind = Literal["rod", "point"]

DURATION = 10.0
RADIUS = 0.05
"""Radius of the bob of a 'point' and half the thickness of a 'rod' [m]; both have the inertia that this gives them."""


class P(Parameters):
    amplitude: Annotated[float, Interval(gt=0, lt=180)] = 30.0
    """Degrees. The error of second order in a staggered integrator's period changes sign near 90 degrees, where an order fitted
    to it would be a fluke; at 30 it is nearly as large as it gets."""
    kind: Kind = "rod"
    length: Positive = 1.0
    mass: Positive = 1.0


def _body(p: P, **fields: Any) -> tuple[Body, float]:
    """The pendulum, and the distance [m] of its centre of mass from the hinge at the origin. Args: fields: of the body."""
    rod = Box(half_extents=(RADIUS, RADIUS, p.length / 2))
    shape, distance = (rod, p.length / 2) if p.kind == "rod" else (Sphere(radius=RADIUS), p.length)
    return Body.solid("pendulum", shape, mass=p.mass, touches=False, **fields), distance


def scene(p: P) -> Scene:
    """A pendulum of `length` [m] on a hinge about y at the origin, at rest at `amplitude` [degrees, 0..180)."""
    p_WB, q_WB = hanging(np.array(np.radians(p.amplitude)), _body(p)[1])
    pendulum, _ = _body(p, p_WB=p_WB.tolist(), q_WB=q_WB.tolist())
    hinge = Revolute(name="hinge", parent=WORLD, child="pendulum", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0))
    return Scene(bodies=(pendulum,), joints=(hinge,), narrow=Effect.GYROSCOPIC)


def _small_rate(p: P) -> tuple[float, float]:
    """Angular frequency [rad/s] of small swings, sqrt(m g d/(I + m d^2)), and d [m]."""
    body, d = _body(p)
    return float(np.sqrt(p.mass * G * d / (body.inertia[1][1] + p.mass * d * d))), d


def expected(time: Floats, p: P) -> Trajectory:
    """Jacobi's elliptic functions."""
    rate, distance = _small_rate(p)
    truth = Trajectory.of(time, 1)
    theta, turning = swinging(truth.time, rate, np.radians(p.amplitude))
    truth.p_WB[:, 0], truth.q_WB[:, 0] = hanging(theta, distance)
    truth.w_WB[:, 0, 1] = -turning
    truth.v_WB[:, 0] = np.cross(truth.w_WB[:, 0], truth.p_WB[:, 0])
    return truth


@lru_cache(maxsize=8)
def _swing(p: P) -> tuple[float, float, float, float]:
    """w0 [rad/s], d [m], the largest theta' = 2 k w0 [rad/s] and the height 1 - cos(theta0) [d]."""
    rate, distance = _small_rate(p)
    return rate, distance, float(2.0 * np.sin(np.radians(p.amplitude) / 2) * rate), float(1 - np.cos(np.radians(p.amplitude)))


def _gap(dt: float, p: P) -> float:
    """A step along the tangent leaves the circle by (v dt)^2/(2 d); a solver that takes back a fifth a step keeps five."""
    _, distance, fastest, _ = _swing(p)
    return 5 * (fastest * distance * dt) ** 2 / (2 * distance) + 1e-6


def _energy(dt: float, p: P) -> float:
    """Twice (w0/2) dt for half a step between position and velocity, and the gap's height, over the energy in play."""
    rate, distance, _, height = _swing(p)
    return rate * dt + _gap(dt, p) / (distance * height)


def _period_error(dt: float, p: P) -> float:
    """Twice the leapfrog's (w0 dt)^2/24 in small swings, a rod longer by the gap, and 1e-6 for interpolation."""
    rate, distance, _, _ = _swing(p)
    return (rate * dt) ** 2 / 12 + _gap(dt, p) / (2 * distance) + 1e-6


def _position(dt: float, p: P) -> float:
    """Twice the largest speed times half a step, the period's error up to the end, and the gap."""
    _, distance, fastest, _ = _swing(p)
    return distance * fastest * (dt + _period_error(dt, p) * DURATION) + _gap(dt, p)


CASE = Case.of(
    globals(),
    title="Pendulum",
    question="Does a pendulum keep its period and its energy, and does its hinge hold?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 11, problem 1; Jacobi's elliptic functions",
    truth="closed form",
    converges="smoothly",
    checks=(
        Check(
            errors.position_error_max,
            _position,
            "released half a step ahead, a first-order method errs by v dt/2, taken twice for maximal coordinates and "
            "higher orders; the period's error up to the end and the gap of the hinge are added",
        ),
        Check(
            periods.period_error,
            _period_error,
            "a staggered method's period errs by (w0 dt)^2/24, taken twice; a hinge that gives way makes the rod "
            "longer; 1e-6 for interpolation between samples",
        ),
        Check(
            conservation.energy_drift_max,
            _energy,
            "position and velocity half a step apart make (w0/2) dt without any loss, taken twice for maximal "
            "coordinates and higher orders; a hinge's gap adds its height. Damping of 0.04/s would lose a third in 10 s",
        ),
        Check(
            joints.joint_gap_max,
            _gap,
            "a step along the tangent leaves the circle by (v dt)^2/(2 d), of which a solver that corrects a fifth a "
            "step keeps five; 1e-6 m for single precision. Joint coordinates have none",
        ),
    ),
    observe=(
        conservation.energy_drift_staggered_max,
        conservation.energy_drift_final,
        periods.phase_error,
        errors.position_error_rms,
        errors.position_error_final,
        errors.velocity_error_max,
        errors.attitude_error_max,
        joints.joint_gap_rms,
    ),
)
