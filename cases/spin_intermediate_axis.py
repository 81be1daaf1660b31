"""A body spun about its middle axis flips over and over: does it, and as often as it should?"""

from functools import lru_cache

import numpy as np

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.metrics import conservation, errors
from plumbline.harness.metrics.periods import flip_count_error, flip_period_error
from plumbline.harness.scene import Body, Box, Scene, principal_inertia
from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.free_rotation import FIRST_ORDER, first_order_errors, free_rotation

DURATION = 20.0


class P(Parameters):
    moments: Vector3 = (1.0, 2.0, 2.5)
    spin: Vector3 = (0.1, 1.5, 0.6)
    """A spin [rad/s] about the middle axis with a push: L^2 is 4 % above 2 E I2, near the separatrix and not on it."""


def scene(p: P) -> Scene:
    """A body of 6 kg with principal `moments` [kg m2] in ascending order, spinning at `spin` [rad/s] in B, B on W at time 0."""
    mass = 6.0
    half = [float(np.sqrt(max(1.5 * (sum(p.moments) - 2 * moment) / mass, 1e-6))) for moment in p.moments]
    shape = Box(half_extents=(half[0], half[1], half[2]))
    body = Body.solid("racket", shape, mass=mass, inertia=principal_inertia(*p.moments), touches=False, w_WB=p.spin)
    return Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0))


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form."""
    truth = Trajectory.of(time, 1)
    truth.q_WB[:, 0], truth.w_WB[:, 0] = free_rotation(truth.time, p.moments, p.spin)
    return truth


def flip_period(square: float, twice_energy: float, moments: Vector3) -> float:
    """The time [s] between two flips of a body with L^2 = `square` and 2 E: half of the period of sn.

    Source: Landau, Lifshitz, Mechanics, section 37, equation 12; the first and third axes change places where L^2 < 2 E I2.
    """
    from scipy.special import ellipk  # late: a listing must not pay for it

    i1, i2, i3 = moments if square > twice_energy * moments[1] else moments[::-1]
    rate = np.sqrt((i3 - i2) * (square - twice_energy * i1) / (i1 * i2 * i3))
    m = (i2 - i1) * (twice_energy * i3 - square) / ((i3 - i2) * (square - twice_energy * i1))
    return float(2 * ellipk(m) / rate)


@lru_cache(maxsize=64)
def _period(dt: float, p: P) -> float:
    """The largest change of the period when the energy is off by twice a first-order method's error, at most a whole period.

    Beyond the separatrix the period falls again; on it there is none.
    """
    i, w = np.array(p.moments), np.array(p.spin)
    square, twice_energy = float(np.sum((i * w) ** 2)), float(np.sum(i * w**2))
    off = 2 * first_order_errors(p.moments, p.spin, DURATION)[2] * dt
    if abs(square / (twice_energy * p.moments[1]) - 1) <= off:
        return 1.0
    # The momentum errs as well, and what counts is the distance of the two from the separatrix.
    period = flip_period(square, twice_energy, p.moments)
    shifted = [flip_period(square, twice_energy * (1 + sign * off), p.moments) for sign in (-1, 1)]
    return min(1.0, max(abs(other / period - 1) for other in shifted))


CASE = Case.of(
    globals(),
    title="Intermediate axis",
    question="Does a body spun about its middle axis flip as often as Jacobi's functions say?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 37; Poinsot (1834); Ashbaugh, Chicone, Cushman, The Twisting Tennis "
    "Racket (1991)",
    truth="closed form",
    sample_interval=1 / 60,
    headline=flip_period_error.name,
    converges="smoothly",
    checks=(
        Check(
            flip_count_error, 1.0, "the last flip may lie on either side of the end of the run, and no other may be lost or won"
        ),
        Check(
            flip_period_error,
            _period,
            "what the period becomes when the energy errs by twice as much as in a first-order method; a whole period "
            "where that error reaches the separatrix",
        ),
        Check(
            conservation.angular_momentum_drift_max,
            lambda dt, p: 2 * first_order_errors(p.moments, p.spin, DURATION)[1] * dt,
            FIRST_ORDER,
        ),
    ),
    observe=(conservation.energy_drift_max, errors.attitude_error_max),
)
