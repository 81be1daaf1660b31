"""A rod that swings into the stop of its hinge: does the stop hold it, where it should and when it should?"""

from typing import Annotated

import numpy as np
from annotated_types import Interval

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import errors, jitter, joints
from plumbline.harness.scene import WORLD, Body, Effect, Limits, Revolute, Scene, box_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.pendulum import hanging, swinging

DURATION = 3.0
LENGTH, MASS, THICKNESS = 1.0, 1.0, 0.04
HALF = (THICKNESS, THICKNESS, LENGTH / 2)
D = LENGTH / 2
INERTIA = box_inertia(MASS, HALF)[1][1] + MASS * D**2


class P(Parameters):
    amplitude: Annotated[float, Interval(gt=0, lt=180)] = 80.0
    stop: float = 20.0
    """Degrees from hanging: where the rod is released, and the stop, before the lowest point, so that weight holds it there."""


def scene(p: P) -> Scene:
    """A rod on a hinge at the origin, at rest at `amplitude` with a stop at `stop` [degrees from hanging], stop < amplitude."""
    p_WB, q_WB = hanging(np.array(np.radians(p.amplitude)), D)
    rod = Body.box("rod", HALF, mass=MASS, touches=False, p_WB=p_WB.tolist(), q_WB=q_WB.tolist())
    # A turn about -y raises the rod towards +x.
    hinge = Revolute(
        name="hinge",
        parent=WORLD,
        child="rod",
        anchor_W=(0.0, 0.0, 0.0),
        axis_W=(0.0, -1.0, 0.0),
        position=float(np.radians(p.amplitude)),
        limits=Limits(lower=float(np.radians(p.stop))),
    )
    return Scene(bodies=(rod,), joints=(hinge,), narrow=Effect.GYROSCOPIC)


RATE = float(np.sqrt(MASS * G * D / INERTIA))
"""Angular frequency of small swings [rad/s]."""


def striking_time(p: P) -> float:
    """The instant [s] at which the rod reaches the stop: K(k) - F(phi, k) over w0, sin(phi) = sin(stop/2)/k."""
    from scipy.special import ellipk, ellipkinc  # late: a listing must not pay for it

    k = float(np.sin(np.radians(p.amplitude) / 2))
    phi = np.arcsin(np.sin(np.radians(p.stop) / 2) / k)
    return float(ellipk(k * k) - ellipkinc(phi, k * k)) / RATE


def expected(time: Floats, p: P) -> Trajectory:
    """The pendulum up to the stop, without restitution, and rest on it."""
    truth = Trajectory.of(time, 1)
    theta, turning = swinging(truth.time, RATE, np.radians(p.amplitude))
    swings = truth.time < striking_time(p)
    truth.p_WB[:, 0], truth.q_WB[:, 0] = hanging(np.where(swings, theta, np.radians(p.stop)), D)
    truth.w_WB[:, 0, 1] = np.where(swings, -turning, 0.0)
    truth.v_WB[:, 0] = np.cross(truth.w_WB[:, 0], truth.p_WB[:, 0])
    return truth


def _way(dt: float, p: P) -> float:
    """The rod's angle [rad] in one step before the stop: w^2 = 2 w0^2 (cos(stop) - cos(amplitude))."""
    return float(np.sqrt(2 * RATE**2 * (np.cos(np.radians(p.stop)) - np.cos(np.radians(p.amplitude))))) * dt


def _gap(dt: float, p: P) -> float:
    """Five steps' departure along the tangent, and one step's way at the blow."""
    way = _way(dt, p)
    return 5 * (way * D) ** 2 / (2 * D) + D * way + 1e-6


CASE = Case.of(
    globals(),
    title="Hinge with a stop",
    question="Does a stop end a swing where it stands, without bounce, and hold the weight afterwards?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 11, problem 1, up to the stop; an inelastic stop by definition",
    truth="closed form",
    sample_interval=1 / 240,
    checks=(
        Check(
            joints.limit_overshoot_max,
            _way,
            "a stop that is noticed only once it is passed is passed by at most one step's way at the speed of the blow",
        ),
        Check(
            joints.limit_overshoot_final,
            1e-3,
            "a thousandth of a radian, as far as a millimetre at the end of a rod of one metre, is what a stop may "
            "give way under the rod's weight and still be a stop",
        ),
        Check(
            errors.position_error_max,
            lambda dt, p: D * 3 * _way(dt, p) + 2e-3,
            "the swing errs by half a step's way and by the period's error, the blow comes up to a step late and "
            "passes the stop by one more: three steps' way, and what a stop may give way",
        ),
        Check(
            jitter.rms_speed,
            lambda dt, _: G * dt,
            "at rest on the stop nothing is left but the velocity that gravity gives in a step and the stop takes back",
            start=2.0,
        ),
        Check(
            joints.joint_gap_max,
            _gap,
            "five steps' departure along the tangent, (v dt)^2/(2 d) each, and one step's way at the blow, whose "
            "impulse the hinge bears",
        ),
    ),
    observe=(errors.position_error_final,),
)
