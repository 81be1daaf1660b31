"""A pendulum on a ball joint that goes round in a level circle: does it keep its radius and its rate?"""

from typing import Annotated

import numpy as np
from annotated_types import Interval

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import conservation, errors, joints
from plumbline.harness.scene import WORLD, Ball, Body, Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about

DURATION = 10.0
LENGTH, MASS, RADIUS = 1.0, 1.0, 0.05


class P(Parameters):
    tilt: Annotated[float, Interval(gt=0, lt=90)] = 30.0
    length: Positive = LENGTH


def rate(tilt: float, length: float) -> float:
    """w = sqrt(g/(l cos(tilt))) [rad/s], tilt in degrees. A ball's own inertia, alike about all axes, does not enter."""
    return float(np.sqrt(G / (length * np.cos(np.radians(tilt)))))


def expected(time: Floats, p: P) -> Trajectory:
    """The whole pendulum turns about the vertical like one rigid body."""
    truth = Trajectory.of(time, 1)
    theta, w = np.radians(p.tilt), rate(p.tilt, p.length)
    azimuth = w * truth.time
    out = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=1)
    truth.p_WB[:, 0] = p.length * (np.sin(theta) * out + np.array([0.0, 0.0, -np.cos(theta)]))
    truth.q_WB[:, 0] = about(2, azimuth)
    truth.w_WB[:, 0, 2] = w
    truth.v_WB[:, 0] = w * p.length * np.sin(theta) * np.stack([-out[:, 1], out[:, 0], out[:, 2]], axis=1)
    return truth


def scene(p: P) -> Scene:
    """A ball on a massless rod of `length` [m] on a ball joint at the origin, `tilt` [degrees] from hanging, on its circle."""
    start = expected(np.zeros(1), p)
    bob = Body.ball(
        "bob",
        RADIUS,
        mass=MASS,
        touches=False,
        p_WB=start.p_WB[0, 0].tolist(),
        v_WB=start.v_WB[0, 0].tolist(),
        w_WB=start.w_WB[0, 0].tolist(),
    )
    return Scene(bodies=(bob,), joints=(Ball(name="pivot", parent=WORLD, child="bob", anchor_W=(0.0, 0.0, 0.0)),))


def _gap(dt: float, p: P) -> float:
    """A step along the tangent leaves the sphere by (v dt)^2/(2 l); a solver that takes back a fifth a step keeps five."""
    speed = rate(p.tilt, p.length) * p.length * float(np.sin(np.radians(p.tilt)))
    return 5 * (speed * dt) ** 2 / (2 * p.length) + 1e-6


def _radius(dt: float, p: P) -> float:
    """Twice w dt for half a step's offset, as it swings about the circle, and the gap."""
    return rate(p.tilt, p.length) * dt * 2 + _gap(dt, p) / (p.length * float(np.sin(np.radians(p.tilt))))


def _position(dt: float, p: P) -> float:
    """The radius' error, and what it does to the rate all the way: a share that of tan^2 of the tilt, at most one."""
    out = p.length * float(np.sin(np.radians(p.tilt)))
    return out * _radius(dt, p) * (1 + rate(p.tilt, p.length) * DURATION)


CASE = Case.of(
    globals(),
    title="Conical pendulum",
    question="Does a pendulum on a ball joint keep going round on its circle?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 14, problem 1: w^2 = g/(l cos(theta))",
    truth="closed form",
    converges="smoothly",
    checks=(
        Check(
            errors.radius_error_max,
            _radius,
            "position and velocity half a step apart start the ball w dt/2 of the radius off its circle, about which "
            "it then swings by as much; taken four times for maximal coordinates and higher orders. The gap is added",
        ),
        Check(
            errors.position_error_max,
            _position,
            "the error of the radius, and the phase that it makes up to the end: the rate changes by "
            "tan(theta)^2/2 = 1/6 of the radius' share, taken as one",
        ),
        Check(
            joints.joint_gap_max,
            _gap,
            "a step along the tangent leaves the sphere by (v dt)^2/(2 l), of which a solver that corrects a fifth a "
            "step keeps five; 1e-6 m for single precision. Joint coordinates have none",
        ),
    ),
    observe=(
        errors.radius_error_final,
        errors.position_error_final,
        errors.attitude_error_max,
        conservation.energy_drift_max,
        conservation.energy_drift_staggered_max,
    ),
)
