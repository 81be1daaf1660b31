"""Checks of fine print: digits of a state, gravity to .1 %, damping of 1e-5 a second, speeds of a micrometre a second."""

import numpy as np

from plumbline.harness.conformance.check import Comparisons, NotApplicable, check, firm, near
from plumbline.harness.conformance.engine import COARSE, FINE, Engine, state_of
from plumbline.harness.conformance.frames import TURNED, aligned
from plumbline.harness.conformance.scenes import free, without_gravity
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import State

_DIGITS = 1e-12
"""Relative error of a state that went through an engine in double precision: a change of frame costs some ten roundings of
1e-16, and the centre of mass of a tree, from which velocities are carried, as many. Single precision has 6e-8."""


@firm("Does a state come back with the digits of double precision, unless the engine says that it has single?")
def states_have_double_precision(engine: Engine) -> Comparisons:
    if engine.adapter.single_precision:
        raise NotApplicable("the engine says that it computes in single precision")
    third, scale = 1.0 / 3.0, 7.0
    bodies = (
        free("a", p=(scale + third, -third, 2 * third), q=TURNED, v=(third, -scale * third, 0.1), w=(0.1, third, -0.7 * third)),
        free("b", p=(-third, 0.1, 0.7), v=(0.1, third, -third)),
    )
    scene = without_gravity(*bodies)
    with engine.built(scene, COARSE) as simulation:
        got, expected = state_of(simulation, scene), State.initial(scene)
    yield near("p_WB [m]", got.p_WB, expected.p_WB, 10 * _DIGITS, "digits of 10 m")
    yield aligned("angle to q_WB [rad]", got.q_WB, expected.q_WB, _DIGITS)
    yield near("v_WB [m/s]", got.v_WB, expected.v_WB, 10 * _DIGITS)
    yield near("w_WB [rad/s]", got.w_WB, expected.w_WB, _DIGITS)


@firm("Is gravity right to a quarter of .1 %?")
def gravity_has_three_digits(engine: Engine) -> Comparisons:
    """Four short steps: every scheme gives g t, and a vendor's damping of .04 (1 + |v|) a second takes 8e-5 of it."""
    g, t = np.array([3.0, -4.0, -8.0]), 4 * FINE
    end = engine.final(Scene(bodies=(free(),), gravity=(3.0, -4.0, -8.0)), t)
    size = float(np.linalg.norm(g)) * t
    yield near("v_WB after 4 ms of free fall [m/s]", end.v_WB[0], g * t, 2.5e-4 * size, "a quarter of .1 %")


@check("Is there no damping, not even of 1e-5 a second?")
def nothing_brakes_a_free_body(engine: Engine) -> Comparisons:
    """Without a force an engine adds zero to v, which rounds nothing in any precision; w goes through a frame and back."""
    v, w, t = np.array([3.0, -2.0, 1.0]), np.array([1.0, 2.0, -3.0]), 4.0
    scene = without_gravity(free(v=(3.0, -2.0, 1.0), w=(1.0, 2.0, -3.0)))
    end = engine.final(scene, t, COARSE)
    because = "half of what a damping of 1e-5 a second takes in 4 s"
    yield near("loss of speed in 4 s [1]", 1 - end.v_WB[0] @ v / (v @ v), 0.0, 2e-5, because)
    yield near("loss of spin in 4 s [1]", 1 - end.w_WB[0] @ w / (w @ w), 0.0, 2e-5, because)


@check("Are speeds of a micrometre a second read and kept?")
def slow_motion_is_motion(engine: Engine) -> Comparisons:
    """Speeds down to a micrometre a second come back as they were given, and go on."""
    for speed in (1e-3, 1e-6, 1e-9):
        scene = without_gravity(free(v=(speed, 0.0, 0.0), w=(0.0, 0.0, speed)))
        with engine.built(scene, COARSE) as simulation:
            first = state_of(simulation, scene)
            simulation.step(24)
            last = state_of(simulation, scene)
        # A vendor's damping of .04 a second takes .4 % in a tenth of a second.
        for when, now in (("at the start", first), ("after .1 s", last)):
            yield near(f"speed of {speed:g} m/s {when}", now.v_WB[0], (speed, 0, 0), 0.01 * speed, "1 %: kept")
            yield near(f"spin of {speed:g} rad/s {when}", now.w_WB[0], (0, 0, speed), 0.01 * speed, "1 %: kept")
        yield near(f"way at {speed:g} m/s in .1 s [m]", last.p_WB[0, 0], 0.1 * speed, 1e-3 * speed, "1 % of v t")
