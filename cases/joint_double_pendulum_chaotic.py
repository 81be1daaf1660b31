"""Double pendulums let go from high up, a millionth to a thousandth of a radian apart: what is left to compare in chaos?

For a second each follows its equations as closely as the time step allows. Later states are nobody's to predict; what remains
is the energy of each step, and what the pendulums do on average, which no rounding can change.
"""

from functools import lru_cache

import numpy as np

from plumbline.harness.case import Case, Check, Converged, FloatCount, Parameters
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import chaos, errors, joints
from plumbline.harness.metrics.conservation import energy_drift_final, energy_drift_max, energy_drift_staggered_max
from plumbline.harness.scene import WORLD, Body, Effect, Revolute, Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.first_order import FIRST_ORDER, first_order_motions, true_motion
from plumbline.harness.truths.pendulum import INERTIA, LENGTH, MASS, THICKNESS, D, acceleration, placed, poses

NEAREST, FARTHEST = 1e-6, 1e-3
"""Offsets [rad] of the members' upper rods from the first one's."""
HORIZON, PARTED, DURATION = 1.0, 5.0, 10.0
"""Up to the horizon [s] errors grow some twenty-fold; by 5 s the nearest two starts have grown a millionfold apart."""


class P(Parameters):
    upper: float = 120.0
    lower: float = 120.0
    """Degrees from the downward vertical: far above 90, where regular swings end."""
    members: FloatCount = 8


def _starts(upper: float, lower: float, members: float) -> Floats:
    """Angles (2, members) rad."""
    apart = np.concatenate([[0.0], np.geomspace(NEAREST, FARTHEST, round(members) - 1)])
    return np.stack([np.radians(upper) + apart, np.full_like(apart, np.radians(lower))])


def scene(p: P) -> Scene:
    """So many double pendulums on hinges at the origin, at rest; they pass through each other."""
    half = (THICKNESS, THICKNESS, LENGTH / 2)
    rods, hinges = [], []
    for k, theta in enumerate(_starts(p.upper, p.lower, p.members).T):
        p_WB, q_WB = poses(theta)
        elbow = (LENGTH * float(np.sin(theta[0])), 0.0, -LENGTH * float(np.cos(theta[0])))
        for i, (name, parent, anchor) in enumerate(
            ((f"upper_{k}", WORLD, (0.0, 0.0, 0.0)), (f"lower_{k}", f"upper_{k}", elbow))
        ):
            rods.append(Body.box(name, half, mass=MASS, touches=False, p_WB=p_WB[i].tolist(), q_WB=q_WB[i].tolist()))
            hinges.append(Revolute(name=f"hinge_{i}_{k}", parent=parent, child=name, anchor_W=anchor, axis_W=(0.0, 1.0, 0.0)))
    return Scene(bodies=tuple(rods), joints=tuple(hinges), narrow=Effect.GYROSCOPIC)


def _together(q: Floats, rate: Floats) -> Floats:
    """theta'' of all members, flat."""
    return acceleration(q.reshape(2, -1), rate.reshape(2, -1)).ravel()


def _trajectory(time: Floats, y: Floats) -> Trajectory:
    """All members at their angles and rates (t, 4 members)."""
    count = y.shape[1] // 4
    made = Trajectory.of(time, 2 * count)
    for k in range(count):
        member = placed(time, y[:, k::count])
        for whole, array in (
            (made.p_WB, member.p_WB),
            (made.q_WB, member.q_WB),
            (made.v_WB, member.v_WB),
            (made.w_WB, member.w_WB),
        ):
            whole[:, 2 * k : 2 * k + 2] = array
    return made


@lru_cache(maxsize=4)
def _reference(times: tuple[float, ...], upper: float, lower: float, members: float) -> Converged:
    time, start = np.array(times), _starts(upper, lower, members).ravel().tolist()
    still = [0.0] * len(start)
    fine = _trajectory(time, true_motion(_together, start, still, time, 1e-11))
    early = time[time <= HORIZON + 1e-9]
    coarse = _trajectory(early, true_motion(_together, start, still, early, 1e-9))
    return Converged(
        trajectory=fine,
        position_error=float(np.abs(fine.p_WB[: len(early)] - coarse.p_WB).max(initial=0.0)) * 3**0.5,
        velocity_error=float(np.abs(fine.v_WB[: len(early)] - coarse.v_WB).max(initial=0.0)) * 3**0.5,
    )


def expected(time: Floats, p: P) -> Converged:
    """Lagrange's equations integrated at a relative tolerance of 1e-11.

    The error bars hold up to the horizon: they are the distance to 1e-9, a hundred times the tolerance. Beyond it this is one
    possible motion among all that start within its rounding, and stands for their average only.
    """
    return _reference(tuple(float(t) for t in time), p.upper, p.lower, p.members)


def _alike(value: float) -> float:
    """A number that chaos has worked on, to the three digits in which machines of other vector units agree."""
    return float(f"{value:.3g}")


@lru_cache(maxsize=8)
def _position_per_step(p: P) -> float:
    """Largest error of position per dt [m/s] of the textbook's first-order methods up to the horizon."""
    times, small = np.linspace(0.0, HORIZON, 101), 1e-7
    start = np.radians([p.upper, p.lower]).tolist()
    true = placed(times, true_motion(acceleration, start, [0.0, 0.0], times, 1e-12)).p_WB
    motions = (placed(times, y).p_WB for y in first_order_motions(acceleration, start, [0.0, 0.0], times, small))
    return _alike(max(float(np.linalg.norm(moved - true, axis=-1).max()) for moved in motions) / small)


@lru_cache(maxsize=8)
def _euler(dt: float, p: P) -> tuple[float, float]:
    """Largest relative energy error of semi-implicit Euler in joint angles at this step, and a rod's greatest speed [m/s]."""
    theta = _starts(p.upper, p.lower, p.members)
    rate, states, every = np.zeros_like(theta), [], max(1, round(1 / (240 * dt)))
    for step in range(round(DURATION / dt)):
        if step % every == 0:
            states.append(np.concatenate([theta.ravel(), rate.ravel()]))
        rate = rate + dt * acceleration(theta, rate)
        theta = theta + dt * rate
    time: Floats = every * dt * np.arange(len(states), dtype=np.float64)
    run = _trajectory(time, np.array(states))
    kinetic = (MASS * np.sum(np.square(run.v_WB), axis=(1, 2)) + INERTIA * np.sum(np.square(run.w_WB), axis=(1, 2))) / 2
    energy = kinetic + MASS * G * run.p_WB[:, :, 2].sum(axis=1)
    fastest = float(np.linalg.norm(run.v_WB, axis=-1).max())
    return _alike(float(np.abs(energy - energy[0]).max() / kinetic.max())), _alike(fastest)


@lru_cache(maxsize=8)
def _roughly(upper: float, lower: float, members: float) -> Trajectory:
    """The motion for averages, sixty samples a second: they need no more than the tolerance that keeps the energy."""
    time: Floats = np.arange(round(60 * DURATION) + 1, dtype=np.float64) / 60
    start = _starts(upper, lower, members).ravel().tolist()
    return _trajectory(time, true_motion(_together, start, [0.0] * len(start), time, 1e-7))


@lru_cache(maxsize=8)
def _late(p: P) -> tuple[float, float]:
    """Of the reference once the starts have parted: the standard error of the difference of two means of the members' kinetic
    energies, as a share of that mean; and the largest kinetic energy of all over the mean of all."""
    run = _roughly(p.upper, p.lower, p.members)
    late = chaos.kinetic_energies(scene(p), run.between(PARTED, DURATION))
    instants = (MASS * np.sum(np.square(run.v_WB), axis=(1, 2)) + INERTIA * np.sum(np.square(run.w_WB), axis=(1, 2))) / 2
    chance = float(np.sqrt(2 * np.var(late, ddof=1) / len(late)) / late.mean())
    return _alike(chance), _alike(float(instants.max() / late.sum()))


def _average(dt: float, p: P) -> float:
    chance, largest = _late(p)
    return 5 * chance + 2 * _euler(dt, p)[0] * largest


CASE = Case.of(
    globals(),
    title="Double pendulums in chaos",
    question="Does a chaotic motion follow its equations while it can, and keep its energy and its average when it cannot?",
    source="Shinbrot, Grebogi, Wisdom, Yorke, Am. J. Phys. 60 (1992) 491 (a chaotic double pendulum); SciPy DOP853",
    truth="converged reference",
    dt=1 / 480,
    ladder=(1 / 240, 1 / 360, 1 / 480, 1 / 960, 1 / 1920, 1 / 3840),
    checks=(
        Check(errors.position_error_max, lambda dt, p: 2 * _position_per_step(p) * dt, FIRST_ORDER, end=HORIZON),
        Check(
            energy_drift_max,
            lambda dt, p: 2 * _euler(dt, p)[0],
            "twice the error of semi-implicit Euler in joint angles at this step, over the same time and from the same "
            "eight starts, which see enough of the chaos for its largest error to be typical",
        ),
        Check(
            joints.joint_gap_max,
            lambda dt, p: 5 * (2 * _euler(dt, p)[1] * dt) ** 2 / (2 * D) + 1e-6,
            "a step along the tangent leaves the circle by (v dt)^2/(2 d), v twice that of the centre, of which a "
            "solver that corrects a fifth a step keeps five; 1e-6 m for single precision. Joint coordinates have none",
        ),
        Check(
            chaos.ensemble_energy_error,
            _average,
            "by 5 s the starts have forgotten each other, and the means of two sets of eight differ by chance, five "
            "standard errors of which come up once in thousands; and a step that changes the energy changes how fast the "
            "pendulums are, by as much at most",
            start=PARTED,
        ),
    ),
    observe=(chaos.ensemble_spread, energy_drift_staggered_max, energy_drift_final),
)
