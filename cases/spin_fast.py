"""A small body that spins fast: up to how many radians a step does its rotation stay bounded?"""

import numpy as np

from plumbline.harness.case import Axis, Case, Check, Parameters, Positive
from plumbline.harness.metrics import conservation, errors
from plumbline.harness.scene import Body, Scene, box_inertia
from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.free_rotation import free_rotation

DURATION = 2.0
HALF = (0.03, 0.02, 0.005)
"""Half extents [m] of a plate of 30 g: moments of some 1e-6 kg m2, ascending along x, y, z."""
MASS = 0.03


class P(Parameters):
    speed: Positive = 100.0
    direction: Vector3 = (0.8, 0.1, 0.59)


def scene(p: P) -> Scene:
    """A plate that spins at `speed` [rad/s] about an axis of its own that is no principal axis."""
    unit = np.array(p.direction) / np.linalg.norm(p.direction)
    plate = Body.box("plate", HALF, mass=MASS, touches=False, w_WB=(p.speed * unit).tolist())
    return Scene(bodies=(plate,), gravity=(0.0, 0.0, 0.0))


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form of the free rotation."""
    unit = np.array(p.direction) / np.linalg.norm(p.direction)
    a, b, c = (float(x) for x in np.diag(np.array(box_inertia(MASS, HALF))))
    x, y, z = (float(p.speed * u) for u in unit)
    truth = Trajectory.of(time, 1)
    truth.q_WB[:, 0], truth.w_WB[:, 0] = free_rotation(truth.time, (a, b, c), (x, y, z))
    return truth


def _room(_dt: float, p: P) -> float:
    """The largest relative change of the energy at the present |L|: from L^2/(2 E) between the least and greatest moment."""
    moments = np.diag(np.array(box_inertia(MASS, HALF)))
    w = np.array(p.direction)
    mean = float(np.sum((moments * w) ** 2) / np.sum(moments * w**2))
    return float(max(mean / moments.min() - 1, 1 - mean / moments.max()))


CASE = Case.of(
    globals(),
    title="Fast spin",
    question="Up to what speed does a small body's rotation stay bounded?",
    source="Euler's equations: at a given L the energy lies between L^2/(2 I3) and L^2/(2 I1)",
    truth="closed form",
    hard=Axis(parameter="speed", unit="rad/s", easy=10.0, extreme=10000.0, lost=0.1),
    sample_interval=1 / 240,
    headline=conservation.angular_momentum_drift_max.name,
    checks=(
        Check(
            conservation.energy_drift_max,
            _room,
            "with the angular momentum it has, no direction of spin gives this body another energy than L^2/(2 I3).. "
            "L^2/(2 I1): a larger change proves that angular momentum was made or lost",
        ),
        Check(
            conservation.angular_momentum_drift_max,
            1.0,
            "an error as large as L itself: nothing of it was kept. How much was is the figure to look at",
        ),
    ),
    observe=(conservation.energy_drift_final, errors.attitude_error_max, errors.angular_velocity_error_max),
)
