"""A torque-free asymmetric top: are the gyroscopic terms there, and where does angular momentum go?"""

from collections.abc import Callable

import numpy as np

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.metrics import conservation, errors
from plumbline.harness.scene import Body, Box, Scene, principal_inertia
from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.free_rotation import FIRST_ORDER, first_order_errors, free_rotation

DURATION = 10.0
MOMENTS = (1.0, 2.0, 3.0)
SPIN = (0.5, 0.7, 1.2)
"""Generic rates [rad/s]: all three differ, and L^2 = 15.2 lies well off the separatrix 2 E I2 = 11.1."""


class P(Parameters):
    moments: Vector3 = MOMENTS
    spin: Vector3 = SPIN


def scene(p: P) -> Scene:
    """A body of 6 kg with principal `moments` [kg m2] in ascending order, spinning at `spin` [rad/s] in B, B on W at time 0."""
    mass = 6.0
    a, b, c = (0.5 * (sum(p.moments) - 2 * moment) for moment in p.moments)
    half = tuple(float(np.sqrt(3.0 * max(x, 1e-6) / mass)) for x in (a, b, c))
    shape = Box(half_extents=(half[0], half[1], half[2]))
    top = Body.solid("top", shape, mass=mass, inertia=principal_inertia(*p.moments), touches=False, w_WB=p.spin)
    return Scene(bodies=(top,), gravity=(0.0, 0.0, 0.0))


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form."""
    truth = Trajectory.of(time, 1)
    truth.q_WB[:, 0], truth.w_WB[:, 0] = free_rotation(truth.time, p.moments, p.spin)
    return truth


def _first_order(column: int) -> Callable[[float, P], float]:
    """The bound over dt of attitude (0), angular momentum (1) or energy (2)."""
    return lambda dt, p: 2 * first_order_errors(p.moments, p.spin, DURATION)[column] * dt


CASE = Case.of(
    globals(),
    title="Asymmetric top",
    question="Does a body with three different moments tumble as Euler's equations say, with angular momentum fixed in W?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 37",
    truth="closed form",
    converges="smoothly",
    checks=(
        Check(errors.attitude_error_max, _first_order(0), FIRST_ORDER),
        Check(conservation.angular_momentum_drift_max, _first_order(1), FIRST_ORDER),
        Check(conservation.energy_drift_max, _first_order(2), FIRST_ORDER),
        Check(errors.position_error_max, 1e-6, "no force acts; 1e-6 m is single-precision rounding"),
    ),
    observe=(
        errors.attitude_error_rms,
        errors.attitude_error_final,
        errors.angular_velocity_error_max,
        conservation.energy_drift_staggered_max,
    ),
)
