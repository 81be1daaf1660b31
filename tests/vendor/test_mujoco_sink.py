"""How far a body sinks that is set down on MuJoCo's ground, told in MuJoCo's own words.

A contact is a spring and damper of the time constant T that `solref` says, 0.02 s by default, whatever the step: a_ref =
-b v - k r with b = 2/(d T), k = d/(d T)^2, and the acceleration is (1 - d) of the free one and d of a_ref, with d of `solimp`.
Source: MuJoCo, "Computation", constraint model; "Modeling", solver parameters.
"""

import math

import pytest

from tests.vendor.mujoco_world import G, load, mujoco

pytestmark = pytest.mark.mujoco

RADIUS, CONSTANT = 0.1, 0.02


def sinks(dt: float, impedance: float | None = None, seconds: float = 1.0) -> list[float]:
    """How deep [m] a ball set down on a plane stands after each step; None: the vendor's own impedance."""
    solimp = "" if impedance is None else f'solimp="{impedance} {impedance} 0.001 0.5 2"'
    ball = f'<geom type="sphere" size="{RADIUS}" {solimp}/>'
    world = f'<geom type="plane" size="0 0 1" {solimp}/><body pos="0 0 {RADIUS}"><freejoint/>{ball}</body>'
    model, data = load(world, dt)
    depths = []
    for _ in range(round(seconds / dt)):
        mujoco.mj_step(model, data)
        depths.append(RADIUS - float(data.qpos[2]))
    return depths


@pytest.mark.parametrize("dt", [1 / 240, 1 / 480, 1 / 960, 1 / 1920])
def test_a_ball_set_down_sinks_by_what_one_step_of_fall_makes_of_the_time_constant(dt: float) -> None:
    """The first step gives it g dt, which a critically damped spring stops after g dt T/e: of first order in the step."""
    # At an impedance of nearly 1 the weight adds 1e-4 g T^2 = 0.4 um; Euler's method errs by half a step of T, dt/(2 T).
    assert max(sinks(dt, 0.9999)) == pytest.approx(G * dt * CONSTANT / math.e, rel=0.02 + dt / (2 * CONSTANT))


def test_the_weight_stays_as_deep_at_any_step() -> None:
    """At rest (1 - d) g = d k r: r = (1 - d) g T^2, with d the impedance that is asked for throughout."""
    for dt in (1 / 240, 1 / 1920):
        assert sinks(dt, 0.5)[-1] == pytest.approx((1 - 0.5) * G * CONSTANT**2, rel=1e-3)


def test_by_default_a_ball_set_down_sinks_less_than_half_a_millimetre() -> None:
    """0.3 mm at 1/240 s: beyond the 0.17 mm of a body that is stopped a step after it began to fall, and no more than that."""
    assert G / 240**2 < max(sinks(1 / 240)) < 5e-4
