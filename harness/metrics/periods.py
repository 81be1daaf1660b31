"""Motions that come round: orbits and swings, flips and precession of tops.

Energy of an orbit about the origin under a force that falls with the square of the distance: the strength of the centre is read
off the truth, whose v^2/2 - k/r is constant. The raw figure takes the velocities as they are; the staggered one first moves
them on by half a step, v - (dt/2) k r/|r|^3, since semi-implicit Euler's belong to half a step before their positions. For an
integrator that does not stagger the raw figure is the right one; none is chosen.

Phase and period of an oscillation are read off the instants at which the first movable body passes the middle of its path. The
path is projected on the direction in which the truth moves most. A passage is found by inverse interpolation with the cubic
through four samples, alike in answer and truth, so that the interpolation's own error (of fourth order) cancels.

A flip is a passage of the angular velocity's component along the body's middle principal axis through zero. The final angle is
no measure there: near the separatrix it is at the mercy of rounding. Precession and nutation of a heavy top about the vertical
are read off the axis of symmetry of the first movable body, that of the largest or smallest principal moment, whichever stands
apart from the other two.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import two
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import movable, rotate, rotate_back

SOURCE = (
    "vis-viva: v^2/2 - k/r is constant (Goldstein, Classical Mechanics, 3rd ed., section 3.7); half-step correction: Hairer, "
    "Lubich, Wanner, Geometric Numerical Integration, section I.1.4"
)


def _strength(p_WB: Floats, v_WB: Floats) -> tuple[float, float]:
    """k [m3/s2] and the energy per mass [J/kg] of the truth, by least squares of v^2/2 = k/r + energy."""
    distance = np.linalg.norm(p_WB, axis=-1).ravel()
    if not (distance.min() > 0.0 and np.ptp(1 / distance) > 1e-6 / distance.max()):
        raise NotMeasurable("the truth keeps its distance from the origin: the strength of the centre cannot be read off it")
    table = np.stack([1 / distance, np.ones_like(distance)], axis=1)
    k, energy = np.linalg.lstsq(table, (np.square(v_WB).sum(axis=-1) / 2).ravel(), rcond=None)[0]
    return float(k), float(energy)


def _drift(run: Run, half_steps: float) -> Floats:
    """|E(t) - E(0)| over the magnitude of the truth's E, (t, n)."""
    actual, truth, bodies = run.actual, run.truth, run.movable
    if len(bodies) == 0 or len(truth) < 2:
        raise NotMeasurable("an orbit needs a body that moves and at least 2 samples")
    k, scale = _strength(truth.p_WB[:, bodies], truth.v_WB[:, bodies])
    p_WB = actual.p_WB[:, bodies]
    distance = np.linalg.norm(p_WB, axis=-1, keepdims=True)
    v_WB = actual.v_WB[:, bodies] - half_steps * actual.dt / 2 * k * p_WB / distance**3
    energy = np.square(v_WB).sum(axis=-1) / 2 - k / distance[..., 0]
    drift: Floats = np.abs(energy - energy[0]) / abs(scale)
    return drift


orbit_energy_drift_max, orbit_energy_drift_final = two("orbit_energy_drift", "1", SOURCE, lambda run: _drift(run, 0.0))


@metric("1", SOURCE, even=True)
def orbit_energy_drift_staggered_max(run: Run) -> Floats:
    return _drift(run, 1.0)


PHASE_SOURCE = "definition: instants of upward passage through the middle of the path"


def _passages(time: Floats, x: Floats) -> Floats:
    """The instants [s] at which x passes zero upwards, each from the cubic through the two samples on either side."""
    instants = []
    for k in np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0)):
        first = min(max(int(k) - 1, 0), len(x) - 4)
        nodes = time[first : first + 4] - time[k]
        cubic = np.polynomial.Polynomial.fit(nodes, x[first : first + 4], 3, domain=[nodes[0], nodes[-1]])
        roots = np.asarray(cubic.roots())
        real = roots[np.abs(roots.imag) < 1e-6 * (nodes[-1] - nodes[0])].real
        middle = (time[k + 1] - time[k]) / 2
        instants.append(time[k] + real[np.argmin(np.abs(real - middle))])
    return np.array(instants)


def _both(run: Run) -> tuple[Floats, Floats]:
    """Passages of answer and truth."""
    truth, bodies = run.truth, run.movable
    if len(bodies) == 0 or len(run.actual) < 4:
        raise NotMeasurable("a passage needs a body that moves and at least 4 samples")
    path = truth.p_WB[:, bodies[0]]
    centre = (path.max(axis=0) + path.min(axis=0)) / 2
    direction = np.linalg.svd(path - path.mean(axis=0), full_matrices=False)[2][0]
    of_truth = _passages(truth.time, (path - centre) @ direction)
    if len(of_truth) < 2:
        raise NotMeasurable(f"the truth passes the middle of its path {len(of_truth)} times, a period needs 2")
    return _passages(run.actual.time, (run.actual.p_WB[:, bodies[0]] - centre) @ direction), of_truth


def _off_period(answer: Floats, truth: Floats) -> float:
    """The mean distance of instants over that of the truth's, less 1; infinite where there are not two."""
    if len(answer) < 2:
        return float("inf")
    return float(abs((answer[-1] - answer[0]) / (len(answer) - 1) * (len(truth) - 1) / (truth[-1] - truth[0]) - 1))


@metric("rad", PHASE_SOURCE)
def phase_error(run: Run) -> float:
    answer, truth = _both(run)
    if len(answer) == 0:
        return float("inf")
    # The last passage that both have; whole passages lost or won since count as whole turns.
    count = min(len(answer), len(truth))
    period = (truth[-1] - truth[0]) / (len(truth) - 1)
    turns = max(abs(len(answer) - len(truth)) - 1, 0)
    return float(2 * np.pi * (abs(answer[count - 1] - truth[count - 1]) / period + turns))


@metric("1", PHASE_SOURCE)
def period_error(run: Run) -> float:
    return _off_period(*_both(run))


FLIP_SOURCE = "definition: instants at which the component of w along the middle principal axis passes zero"
VERDICT = "the spin's component along the middle axis changes its sign"


def _flips(scene: Scene, trajectory: Trajectory) -> Floats:
    """The instants [s] of the flips of the first movable body, by inverse linear interpolation."""
    bodies = movable(scene)
    if len(bodies) == 0:
        raise NotMeasurable("no body can move")
    moments, axes = np.linalg.eigh(np.array(scene.bodies[bodies[0]].inertia))
    if not moments[0] < moments[1] < moments[2]:
        raise NotMeasurable("two principal moments are equal: there is no middle axis")
    along = rotate_back(trajectory.q_WB[:, bodies[0]], trajectory.w_WB[:, bodies[0]]) @ axes[:, 1]
    # A sample at zero belongs to neither side.
    aside = np.flatnonzero(along)
    turns = np.flatnonzero(np.sign(along[aside[:-1]]) * np.sign(along[aside[1:]]) < 0)
    before, after = aside[turns], aside[turns + 1]
    share = along[before] / (along[before] - along[after])
    instants: Floats = trajectory.time[before] + share * (trajectory.time[after] - trajectory.time[before])
    return instants


@metric("1", FLIP_SOURCE, verdict=VERDICT)
def flip_count_error(run: Run) -> float:
    return float(abs(len(_flips(run.scene, run.actual)) - len(_flips(run.scene, run.truth))))


@metric("1", FLIP_SOURCE, verdict=VERDICT)
def flip_period_error(run: Run) -> float:
    """mean distance over the truth's"""
    truth = _flips(run.scene, run.truth)
    if len(truth) < 2:
        raise NotMeasurable(f"the truth flips {len(truth)} times, a period needs 2")
    return _off_period(_flips(run.scene, run.actual), truth)


PRECESSION_SOURCE = "definition: azimuth and polar angle of the axis of symmetry against the vertical"


def _axis(scene: Scene, trajectory: Trajectory) -> Floats:
    """The axis of symmetry in W, (t, 3)."""
    bodies = movable(scene)
    if len(bodies) == 0 or len(trajectory) < 2:
        raise NotMeasurable("precession needs a body that moves and at least 2 samples")
    moments, axes = np.linalg.eigh(np.array(scene.bodies[bodies[0]].inertia))
    column = 2 if moments[1] - moments[0] <= moments[2] - moments[1] else 0
    if not np.isclose(moments[1], moments[2 - column], rtol=1e-9):
        raise NotMeasurable("no two principal moments are equal: the body has no axis of symmetry")
    return rotate(trajectory.q_WB[:, bodies[0]], np.broadcast_to(axes[:, column], (len(trajectory), 3)))


def _rate(scene: Scene, trajectory: Trajectory) -> float:
    """Mean rate [rad/s] of the azimuth, from the slope of a straight line through it."""
    axis = _axis(scene, trajectory)
    azimuth = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))
    return float(np.polynomial.Polynomial.fit(trajectory.time, azimuth, 1).deriv()(0.0))


@metric("1", PRECESSION_SOURCE)
def precession_rate_error(run: Run) -> float:
    """slope over time"""
    truth = _rate(run.scene, run.truth)
    if truth == 0.0:
        raise NotMeasurable("the truth does not precess")
    return abs(_rate(run.scene, run.actual) / truth - 1)


@metric("rad", PRECESSION_SOURCE)
def nutation_amplitude(run: Run) -> float:
    """beside the truth's"""
    # Largest departure [rad] of the polar angle from the truth's.
    truth = _axis(run.scene, run.truth)
    polar = [np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]) for axis in (_axis(run.scene, run.actual), truth)]
    return float(np.max(np.abs(polar[0] - polar[1])))
