"""Energy of an orbit about the origin under a force that falls with the square of the distance.

The strength of the centre is read off the truth, whose v^2/2 - k/r is constant. The raw figure takes the velocities as they
are; the staggered one first moves them on by half a step, v - (dt/2) k r/|r|^3, since semi-implicit Euler's belong to half a
step before their positions. For an integrator that does not stagger the raw figure is the right one; none is chosen.
"""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.series import last, matched, maximum
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import movable

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


def _drift(scene: Scene, actual: Trajectory, expected: Trajectory | None, half_steps: float) -> Floats:
    """|E(t) - E(0)| over the magnitude of the truth's E, (t, n)."""
    truth, bodies = matched(actual, expected), movable(scene)
    if len(bodies) == 0 or len(truth) < 2:
        raise NotMeasurable("an orbit needs a body that moves and at least 2 samples")
    k, scale = _strength(truth.p_WB[:, bodies], truth.v_WB[:, bodies])
    p_WB = actual.p_WB[:, bodies]
    distance = np.linalg.norm(p_WB, axis=-1, keepdims=True)
    v_WB = actual.v_WB[:, bodies] - half_steps * actual.dt / 2 * k * p_WB / distance**3
    energy = np.square(v_WB).sum(axis=-1) / 2 - k / distance[..., 0]
    drift: Floats = np.abs(energy - energy[0]) / abs(scale)
    return drift


ORBIT_ENERGY_MAX = Metric(
    name="orbit_energy_drift_max", unit="1", source=SOURCE, measure=lambda s, a, e: maximum(_drift(s, a, e, 0.0))
)
ORBIT_ENERGY_FINAL = Metric(
    name="orbit_energy_drift_final", unit="1", source=SOURCE, measure=lambda s, a, e: last(_drift(s, a, e, 0.0))
)
ORBIT_ENERGY_STAGGERED = Metric(
    name="orbit_energy_drift_staggered_max",
    unit="1",
    source=SOURCE,
    even=True,
    measure=lambda s, a, e: maximum(_drift(s, a, e, 1.0)),
)

METRIC = (ORBIT_ENERGY_MAX, ORBIT_ENERGY_FINAL, ORBIT_ENERGY_STAGGERED)
