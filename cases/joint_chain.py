"""A hanging chain of n rods on hinges, let go straight from an angle: what does a link cost, and does the chain hold?"""

from functools import lru_cache

import numpy as np

from plumbline.harness.case import Axis, Case, Check, Converged, FloatCount, Parameters, Positive
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import errors, joints
from plumbline.harness.metrics.conservation import energy_drift_max, energy_drift_staggered_max
from plumbline.harness.scene import WORLD, Body, Effect, Revolute, Scene, box_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about
from plumbline.harness.truths.first_order import true_motion

DURATION = 2.0
LENGTH, MASS, THICKNESS = 0.2, 1.0, 0.02
HALF = (THICKNESS, THICKNESS, LENGTH / 2)
INERTIA = box_inertia(MASS, HALF)[1][1]
SAMPLE = 1 / 3840
"""The step [s] at which the first-order error of semi-implicit Euler is taken."""


class P(Parameters):
    n: FloatCount = 10
    angle: Positive = 20.0
    """Degrees from the downward vertical: a regular swing within the horizon of the reference."""


def placed(time: Floats, theta: Floats, rate: Floats) -> Trajectory:
    """The rods at angles (t, n) rad from the downward vertical, turning at (t, n) rad/s."""
    truth = Trajectory.of(time, theta.shape[1])
    zero = np.zeros_like(theta)
    along = LENGTH * np.stack([np.sin(theta), zero, -np.cos(theta)], axis=-1)
    moving = LENGTH * rate[..., None] * np.stack([np.cos(theta), zero, np.sin(theta)], axis=-1)
    truth.p_WB[:] = np.cumsum(along, axis=1) - along / 2
    truth.v_WB[:] = np.cumsum(moving, axis=1) - moving / 2
    truth.q_WB[:] = about(1, -theta)
    truth.w_WB[:, :, 1] = -rate
    return truth


def scene(p: P) -> Scene:
    """n equal rods in one line at `angle` [degrees], the first on a hinge at the origin; all axes along y, all at rest."""
    count = round(p.n)
    theta = np.full((1, count), np.radians(p.angle))
    start = placed(np.zeros(1), theta, np.zeros_like(theta))
    rods = tuple(
        Body.box(f"link_{k}", HALF, mass=MASS, touches=False, p_WB=start.p_WB[0, k].tolist(), q_WB=start.q_WB[0, k].tolist())
        for k in range(count)
    )
    along = LENGTH * np.array([np.sin(theta[0, 0]), 0.0, -np.cos(theta[0, 0])])
    hinges = tuple(
        Revolute(
            name=f"hinge_{k}",
            parent=f"link_{k - 1}" if k else WORLD,
            child=f"link_{k}",
            anchor_W=(k * along).tolist(),
            axis_W=(0.0, 1.0, 0.0),
        )
        for k in range(count)
    )
    return Scene(bodies=rods, joints=hinges, narrow=Effect.GYROSCOPIC)


@lru_cache(maxsize=8)
def _masses(n: int, length: float, inertia: float) -> tuple[Floats, Floats]:
    """A (n, n) kg m2 and m g L (n - i - 1/2) (n,) of `acceleration`."""
    link = np.arange(n, dtype=np.float64)
    coupling: Floats = MASS * length**2 * (n - 0.5 - np.maximum(link[:, None], link[None, :]))
    np.fill_diagonal(coupling, inertia + MASS * length**2 * (n - 1 - link + 0.25))
    weight: Floats = MASS * G * length * (n - 0.5 - link)
    return coupling, weight


def acceleration(theta: Floats, rate: Floats) -> Floats:
    """theta'' (n,) rad/s2 of Lagrange's equations for equal rods with angles counted from the vertical.

    sum_j A_ij cos(theta_i - theta_j) theta_j'' + A_ij sin(theta_i - theta_j) theta_j'^2 = -m g L (n - i - 1/2) sin(theta_i);
    A_ij = m L^2 (n - max(i, j) - 1/2) off the diagonal and A_ii = I + m L^2/4 + m L^2 (n - 1 - i), i from 0.
    """
    coupling, weight = _masses(len(theta), LENGTH, INERTIA)
    apart = theta[:, None] - theta[None, :]
    push = -(coupling * np.sin(apart)) @ rate**2 - weight * np.sin(theta)
    return np.asarray(np.linalg.solve(coupling * np.cos(apart), push), dtype=np.float64)


@lru_cache(maxsize=8)
def _reference(times: tuple[float, ...], n: int, angle: float) -> Converged:
    time = np.array(times)
    start = np.full(n, np.radians(angle)).tolist(), [0.0] * n
    fine, coarse = (
        placed(time, y[:, :n], y[:, n:]) for y in (true_motion(acceleration, *start, time, rtol) for rtol in (1e-12, 1e-10))
    )
    return Converged.between(fine, coarse)


def expected(time: Floats, p: P) -> Converged:
    """Lagrange's equations integrated at a relative tolerance of 1e-12; the error bar is the distance to 1e-10, a hundred times
    the tolerance and so far above the error of the finer one."""
    return _reference(tuple(float(t) for t in time), round(p.n), p.angle)


def energy(run: Trajectory) -> tuple[Floats, Floats]:
    """Kinetic and potential energy (t,) J."""
    turning, moving = np.sum(np.square(run.w_WB), axis=(1, 2)), np.sum(np.square(run.v_WB), axis=(1, 2))
    return 0.5 * INERTIA * turning + 0.5 * MASS * moving, MASS * G * run.p_WB[:, :, 2].sum(axis=1)


@lru_cache(maxsize=16)
def first_order(p: P) -> tuple[float, float, float]:
    """Errors per dt of semi-implicit Euler in joint angles, of position [m/s] and relative energy [1/s]; and the largest speed
    [m/s] of a rod's end."""
    theta, rate = np.full(round(p.n), np.radians(p.angle)), np.zeros(round(p.n))
    angles, rates, every = [theta], [rate], 16
    for step in range(1, round(DURATION / SAMPLE) + 1):
        rate = rate + SAMPLE * acceleration(theta, rate)
        theta = theta + SAMPLE * rate
        if step % every == 0:
            angles.append(theta)
            rates.append(rate)
    time = np.arange(len(angles), dtype=np.float64) * (every * SAMPLE)
    euler, truth = placed(time, np.array(angles), np.array(rates)), expected(time, p).trajectory
    moved = float(np.linalg.norm(euler.p_WB - truth.p_WB, axis=-1).max())
    kinetic, potential = energy(euler)
    drift = float(np.abs(kinetic + potential - potential[0]).max()) / float(energy(truth)[0].max())
    fastest = 2 * float(np.linalg.norm(truth.v_WB, axis=-1).max())
    return moved / SAMPLE, drift / SAMPLE, fastest


WHY = (
    "twice the error, to first order in dt, of semi-implicit Euler in joint angles in this very motion; the factor 2 "
    "leaves room for terms of second order and for maximal coordinates, whose projected velocities err by as much"
)

CASE = Case.of(
    globals(),
    title="A chain of rods",
    question="Does a hanging chain of n rods swing by Lagrange's equations, keep its energy and hold together?",
    source="Lagrange's equations of n rods (Goldstein, Classical Mechanics, chapter 1); SciPy DOP853 as reference",
    truth="converged reference",
    hard=Axis(parameter="n", unit="1", easy=1, extreme=64, lost=0.1),
    converges="smoothly",
    checks=(
        Check(errors.position_error_max, lambda dt, p: 2 * first_order(p)[0] * dt, WHY),
        Check(energy_drift_max, lambda dt, p: 2 * first_order(p)[1] * dt, WHY),
        Check(
            joints.joint_gap_max,
            lambda dt, p: 5 * (first_order(p)[2] * dt) ** 2 / LENGTH + 1e-6,
            "a step along the tangent leaves the circle by (v dt)^2/(2 d), d half a rod, of which a solver that "
            "corrects a fifth a step keeps five; 1e-6 m for single precision. Joint coordinates have none",
        ),
    ),
    observe=(energy_drift_staggered_max, errors.position_error_final),
)
