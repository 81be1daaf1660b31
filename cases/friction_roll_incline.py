"""Round bodies released on an incline: which roll, which slip, and how fast do they go down?

A body with I = k m r^2 rolls with a = g sin(angle)/(1 + k) where mu >= tan(angle) k/(1 + k), and slips with
g (sin(angle) - mu cos(angle)) where not. The incline is level ground in a field that leans.
"""

import math
from typing import Annotated

from annotated_types import Interval

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import G, forces_obey_coulomb
from plumbline.harness.metrics import errors
from plumbline.harness.scene import Body, Effect, Scene, Surface, principal_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about
from plumbline.harness.truths.friction import rolling

DURATION = 1.5
RADIUS, MASS, SPACING = 0.1, 1.0, 1.0


class P(Parameters):
    angle: Annotated[float, Interval(ge=0, lt=90)] = 30.0
    friction: NotNegative = 0.2
    factors: tuple[float, ...] = (0.4, 0.5, 2 / 3, 1.0)
    """I/(m r^2) of a solid sphere, a cylinder, a shell and a hoop: at 30 degrees and mu = 0.2 the first two roll, the others
    slip. All touch as spheres: only their inertia matters here."""


def scene(p: P) -> Scene:
    """One body for each inertia, side by side along y, at rest on ground from which gravity leans `angle` [degrees] to +x."""
    lean = math.radians(p.angle)
    bodies = [
        Body.ball(
            f"ball_{i}",
            RADIUS,
            mass=MASS,
            inertia=principal_inertia(*[k * MASS * RADIUS**2] * 3),
            material="ball",
            p_WB=(0.0, SPACING * i, RADIUS),
        )
        for i, k in enumerate(p.factors)
    ]
    return Scene(
        bodies=(Body.ground(), *bodies),
        gravity=(G * math.sin(lean), 0.0, -G * math.cos(lean)),
        surfaces=(Surface.rough(p.friction, ("ball", "ground")),),
        apart=(("ball", "ball"),),
        # The inertia is the same about every axis.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """Rolling or slipping from the start, at a constant acceleration."""
    truth, lean = Trajectory.at_rest(scene(p), time), math.radians(p.angle)
    for i, k in enumerate(p.factors, start=1):
        way, v, turned, rim = rolling(truth.time, 0.0, 0.0, p.friction, k, G * math.sin(lean), G * math.cos(lean))
        truth.p_WB[:, i, 0] = way
        truth.v_WB[:, i, 0], truth.w_WB[:, i, 1] = v, rim / RADIUS
        truth.q_WB[:, i] = about(1, turned / RADIUS)
    return truth


def _speed(dt: float, p: P) -> float:
    """The first step may pass before there is a contact: then the body slides freely for it, and grips in the next."""
    return 2 * G * math.sin(math.radians(p.angle)) * dt


CASE = Case.of(
    globals(),
    title="Rolling down an incline",
    question="Do sphere, cylinder, shell and hoop go down an incline at their own accelerations, rolling or slipping?",
    source="Meriam and Kraige, Engineering Mechanics: Dynamics, 7th ed., section 6/5",
    truth="closed form",
    converges="once",
    checks=(
        Check(
            errors.velocity_error_max,
            _speed,
            "a first step without a contact is a step without friction, g sin(angle) dt too fast at most, taken twice",
        ),
        Check(
            errors.position_error_max,
            lambda dt, p: _speed(dt, p) * DURATION,
            "the error of the speed all the way; half a step of way is less than that",
        ),
        Check(
            errors.angular_velocity_error_max,
            lambda dt, p: _speed(dt, p) / (min(p.factors) * RADIUS),
            "the rim's speed errs by 1/k of what the ball's does, the spin by 1/(k r)",
        ),
        *forces_obey_coulomb(),
    ),
    observe=(errors.position_error_final,),
)
