"""A body thrown without drag: does gravity act as it should, and nothing else?"""

import numpy as np

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import SINGLE, G
from plumbline.harness.metrics import conservation, errors
from plumbline.harness.scene import EARTH_GRAVITY, Body, Scene
from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats, Trajectory

DURATION = 2.0


class P(Parameters):
    velocity: Vector3 = (3.0, 1.0, 8.0)
    mass: Positive = 1.0
    radius: Positive = 0.1


def scene(p: P) -> Scene:
    """A ball that nothing can touch, thrown from the origin with `velocity` [m/s]."""
    ball = Body.ball("ball", p.radius, mass=p.mass, touches=False, v_WB=p.velocity)
    return Scene(bodies=(ball,))


def expected(time: Floats, p: P) -> Trajectory:
    """x = v0 t + g t^2/2; mass and size do not enter."""
    truth = Trajectory.of(time, 1)
    t = truth.time[:, None]
    truth.p_WB[:, 0] = np.array(p.velocity) * t + 0.5 * np.array(EARTH_GRAVITY) * t**2
    truth.v_WB[:, 0] = np.array(p.velocity) + np.array(EARTH_GRAVITY) * t
    return truth


def _speeds(velocity: Vector3) -> tuple[float, float]:
    """The greater of the speeds at the start and at the end, which is the greatest, and that at the end [m/s]."""
    x, y, z = velocity
    end = float(np.hypot(np.hypot(x, y), G * DURATION - z))
    return max(float(np.linalg.norm(velocity)), end), end


def _rounding(dt: float, p: P) -> float:
    """Velocity [m/s] lost to rounding in single precision: half a unit in the last place, in the same direction every step."""
    return SINGLE * _speeds(p.velocity)[0] * DURATION / dt


def _first_order(dt: float, p: P) -> float:
    """Position [m]: semi-implicit Euler's exact error g dt t/2, 1 % more, and the rounding of velocity over the flight."""
    return 1.01 * G * dt * DURATION / 2 + _rounding(dt, p) * DURATION


CASE = Case.of(
    globals(),
    title="Projectile",
    question="Does a thrown body follow its parabola, to the order of the integrator and without hidden damping?",
    source="Galilei, Discorsi (1638); x = v0 t + g t^2/2",
    truth="closed form",
    converges="smoothly",
    checks=(
        Check(
            errors.position_error_max,
            _first_order,
            "semi-implicit Euler errs by exactly g dt t/2, no consistent method by more; 1 % and single-precision "
            "rounding are added. Damping of 0.04/s would add 0.04 v t^2/2 = 0.25 m sideways alone",
        ),
        Check(
            errors.velocity_error_max,
            _rounding,
            "under a constant force every one-step method gives velocity exactly; what is left is one rounding a step, "
            "counted in single precision and all in one direction",
        ),
        Check(errors.attitude_error_max, 1e-6, "nothing turns the body; 1e-6 rad is single-precision rounding"),
        Check(errors.angular_velocity_error_max, 1e-6, "nothing turns the body; single-precision rounding"),
        Check(
            conservation.energy_drift_max,
            lambda dt, p: 2.0 * G * _first_order(dt, p) / _speeds(p.velocity)[0] ** 2,
            "kinetic energy is exact, so energy errs by m g times the position error, over the largest kinetic energy",
        ),
    ),
    observe=(errors.position_error_rms, errors.position_error_final, conservation.energy_drift_staggered_max),
)
