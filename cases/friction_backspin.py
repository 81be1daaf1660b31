"""A ball thrown along level ground with backspin: it slows, stops and comes back rolling.

v_f = (5 v0 + 2 r w0)/7 for a solid sphere, negative where the backspin wins.
"""

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import G, forces_keep_momentum, forces_obey_coulomb
from plumbline.harness.metrics import errors
from plumbline.harness.scene import Body, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about
from plumbline.harness.truths.friction import rolling

DURATION = 2.5
SPEED, RADIUS, MASS = 2.0, 0.1, 1.0
SOLID = 0.4
"""I/(m r^2) of a solid sphere."""


class P(Parameters):
    speed: float = SPEED
    spin: float = -60.0
    friction: NotNegative = 0.3


def scene(p: P) -> Scene:
    """A ball on the ground with `speed` [m/s] along x and `spin` [rad/s] about y, where speed/r would be rolling."""
    ball = Body.ball(
        "ball", RADIUS, mass=MASS, material="ball", p_WB=(0.0, 0.0, RADIUS), v_WB=(p.speed, 0.0, 0.0), w_WB=(0.0, p.spin, 0.0)
    )
    return Scene(
        bodies=(Body.ground(), ball),
        surfaces=(Surface.rough(p.friction, ("ball", "ground")),),
        # A ball's inertia is the same about every axis.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """Sliding against the ball's own spin, then rolling."""
    truth = Trajectory.at_rest(scene(p), time)
    way, v, turned, rim = rolling(truth.time, p.speed, p.spin * RADIUS, p.friction, SOLID, 0.0, G)
    truth.p_WB[:, 1, 0], truth.q_WB[:, 1] = way, about(1, turned / RADIUS)
    truth.v_WB[:, 1, 0], truth.w_WB[:, 1, 1] = v, rim / RADIUS
    return truth


def _speed(dt: float, p: P) -> float:
    """The first step may pass before there is a contact to rub, and the step in which slip ends may go on rubbing."""
    return 2 * p.friction * G * dt


CASE = Case.of(
    globals(),
    title="Backspin",
    question="Does a ball with backspin come back, and as fast as Coulomb's law says?",
    source="Meriam and Kraige, Engineering Mechanics: Dynamics, 7th ed., section 6/5: v = (5 v0 + 2 r w0)/7",
    truth="closed form",
    headline=errors.velocity_error_max.name,
    converges="once",
    scale=SPEED,
    checks=(
        Check(
            errors.velocity_error_final,
            lambda dt, p: _speed(dt, p) / 2,
            "friction exchanges speed and spin at a fixed rate, so that the final speed does not hang on when it acts; "
            "the step in which slip ends may rub on for all of its length, mu g dt",
        ),
        Check(
            errors.velocity_error_max,
            _speed,
            "a first step without a contact, and the step in which slip ends, rubbed through to its end: mu g dt each",
        ),
        Check(
            errors.position_error_max,
            lambda dt, p: _speed(dt, p) * DURATION + p.speed * dt,
            "the error of the speed all the way, and a staggered scheme's half step of way, taken twice",
        ),
        Check(
            errors.angular_velocity_error_final,
            lambda dt, p: _speed(dt, p) / (SOLID * RADIUS),
            "the rim's speed errs by 1/k of what the ball's does, the spin by 1/(k r)",
        ),
        forces_keep_momentum(),
        # It slips until 2 (v0 - r w0)/(7 mu g) = 0.78 s.
        *forces_obey_coulomb(end=0.7),
    ),
    observe=(errors.position_error_final,),
)
