"""Checks of kinematic bodies whose motion is a law of time: where they are, and what they do to what they touch and carry."""

import math
from collections.abc import Callable

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.case.commands import acting
from plumbline.harness.case.forces import Controlled
from plumbline.harness.conformance.check import Comparisons, check, firm, near
from plumbline.harness.conformance.engine import COARSE, FINE, ROUNDING, Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, TURNED, X, Y, Z, aligned
from plumbline.harness.conformance.scenes import G, ball, block, free, ground, prismatic, shaped, without_gravity
from plumbline.harness.scene import Body, Box, Prescribed, Samples, Scene, Shift, Sinusoid, Turn, Vector3, axis_angle, rotate
from plumbline.harness.trajectory import State

_SOFT = 0.02
"""The time constant [s] of contacts that give way, by default in MuJoCo: what friction accelerates at a lags by a times it."""


def _led(engine: Engine, scene: Scene, steps: int, dt: float = FINE) -> State:
    """The state after some steps, all bodies led as the scene says."""
    with engine.built(scene, dt) as simulation:
        control = acting(scene)
        assert control is not None
        Controlled(simulation, control, dt, len(scene.bodies)).step(steps)
        return state_of(simulation, scene)


def _moved(name: str, half: Vector3, law: Prescribed, p: Vector3 = ORIGIN) -> Body:
    """A box of half extents `half` [m] that is moved by a law."""
    return shaped(name, Box(half_extents=half), motion="kinematic", material="ground", p_WB=p, prescribed=law)


def _sampled(law: Callable[[float], float], steps: int, dt: float) -> Samples:
    """A law of time at whole steps, so that what is between them is not asked."""
    times = tuple(dt * k for k in range(steps + 1))
    return Samples(time=times, target=tuple(law(t) for t in times))


@firm(
    "Is a body whose motion is prescribed where the law has it, at every step and in every direction?",
    Feature.PRESCRIBED_MOTION,
)
def prescribed_motion_is_where_its_law_has_it(engine: Engine) -> Comparisons:
    """A table shaken along two directions while it is carried on, and an arm that swings about an axis beside it."""
    table = Prescribed(
        shifts=(
            Shift(axis_W=(0.6, 0.0, 0.8), motion=Sinusoid(amplitude=0.3, frequency=1.3, phase=0.4)),
            Shift(axis_W=Y, motion=Samples(time=(0.0, 0.2, 1.0), target=(0.1, 0.5, -0.3))),
        )
    )
    arm = Prescribed(
        turn=Turn(anchor_W=(0.0, 3.0, 0.0), axis_W=(1 / 3, 2 / 3, 2 / 3), motion=Sinusoid(amplitude=1.2, frequency=0.7))
    )
    bodies = (
        Body(name="table", motion="kinematic", q_WB=TURNED, v_WB=(0.0, 0.0, -0.5), prescribed=table),
        Body(name="arm", motion="kinematic", p_WB=(1.0, 3.0, 0.0), q_WB=TURNED, prescribed=arm),
        free("bystander", p=(0.0, -3.0, 0.0)),
    )
    steps = 144
    end = _led(engine, without_gravity(*bodies), steps, COARSE)

    for k, (body, law) in enumerate(zip(bodies[:2], (table, arm), strict=True)):
        p, q = law.pose(body.p_WB, body.q_WB, body.v_WB, steps * COARSE)
        v, w = law.velocity(body.p_WB, body.q_WB, body.v_WB, (steps - 1) * COARSE, COARSE)
        yield near(f"p_WB of the {body.name} [m]", end.p_WB[k], p, ROUNDING, "the law at this time")
        yield aligned(f"angle to the {body.name}'s turn [rad]", end.q_WB[k], np.array(q), ROUNDING)
        yield near(f"v_WB of the {body.name} [m/s]", end.v_WB[k], v, ROUNDING / COARSE, "the last step's way over dt")
        yield near(f"w_WB of the {body.name} [rad/s]", end.w_WB[k], w, ROUNDING / COARSE, "the last step's turn over dt")
    yield near("p_WB of a bystander [m]", end.p_WB[2], bodies[2].p_WB, ROUNDING, "nothing moves it")


@check(
    "Does friction feel the velocity of a body that is moved: does a box stick below mu g and slip at mu g above?",
    Feature.PRESCRIBED_MOTION | Feature.BOX,
)
def prescribed_plate_takes_along_what_friction_can(engine: Engine) -> Comparisons:
    """A plate accelerated at half and at twice mu g: a box stays where it lies on it, or is left behind at mu g."""
    mu, steps = 0.5, 400

    for share in (0.5, 2.0):
        a = share * mu * G
        law = Prescribed(shifts=(Shift(axis_W=X, motion=_sampled(lambda t, a=a: a * t * t / 2, steps, FINE)),))  # type: ignore[misc]
        plate = _moved("plate", (2.0, 1.0, 0.1), law, (0.0, 0.0, -0.1))
        end = _led(engine, Scene(bodies=(plate, block("box")), surfaces=(ground(mu),)), steps)
        t, gained = steps * FINE, min(a, mu * G)
        because = "it goes with the plate" if share < 1 else "mu g t^2 / 2"
        lag = _SOFT * gained
        due, because = gained * t * t / 2, f"{because}; what is soft lags"
        yield near(f"way of the box at {share:g} mu g [m]", end.p_WB[1, 0], due, lag * t, because)
        yield near(f"velocity of the box at {share:g} mu g [m/s]", end.v_WB[1, 0], gained * t, lag, "the same")


@check(
    "Does a platform that is moved hand its velocity to what it meets, and does nothing stop it?",
    Feature.PRESCRIBED_MOTION | Feature.BOX | Feature.SPHERE,
)
def prescribed_platform_lifts_what_it_meets(engine: Engine) -> Comparisons:
    """A platform that rises at 1 m/s meets a ball that is let go .2 m above it, and lifts it at its own speed."""
    speed, gap, steps = 1.0, 0.2, 500
    law = Prescribed(shifts=(Shift(axis_W=Z, motion=Samples(time=(0.0, 10.0), target=(0.0, 10.0 * speed))),))
    platform = _moved("platform", (0.5, 0.5, 0.1), law)
    load = ball("load", radius=0.1, mass=3.0, p=(0.0, 0.0, 0.1 + gap + 0.1))
    end = _led(engine, Scene(bodies=(platform, load), surfaces=(ground(0.0),)), steps)
    height = 0.1 + 0.1 + speed * steps * FINE
    because = "it lies on the platform; what is soft gives way by g times the square of its time constant"
    yield near("height of the load [m]", end.p_WB[1, 2], height, G * _SOFT**2, because)
    because = "that of the platform, once a soft blow is over"
    yield near("velocity of the load [m/s]", end.v_WB[1, 2], speed, 0.02 * speed, because)
    yield near("height of the platform [m]", end.p_WB[0, 2], speed * steps * FINE, ROUNDING, "the blow does nothing to it")


@check(
    "Does contact meet a turning body at the velocity of its surface?", Feature.PRESCRIBED_MOTION | Feature.BOX | Feature.SPHERE
)
def prescribed_paddle_sweeps_a_ball_outwards(engine: Engine) -> Comparisons:
    """A paddle that turns at 2 rad/s about its end meets a ball at rest, which then slides out along it without friction.

    Equation: in the paddle's frame x'' = w^2 x with y = c, the sum of half widths, so x = x0 cosh(w t) + c sinh(w t) from the
    instant at which the ball lies c in front of it; the blow takes y' and leaves x' = w c.
    """
    w, half, radius, steps = 2.0, 0.05, 0.1, 400
    c, start = half + radius, (0.6, 0.25)
    far = math.hypot(*start)
    met = (math.atan2(start[1], start[0]) - math.asin(c / far)) / w
    law = Prescribed(turn=Turn(anchor_W=ORIGIN, axis_W=Z, motion=Samples(time=(0.0, 10.0), target=(0.0, 10.0 * w))))
    load = ball("load", radius=radius, p=(*start, 0.0))
    scene = without_gravity(_moved("paddle", (1.0, half, 0.3), law, X), load, surfaces=(ground(0.0),))
    end = _led(engine, scene, steps)
    t = steps * FINE - met
    out = math.sqrt(far**2 - c**2) * math.cosh(w * t) + c * math.sinh(w * t)
    x, y, _ = rotate(axis_angle(Z, w * steps * FINE), (out, c, 0.0))
    because = f"met after {met:.3g} s, then along the paddle; a soft contact gives way for its time constant"
    # It is met at w times its distance, and thrown back by .14 of that at most where a critically damped contact cannot pull.
    yield near("p_WB of the ball [m]", end.p_WB[1, :2], (x, y), w * far * _SOFT, because)


@check("Does what is joined to a moved body follow by its joint alone?", Feature.PRESCRIBED_MOTION | Feature.PRISMATIC)
def prescribed_frame_leaves_behind_what_slides(engine: Engine) -> Comparisons:
    """A frame shaken along a slide that nothing holds: what is on the slide keeps its place in W, and goes along across it."""
    along = Shift(axis_W=X, motion=Sinusoid(amplitude=0.2, frequency=2.0))
    across = Shift(axis_W=Y, motion=Sinusoid(amplitude=0.1, frequency=1.0))
    frame = Body(name="frame", motion="kinematic", prescribed=Prescribed(shifts=(along, across)))
    # Across the slide it begins as fast as the frame does.
    slider = free("slider", mass=0.7, p=(0.3, 0.0, 0.0), v=(0.0, 0.2 * math.pi, 0.0))
    slide = prismatic("slide", "slider", ORIGIN, X, parent="frame")
    steps = 190
    end = _led(engine, without_gravity(frame, slider, joints=(slide,)), steps)
    side = 0.1 * math.sin(2 * math.pi * steps * FINE)
    # What a position error of 1e-6 m a step, which solvers of joints leave, may become.
    yield near("p_WB of what slides [m]", end.p_WB[1], (0.3, side, 0.0), 1e-4, "no force along the slide")
    yield near("p_WB of the frame [m]", end.p_WB[0, 0], 0.2 * math.sin(4 * math.pi * steps * FINE), ROUNDING, "its law")
