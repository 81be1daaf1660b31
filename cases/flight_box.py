"""A box thrown with a spin about its own axis: the least that a body can cost, and a motion in closed form."""

import numpy as np

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.bounds import SINGLE, G
from plumbline.harness.metrics import errors
from plumbline.harness.scene import EARTH_GRAVITY, Body, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about

DURATION, MASS, HALF = 1.0, 1.0, (0.1, 0.2, 0.3)


class P(Parameters):
    speed: float = 5.0
    spin: float = 2.0


def scene(p: P) -> Scene:
    """A box that could touch, thrown upwards at `speed` [m/s], turning about its longest axis at `spin` [rad/s]."""
    box = Body.box("box", HALF, mass=MASS, v_WB=(1.0, 0.0, p.speed), w_WB=(0.0, 0.0, p.spin))
    return Scene(bodies=(box,), surfaces=(Surface(),), narrow=Effect.GYROSCOPIC)


def expected(time: Floats, p: P) -> Trajectory:
    """x = v0 t + g t^2/2, and a turn by spin t about z, a principal axis."""
    truth = Trajectory.of(time, 1)
    t = truth.time[:, None]
    start = np.array((1.0, 0.0, p.speed))
    truth.p_WB[:, 0] = start * t + 0.5 * np.array(EARTH_GRAVITY) * t**2
    truth.v_WB[:, 0] = start + np.array(EARTH_GRAVITY) * t
    truth.q_WB[:, 0], truth.w_WB[:, 0, 2] = about(2, p.spin * truth.time), p.spin
    return truth


def _rounding(dt: float, p: P) -> float:
    """Speed [m/s] lost to rounding in single precision: half a unit in the last place, in the same direction every step."""
    return SINGLE * (abs(p.speed) + G * DURATION) * DURATION / dt


CASE = Case.of(
    globals(),
    title="A free box",
    question="Does a box that nothing touches fly its parabola and turn evenly about a principal axis?",
    source="x = v0 t + g t^2/2; Euler's equations about a principal axis: w constant",
    truth="closed form",
    converges="smoothly",
    checks=(
        Check(
            errors.position_error_max,
            lambda dt, p: 1.01 * G * dt * DURATION / 2 + _rounding(dt, p) * DURATION,
            "semi-implicit Euler errs by exactly g dt t/2, no consistent method by more; 1 % and single precision more",
        ),
        Check(
            errors.velocity_error_max,
            _rounding,
            "under a constant force every one-step method gives velocity exactly; what is left is a rounding a step",
        ),
        Check(
            errors.angular_velocity_error_max,
            _rounding,
            "about a principal axis no torque acts: the same roundings, of a rate below the speed",
        ),
        Check(
            errors.attitude_error_max,
            lambda dt, p: DURATION * abs(p.spin) ** 3 * dt**2 / 12 + 2 * _rounding(dt, p) * DURATION,
            "q + dt/2 w q, brought back to length one, turns by 2 atan(w dt/2) = w dt - (w dt)^3/12 a step, the "
            "largest error among the usual updates; two roundings a step, of rate and attitude, more",
        ),
    ),
)
