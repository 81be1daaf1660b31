"""A torque-free symmetric top: does it precess about its angular momentum at L/I while its body spins at (1 - J/I) w3?"""

from collections.abc import Callable

import numpy as np

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.metrics import conservation, errors
from plumbline.harness.metrics.conservation import angular_momentum_drift_max
from plumbline.harness.scene import Body, Cylinder, Scene, principal_inertia
from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import product, rotate
from plumbline.harness.truths.free_rotation import FIRST_ORDER, first_order_errors

DURATION = 10.0
ACROSS, ALONG = 1.0, 1.6
"""Moments about the axes across the axis of symmetry and along it [kg m2]."""
SPIN = (0.6, 0.0, 1.0)


class P(Parameters):
    across: Positive = ACROSS
    along: Positive = ALONG
    spin: Vector3 = SPIN


def scene(p: P) -> Scene:
    """A cylinder of 6 kg with its axis along z, spinning at `spin` [rad/s]."""
    mass = 6.0
    radius = float(np.sqrt(2 * p.along / mass))
    half_length = float(np.sqrt(max(3 * p.across / mass - 0.75 * radius**2, 1e-6)))
    shape, inertia = Cylinder(radius=radius, half_length=half_length), principal_inertia(p.across, p.across, p.along)
    top = Body.solid("top", shape, mass=mass, inertia=inertia, touches=False, w_WB=p.spin)
    return Scene(bodies=(top,), gravity=(0.0, 0.0, 0.0))


def _turn(axis: Floats, angle: Floats) -> Floats:
    """The rotation by angles [rad] (t,) about a unit axis (3,), (t, 4)."""
    return np.concatenate([np.cos(angle / 2)[:, None], np.sin(angle / 2)[:, None] * axis], axis=1)


def expected(time: Floats, p: P) -> Trajectory:
    """A turn at L/I about the fixed L, after a turn at (1 - J/I) w3 about the axis of symmetry."""
    truth = Trajectory.of(time, 1)
    w0 = np.array(p.spin)
    momentum = np.array([p.across, p.across, p.along]) * w0
    size = float(np.linalg.norm(momentum))
    precession = _turn(momentum / max(size, 1e-300), size / p.across * truth.time)
    truth.q_WB[:, 0] = product(precession, _turn(np.array([0.0, 0.0, 1.0]), (1 - p.along / p.across) * p.spin[2] * truth.time))
    # w_B goes round the axis of symmetry the other way; in W it goes round L with the axis itself.
    truth.w_WB[:, 0] = rotate(precession, np.broadcast_to(w0, (len(truth.time), 3)))
    return truth


def _first_order(column: int) -> Callable[[float, P], float]:
    """The bound over dt of attitude (0), angular momentum (1) or energy (2)."""
    return lambda dt, p: 2 * first_order_errors((p.across, p.across, p.along), p.spin, DURATION)[column] * dt


CASE = Case.of(
    globals(),
    title="Symmetric top",
    question="Does a torque-free axisymmetric body precess about its angular momentum at the rate L/I?",
    source="Kane, Likins, Levinson, Spacecraft Dynamics (1983), section 3.1",
    truth="closed form",
    converges="smoothly",
    checks=(
        Check(errors.attitude_error_max, _first_order(0), FIRST_ORDER),
        Check(angular_momentum_drift_max, _first_order(1), FIRST_ORDER),
        Check(conservation.energy_drift_max, _first_order(2), FIRST_ORDER),
    ),
    observe=(
        errors.attitude_error_rms,
        errors.attitude_error_final,
        errors.angular_velocity_error_max,
        conservation.energy_drift_staggered_max,
    ),
)
