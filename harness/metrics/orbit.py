"""Energy of an orbit about the origin under a force that falls with the square of the distance.

The strength of the centre is read off the truth, whose v^2/2 - k/r is constant. The raw figure takes the velocities as they
are; the staggered one first moves them on by half a step, v - (dt/2) k r/|r|^3, since semi-implicit Euler's belong to half a
step before their positions. For an integrator that does not stagger the raw figure is the right one; none is chosen.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import last
from plumbline.harness.trajectory import Floats

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


@metric("1", SOURCE)
def orbit_energy_drift_max(run: Run) -> Floats:
    return _drift(run, 0.0)


@metric("1", SOURCE)
def orbit_energy_drift_final(run: Run) -> float:
    return last(_drift(run, 0.0))


@metric("1", SOURCE, even=True)
def orbit_energy_drift_staggered_max(run: Run) -> Floats:
    return _drift(run, 1.0)
