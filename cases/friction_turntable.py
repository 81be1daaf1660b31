"""A ball rolling on a turntable: it goes round on a circle of its own, at 2/7 of the table's rate.

v' = k/(1 + k) W z x v for a ball with I = k m r^2 that rolls on a table turning at W: wherever and however fast it starts.
"""

import numpy as np

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import forces_obey_coulomb
from plumbline.harness.metrics.errors import position_error_final, position_error_max, radius_error_max, velocity_error_max
from plumbline.harness.scene import Body, Box, Effect, PlacedShape, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about

DURATION = 4.0
RATE, START, FRICTION, RADIUS, MASS = 3.0, 0.5, 1.0, 0.05, 1.0
SHARE = 0.4 / 1.4
"""k/(1 + k) of a solid sphere: 2/7."""
HALF = (2.0, 2.0, 0.1)
"""Half extents of the table [m]."""


class P(Parameters):
    rate: Positive = RATE
    start: Positive = START


def _ball(time: Floats, rate: float, start: float) -> tuple[Floats, Floats, Floats]:
    """Position, velocity and spin (t, 3) of the ball on its circle about the table's axis."""
    angle = SHARE * rate * time
    out = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle), np.zeros_like(angle)], axis=1)
    # No slip: the ball's lowest point, at v - r w x z, moves with the table, at W z x p. Both are along the circle.
    return start * out + np.array([0.0, 0.0, RADIUS]), SHARE * rate * start * along, (1 - SHARE) * rate * start / RADIUS * out


def scene(p: P) -> Scene:
    """A table turning at `rate` [rad/s] about z and a ball on it, `start` [m] from the axis, on its circle."""
    centre, v, w = _ball(np.zeros(1), p.rate, p.start)
    table = Body(
        name="table",
        motion="kinematic",
        material="table",
        collision=(PlacedShape(shape=Box(half_extents=HALF)),),
        p_WB=(0.0, 0.0, -HALF[2]),
        w_WB=(0.0, 0.0, p.rate),
    )
    ball = Body.ball(
        "ball", RADIUS, mass=MASS, material="ball", p_WB=centre[0].tolist(), v_WB=v[0].tolist(), w_WB=w[0].tolist()
    )
    return Scene(
        bodies=(table, ball),
        surfaces=(Surface.rough(FRICTION, ("ball", "table")),),
        # A ball's inertia is the same about every axis.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The circle. The ball's attitude is not part of the truth: its spin turns with the circle and does not add up to an "
    "angle."""
    truth = Trajectory.at_rest(scene(p), time)
    truth.q_WB[:, 0], truth.w_WB[:, 0, 2] = about(2, p.rate * truth.time), p.rate
    truth.p_WB[:, 1], truth.v_WB[:, 1], truth.w_WB[:, 1] = _ball(truth.time, p.rate, p.start)
    return truth


def _position(dt: float, p: P) -> float:
    """First-order methods turn the velocity at the start or the end of a step: the circle widens by W' dt/2 each radian."""
    turn = SHARE * p.rate
    return 2 * p.start * turn * dt * (1 + turn * DURATION)


def _velocity(dt: float, p: P) -> float:
    """The speed on a circle that much off, and half a step of turning, taken twice."""
    turn = SHARE * p.rate
    return turn * _position(dt, p) + SHARE * p.rate * p.start * turn * dt


CASE = Case.of(
    globals(),
    title="Ball on a turntable",
    question="Does a ball rolling on a turning table go round at 2/7 of the table's rate?",
    source="Weltner, Stable circular orbits of freely moving balls on rotating discs, Am. J. Phys. 47 (1979) 984",
    truth="closed form",
    converges="once",
    scale=START,
    checks=(
        Check(
            position_error_max,
            _position,
            "friction of the start or of the end of a step turns the velocity half a step early or late, which widens "
            "or narrows the circle by W' dt/2 for each radian of it; taken four times for a first step without a contact",
        ),
        Check(velocity_error_max, _velocity, "the speed on a circle that much off, and half a step of turning, taken twice"),
        *forces_obey_coulomb(),
    ),
    observe=(position_error_final, radius_error_max),
)
