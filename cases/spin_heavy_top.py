"""A disc that spins on a ball joint under gravity: does it precess steadily, and without nutation?"""

from typing import Annotated

import numpy as np
from annotated_types import Interval

from plumbline.harness.case import Axis, Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import conservation, errors, joints
from plumbline.harness.metrics.periods import nutation_amplitude, precession_rate_error
from plumbline.harness.scene import WORLD, Ball, Body, Cylinder, Scene, principal_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about, product

DURATION = 2.0
MASS, RADIUS, LENGTH = 1.0, 0.1, 0.1
ACROSS, ALONG = MASS * RADIUS**2 / 4 + MASS * LENGTH**2, MASS * RADIUS**2 / 2
"""Moments of the disc about the joint, across its axis and along it [kg m2]."""


class P(Parameters):
    tilt: Annotated[float, Interval(gt=0, lt=90)] = 30.0
    spin: Positive = 200.0


def precession(p: P) -> float:
    """The slower steady precession [rad/s]: I1 cos(theta) W^2 - I3 w3 W + m g l = 0; tilt in degrees, spin w3 in rad/s.

    Raises:
        ValueError: the spin is too slow for a steady precession.
    """
    a, b, c = ACROSS * np.cos(np.radians(p.tilt)), ALONG * p.spin, MASS * G * LENGTH
    if b * b < 4 * a * c:
        raise ValueError(
            f"spin {p.spin} rad/s, expected at least {2 * np.sqrt(max(a * c, 0.0)) / ALONG:.6g} for a tilt of {p.tilt} deg"
        )
    # The form that loses no digits to the difference of two nearly equal numbers.
    return float(2 * c / (b + np.sqrt(b * b - 4 * a * c)))


def expected(time: Floats, p: P) -> Trajectory:
    """The axis goes round the vertical at W, at a constant tilt, and the disc round its axis at w3 - W cos(tilt)."""
    truth = Trajectory.of(time, 1)
    theta, rate = np.radians(p.tilt), precession(p)
    azimuth = rate * truth.time
    turned = product(about(2, azimuth), about(1, np.full(len(azimuth), theta)))
    truth.q_WB[:, 0] = product(turned, about(2, (p.spin - rate * np.cos(theta)) * truth.time))
    axis = np.stack([np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth), np.full(len(azimuth), np.cos(theta))], 1)
    truth.p_WB[:, 0] = LENGTH * axis
    truth.w_WB[:, 0] = (p.spin - rate * np.cos(theta)) * axis + np.array([0.0, 0.0, rate])
    truth.v_WB[:, 0] = np.cross(truth.w_WB[:, 0], truth.p_WB[:, 0])
    return truth


def scene(p: P) -> Scene:
    """A thin disc on a massless stem, on a ball joint at the origin, started in steady precession."""
    start = expected(np.zeros(1), p)
    disc = Body.solid(
        "disc",
        Cylinder(radius=RADIUS, half_length=0.005),
        mass=MASS,
        inertia=principal_inertia(ACROSS - MASS * LENGTH**2, ACROSS - MASS * LENGTH**2, ALONG),
        touches=False,
        p_WB=start.p_WB[0, 0].tolist(),
        q_WB=start.q_WB[0, 0].tolist(),
        v_WB=start.v_WB[0, 0].tolist(),
        w_WB=start.w_WB[0, 0].tolist(),
    )
    tip = Ball(name="tip", parent=WORLD, child="disc", anchor_W=(0.0, 0.0, 0.0))
    return Scene(bodies=(disc,), joints=(tip,))


def nutation(spin: float) -> float:
    """Rate of nutation of the fast top, I3 w3/I1 [rad/s]."""
    return ALONG * spin / ACROSS


def _nutation(dt: float, p: P) -> float:
    """Twice the amplitude [rad] that a push of half a step of gravity's torque off the steady motion sets going."""
    push = 2 * MASS * G * LENGTH * np.sin(np.radians(p.tilt)) / ACROSS * dt / 2
    return float(push / nutation(p.spin) + _gap(dt, p) / LENGTH)


def _gap(dt: float, p: P) -> float:
    """A step along the tangent leaves the circle by (v dt)^2/(2 r); a solver that takes back a fifth a step keeps five.

    The joint's speed over the ground is that of the disc's point at the tip, which the spin does not move.
    """
    speed = LENGTH * np.sin(np.radians(p.tilt)) * precession(p)
    return float(5 * (speed * dt) ** 2 / (2 * LENGTH) + 5 * G * dt**2 + 1e-6)


CASE = Case.of(
    globals(),
    title="Heavy top",
    question="Does a fast top on a ball joint precess at the rate that gravity's torque asks for, without falling?",
    source="Goldstein, Classical Mechanics, 3rd ed., section 5.7: I1 cos(theta) W^2 - I3 w3 W + m g l = 0",
    truth="closed form",
    # From its tilt of 30 degrees a top that has fallen lies 2 sin(30 deg) = 1 stem away; what it errs by before that is shown.
    hard=Axis(parameter="spin", unit="rad/s", easy=100.0, extreme=5000.0, lost=1.0),
    sample_interval=1 / 240,
    # The disc turns 0.83 rad in a step of 1/240; in a longer one no method could follow it.
    ladder=(1 / 240, 1 / 480, 1 / 960, 1 / 1920, 1 / 3840, 1 / 7680),
    headline=errors.position_error_max.name,
    converges="smoothly",
    scale=LENGTH,
    checks=(
        Check(
            precession_rate_error,
            lambda dt, p: nutation(p.spin) * dt,
            "a first-order method places the torque and the motion it makes one step apart, the share W_nut dt of the "
            "time in which the axis answers",
        ),
        Check(
            nutation_amplitude,
            _nutation,
            "gravity's torque applied half a step early or late is a push of m g l sin(theta) dt/2 off the steady "
            "motion, which nutates with that over I1 W_nut, taken twice; the gap of the joint tilts the axis as well",
        ),
        Check(
            joints.joint_gap_max,
            _gap,
            "a step along the tangent leaves the circle by (v dt)^2/(2 r) and a free fall of one step by g dt^2, of "
            "which a solver that corrects a fifth a step keeps five; 1e-6 m for single precision. Joint coordinates have none",
        ),
    ),
    observe=(
        errors.position_error_final,
        errors.position_error_max,
        errors.attitude_error_max,
        conservation.energy_drift_max,
        conservation.energy_drift_staggered_max,
    ),
)
