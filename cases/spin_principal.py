"""Bodies that spin about each of their principal axes: is the angle w t, and is no speed capped?"""

import numpy as np

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics import conservation, errors
from plumbline.harness.scene import Body, Effect, Scene, box_inertia
from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about

DURATION = 1.0
SPIN = 10.0
NAMES = ("least", "middle", "greatest")


class P(Parameters):
    spin: float = SPIN
    half_extents: Vector3 = (0.2, 0.15, 0.05)
    """Half extents of the boxes [m]: three different moments."""
    mass: Positive = 1.0


def scene(p: P) -> Scene:
    """Three equal boxes in a row, the k-th spinning at `spin` [rad/s] about its k-th axis."""
    boxes = tuple(
        Body.box(
            name,
            p.half_extents,
            mass=p.mass,
            touches=False,
            p_WB=(0.0, k - 1.0, 0.0),
            w_WB=(p.spin * (k == 0), p.spin * (k == 1), p.spin * (k == 2)),
        )
        for k, name in enumerate(NAMES)
    )
    # About a principal axis there is no gyroscopic torque.
    return Scene(bodies=boxes, gravity=(0.0, 0.0, 0.0), narrow=Effect.GYROSCOPIC)


def expected(time: Floats, p: P) -> Trajectory:
    """The angle is w t, whatever the moments."""
    truth = Trajectory.at_rest(scene(p), time)
    for k in range(3):
        truth.q_WB[:, k], truth.w_WB[:, k, k] = about(k, p.spin * truth.time), p.spin
    return truth


def _grown(p: P) -> float:
    """Share of a turn to which one rounding in single precision grows about the middle axis, exp(rate T)."""
    a, b, c = sorted(np.diag(np.array(box_inertia(1.0, p.half_extents))))
    return SINGLE * float(np.exp(abs(p.spin) * DURATION * np.sqrt((c - b) * (b - a) / (a * c))))


def _angle(dt: float, p: P) -> float:
    """Twice the lag of a normalised quaternion step, (w dt)^2/12 of the angle, and rounding in single precision."""
    lag = abs(p.spin) * DURATION * ((p.spin * dt) ** 2 / 6 + SINGLE * DURATION / dt)
    return lag + _grown(p)


CASE = Case.of(
    globals(),
    title="Spin about principal axes",
    question="Does a body that spins about a principal axis turn by w t, about each of the three?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 36: about a principal axis w is constant",
    truth="closed form",
    converges="smoothly",
    scale=SPIN * DURATION,
    checks=(
        Check(
            errors.attitude_error_max,
            _angle,
            "a quaternion advanced by its derivative and normalised turns by 2 atan(w dt/2), short by (w dt)^2/12 of "
            "the angle, taken twice; a rounding in single precision every step, and one that grows about the middle axis at "
            "the rate of its instability. A hidden damping of 0.04/s would lag by 0.2 rad",
        ),
        Check(
            errors.angular_velocity_error_max,
            lambda dt, p: abs(p.spin) * (SINGLE * DURATION / dt + _grown(p)),
            "nothing acts on the spin: one rounding in single precision a step, and its growth about the middle axis",
        ),
    ),
    observe=(errors.attitude_error_final, conservation.energy_drift_max),
)
