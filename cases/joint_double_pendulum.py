"""Two rods on hinges: does a coupled swing follow its equations, and keep its energy?"""

from functools import lru_cache

import numpy as np

from plumbline.harness.case import Case, Check, Converged, Parameters
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import errors, joints
from plumbline.harness.metrics.conservation import energy_drift_final, energy_drift_max, energy_drift_staggered_max
from plumbline.harness.scene import WORLD, Body, Effect, Revolute, Scene
from plumbline.harness.trajectory import Floats
from plumbline.harness.truths.first_order import true_motion
from plumbline.harness.truths.pendulum import INERTIA, LENGTH, MASS, THICKNESS, D, acceleration, placed, poses

DURATION = 5.0


class P(Parameters):
    upper: float = 20.0
    lower: float = 30.0
    """Degrees from the downward vertical: a regular swing, mostly in the slow mode. Above about 90 the motion becomes chaotic;
    then the reference still carries its own error bar, and only the energy is worth comparing late in the run."""


def scene(p: P) -> Scene:
    """Two equal rods, the upper on a hinge at the origin, at rest at the given angles [degrees]; all axes along y."""
    theta = np.radians([p.upper, p.lower])
    p_WB, q_WB = poses(theta)
    half = (THICKNESS, THICKNESS, LENGTH / 2)
    rods = tuple(
        Body.box(name, half, mass=MASS, touches=False, p_WB=p_WB[i].tolist(), q_WB=q_WB[i].tolist())
        for i, name in enumerate(("upper", "lower"))
    )
    elbow = (LENGTH * float(np.sin(theta[0])), 0.0, -LENGTH * float(np.cos(theta[0])))
    axis = (0.0, 1.0, 0.0)
    return Scene(
        bodies=rods,
        joints=(
            Revolute(name="shoulder", parent=WORLD, child="upper", anchor_W=(0.0, 0.0, 0.0), axis_W=axis),
            Revolute(name="elbow", parent="upper", child="lower", anchor_W=elbow, axis_W=axis),
        ),
        narrow=Effect.GYROSCOPIC,
    )


def _solve(time: Floats, p: P, rtol: float) -> Floats:
    """Angles and rates, (t, 4)."""
    return true_motion(acceleration, np.radians([p.upper, p.lower]).tolist(), [0.0, 0.0], time, rtol)


def expected(time: Floats, p: P) -> Converged:
    """Lagrange's equations integrated at a relative tolerance of 1e-13; the error bar is the distance to 1e-11, a hundred times
    the tolerance and so far above the error of the finer one."""
    fine, coarse = (placed(time, _solve(time, p, rtol)) for rtol in (1e-13, 1e-11))
    return Converged.between(fine, coarse)


def _energy_of(y: Floats) -> Floats:
    """Kinetic and potential energy in joint angles, (t,) and (t,) J."""
    run = placed(np.zeros(len(y)), y)
    kinetic = 0.5 * MASS * np.sum(np.square(run.v_WB), axis=(1, 2)) + 0.5 * INERTIA * np.sum(np.square(y[:, 2:]), axis=1)
    potential: Floats = MASS * G * run.p_WB[:, :, 2].sum(axis=1)
    return np.stack([kinetic, potential], axis=1)


@lru_cache(maxsize=8)
def _first_order(p: P) -> tuple[float, float, float]:
    """Largest error per dt of position [m/s] and of relative energy [1/s], and the largest speed [m/s].

    Semi-implicit Euler in joint angles follows to second order theta' = w + (dt/2) a, w' = a - (dt/2) da/dt (backward error
    analysis: Hairer, Lubich, Wanner, chapter IX); the difference from the true motion is taken at a small dt and divided by it.
    """
    from scipy.integrate import solve_ivp  # late: a listing must not pay for it

    small = 1e-5
    times = np.linspace(0.0, DURATION, 501)

    def change(_t: float, y: Floats) -> Floats:
        theta, rate = y[:2], y[2:]
        a = acceleration(theta, rate)
        step = 1e-5
        ahead, behind = (acceleration(theta + s * rate, rate + s * a) for s in (step, -step))
        return np.concatenate([rate + small / 2 * a, a - small / 2 * (ahead - behind) / (2 * step)])

    start = [*np.radians([p.upper, p.lower]), 0.0, 0.0]
    other = solve_ivp(change, (0.0, DURATION), start, "DOP853", t_eval=times, rtol=1e-11, atol=1e-12).y.T
    true = _solve(times, p, 1e-12)
    truth = placed(times, true)
    moved = np.linalg.norm(placed(times, other).p_WB - truth.p_WB, axis=-1).max() / small
    energy = _energy_of(other).sum(axis=1)
    drift = np.abs(energy - energy[0]).max() / _energy_of(true)[:, 0].max() / small
    return float(moved), float(drift), float(np.linalg.norm(truth.v_WB, axis=-1).max())


WHY = (
    "twice the error, to first order in dt, of semi-implicit Euler in joint angles in this very motion; the factor 2 leaves "
    "room for terms of second order and for maximal coordinates, whose projected velocities err by as much"
)

CASE = Case.of(
    globals(),
    title="Double pendulum",
    question="Do two coupled rods follow Lagrange's equations while the motion is regular, and keep their energy?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 5, problem 1, for rods; SciPy DOP853 as reference",
    truth="converged reference",
    converges="smoothly",
    checks=(
        Check(errors.position_error_max, lambda dt, p: 2 * _first_order(p)[0] * dt, WHY),
        Check(energy_drift_max, lambda dt, p: 2 * _first_order(p)[1] * dt, WHY),
        Check(
            joints.joint_gap_max,
            lambda dt, p: 5 * (_first_order(p)[2] * dt) ** 2 / (2 * D) + 1e-6,
            "a step along the tangent leaves the circle by (v dt)^2/(2 d), of which a solver that corrects a fifth a "
            "step keeps five; 1e-6 m for single precision. Joint coordinates have none",
        ),
    ),
    observe=(
        energy_drift_staggered_max,
        energy_drift_final,
        errors.position_error_rms,
        errors.position_error_final,
        errors.velocity_error_max,
        errors.attitude_error_max,
    ),
)
