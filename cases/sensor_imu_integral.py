"""A gyroscope on a nutating top: does the integral of what it reads give the attitude that the body has?"""

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics.readings import gyroscope_attitude_error
from plumbline.harness.scene import Body, Box, Imu, Scene, axis_angle, principal_inertia

DURATION, RATE = 2.0, 120.0
EQUATOR, POLE = 1.0, 2.0
"""Moments of inertia [kg m2]."""
MOUNTING = axis_angle((1.0, 2.0, -0.5), 0.7)


class P(Parameters):
    across: float = 1.0
    along: float = 3.0
    """Rates across and along the axis [rad/s]."""


def scene(p: P) -> Scene:
    """A free symmetric top with a sensor turned against it; its rate goes round its axis at (C - A)/A times `along`."""
    inertia, shape = principal_inertia(EQUATOR, EQUATOR, POLE), Box(half_extents=(0.5, 0.5, 0.2))
    top = Body.solid("top", shape, inertia=inertia, touches=False, w_WB=(p.across, 0.0, p.along))
    imu = Imu(name="imu", body="top", rate=RATE, p_BS=(0.1, 0.2, 0.0), q_BS=MOUNTING)
    return Scene(bodies=(top,), sensors=(imu,), gravity=(0.0, 0.0, 0.0))


def _angle(dt: float, p: P) -> float:
    """[rad]: see the check's derivation, a twentieth granted for the change of the rate itself.

    The rate goes round the axis in B at W = (C - A)/A w3: |w'| = W w1 and |w''| = W^2 w1.
    """
    turning, size = (POLE - EQUATOR) / EQUATOR * p.along, (p.across**2 + p.along**2) ** 0.5
    first = turning * p.across * dt / 2
    second = size**3 * dt**2 / 12
    integral = turning**2 * p.across / RATE**2 / 12
    return float(1.05 * (first + second + integral) * DURATION + 64 * SINGLE)


CASE = Case.of(
    globals(),
    title="Attitude from a gyroscope",
    question="Is the attitude of a body the integral of what a gyroscope on it reads?",
    source="Titterton, Weston, Strapdown Inertial Navigation Technology, 2nd ed., section 11.2; Goldstein, section 5.6",
    truth="conservation",
    dt=1 / 240,
    sample_interval=1 / RATE,
    ladder=(1 / 120, 1 / 240, 1 / 360, 1 / 480, 1 / 960, 1 / 1920),
    checks=(
        Check(
            gyroscope_attitude_error,
            _angle,
            "an engine that turns by the rate of a step's start or end is off by |w'| dt/2 a second, one that turns by "
            "2 atan(w dt/2) by |w|^3 dt^2/12, and the integral of readings at intervals T by |w''| T^2/12; rounding",
        ),
    ),
)
