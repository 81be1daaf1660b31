"""Round bodies thrown along level ground without spin: they slide, take up spin and roll on.

Slip ends at t = v0/(mu g (1 + 1/k)), for a solid sphere 2 v0/(7 mu g), and from then on v = v0/(1 + k), 5/7 v0.
"""

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import G, forces_keep_momentum, forces_obey_coulomb
from plumbline.harness.metrics import errors
from plumbline.harness.scene import Body, Effect, Scene, Surface, principal_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about
from plumbline.harness.truths.friction import rolling

DURATION = 2.0
SPEED, RADIUS, MASS, SPACING = 5.0, 0.1, 1.0, 1.0


class P(Parameters):
    speed: float = SPEED
    friction: NotNegative = 0.3
    factors: tuple[float, ...] = (0.4, 0.5, 2 / 3, 1.0)
    """I/(m r^2) of a solid sphere, a cylinder, a shell and a hoop. All touch as spheres: only their inertia matters here."""


def scene(p: P) -> Scene:
    """One body for each inertia, side by side along y, thrown along x at `speed` [m/s]."""
    bodies = [
        Body.ball(
            f"ball_{i}",
            RADIUS,
            mass=MASS,
            inertia=principal_inertia(*[k * MASS * RADIUS**2] * 3),
            material="ball",
            p_WB=(0.0, SPACING * i, RADIUS),
            v_WB=(p.speed, 0.0, 0.0),
        )
        for i, k in enumerate(p.factors)
    ]
    return Scene(
        bodies=(Body.ground(), *bodies),
        surfaces=(Surface.rough(p.friction, ("ball", "ground")),),
        apart=(("ball", "ball"),),
        # The inertia is the same about every axis.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """Sliding, then rolling."""
    truth = Trajectory.at_rest(scene(p), time)
    for i, k in enumerate(p.factors, start=1):
        way, v, turned, rim = rolling(truth.time, p.speed, 0.0, p.friction, k, 0.0, G)
        truth.p_WB[:, i, 0] = way
        truth.v_WB[:, i, 0], truth.w_WB[:, i, 1] = v, rim / RADIUS
        truth.q_WB[:, i] = about(1, turned / RADIUS)
    return truth


def _speed(dt: float, p: P) -> float:
    """The first step may pass before there is a contact to rub, and the step in which slip ends may go on rubbing."""
    return 2 * p.friction * G * dt


CASE = Case.of(
    globals(),
    title="Sliding into rolling",
    question="Does a ball thrown without spin begin to roll when and as fast as Coulomb's law says, whatever its inertia?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 38; Meriam and Kraige, Dynamics, 7th ed., section 6/5",
    truth="closed form",
    headline=errors.velocity_error_max.name,
    converges="once",
    scale=SPEED,
    checks=(
        Check(
            errors.velocity_error_final,
            lambda dt, p: _speed(dt, p) / 2,
            "what friction takes from the speed it gives to the spin, so that v0/(1 + k) comes out whenever it acts; "
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
            lambda dt, p: _speed(dt, p) / (min(p.factors) * RADIUS),
            "the rim's speed errs by 1/k of what the ball's does, the spin by 1/(k r)",
        ),
        forces_keep_momentum(),
        # The solid ball is the first to roll, after 0.49 s.
        *forces_obey_coulomb(end=0.45),
    ),
    observe=(errors.position_error_final,),
)
