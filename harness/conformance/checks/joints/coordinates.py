"""Checks of what acts along a joint"s coordinate: limits, springs and drives."""

from collections.abc import Callable
from math import exp, sqrt
from typing import Any

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, check, near
from plumbline.harness.conformance.engine import Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, X, Z, aligned
from plumbline.harness.conformance.scenes import free, prismatic, revolute, without_gravity
from plumbline.harness.scene import Body, Drive, Joint, Limits, Scene, Spring, axis_angle

_FIRST = "a staggered scheme of first order is off by half a step of motion"


@check("Do limits hold on both sides, counted by the joint's own coordinate?", Feature.REVOLUTE | Feature.LIMITS)
def limits_hold(engine: Engine) -> Comparisons:
    """A hinge at coordinate .1 within [-.2, .5]: it turns .4 rad forth and .3 rad back, counted from where it stands."""
    for w, room in ((1.5, 0.4), (-1.5, -0.3)):
        pin = revolute("pin", "body", ORIGIN, Z, position=0.1, limits=Limits(lower=-0.2, upper=0.5))
        body = free("body", p=(0.5, 0.0, 0.0), v=(0.0, 0.5 * w, 0.0), w=(0.0, 0.0, w))
        run = engine.record(without_gravity(body, joints=(pin,)), 0.5, every=5)
        angle = np.arctan2(run.p_WB[:, 0, 1], run.p_WB[:, 0, 0])
        furthest = angle[int(np.argmax(angle * np.sign(room)))]
        yield near(f"furthest turn at {w} rad/s [rad]", furthest, room, 0.04, "a limit of 1/50 s compliance gives .02 rad")


@check("Is a coordinate with one limit free the other way?", Feature.REVOLUTE | Feature.PRISMATIC | Feature.LIMITS)
def one_limit_leaves_the_other_side_open(engine: Engine) -> Comparisons:
    """Two slides and two hinges, each with one limit .2 m or rad behind it, go the other way: 2.4 m or rad in .6 s."""
    t, rate = 0.6, 4.0
    bodies: list[Body] = []
    joints: list[Joint] = []
    kinds: tuple[tuple[Callable[..., Joint], float], ...] = (
        (prismatic, 1.0),
        (prismatic, -1.0),
        (revolute, 1.0),
        (revolute, -1.0),
    )
    for k, (kind, sign) in enumerate(kinds):
        along = (sign * rate, 0.0, 0.0)
        v, w = (along, ORIGIN) if kind is prismatic else (ORIGIN, along)
        body = free(f"body{k}", p=(0.0, 5.0 * k, 0.0), v=v, w=w)
        only = Limits(lower=-0.2) if sign > 0 else Limits(upper=0.2)
        bodies.append(body)
        joints.append(kind(f"joint{k}", body.name, body.p_WB, X, limits=only))
    end = engine.final(without_gravity(*bodies, joints=tuple(joints)), t)
    turned = [axis_angle(X, sign * rate * t) for sign in (1.0, -1.0)]
    because = "a damping that is on by default takes up to 20 % a second; a limit in the way, more than a metre"
    yield near("ways of two slides [m]", end.p_WB[:2, 0], (rate * t, -rate * t), 0.2 * t / 2 * rate * t, because)
    yield aligned("turns of two hinges, off [rad]", end.q_WB[2:], turned, 0.2 * t / 2 * rate * t, because)


def _slide(body: Body, **laws: Any) -> Scene:
    return without_gravity(body, joints=(prismatic("slide", body.name, ORIGIN, X, **laws),))


@check("Does a spring swing at sqrt(k/m) about its rest, and its damper damp?", Feature.PRISMATIC | Feature.SPRINGS)
def spring_frequency(engine: Engine) -> Comparisons:
    """m x'' = -k (x - rest) from x = .2 + rest, undamped and damped."""
    for c in (0.0, 4.0):
        scene = _slide(free("body", mass=2.0), position=0.5, spring=Spring(stiffness=80.0, damping=c, rest=0.3))
        run = engine.record(scene, 0.8, every=20)
        decay, omega = c / 4.0, sqrt(80.0 / 2.0 - (c / 4.0) ** 2)
        t = run.time
        x = 0.2 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
        greatest = float(np.abs(run.p_WB[:, 0, 0] - (x - 0.2)).max())
        yield near(
            f"worst distance to the closed form at damping {c} N s/m [m]", greatest, 0.0, 4e-3, f"1.3 m/s times dt: {_FIRST}"
        )


@check("Does a drive obey its PD law, its coordinate and commands?", Feature.PRISMATIC | Feature.REVOLUTE | Feature.DRIVES)
def drive_reaches_its_target(engine: Engine) -> Comparisons:
    """A critically damped drive from .1 to .5, then on command to .2; and one about an axis, right-handed."""
    drive = Drive(stiffness=200.0, damping=40.0, target=0.5)
    scene = _slide(free("body", mass=2.0), position=0.1, drive=drive)
    with engine.built(scene) as simulation:
        simulation.step(150)
        early = float(state_of(simulation, scene).p_WB[0, 0])
        simulation.step(1050)
        first = float(state_of(simulation, scene).p_WB[0, 0])
        simulation.command({"slide": 0.2})
        simulation.step(1200)
        second = float(state_of(simulation, scene).p_WB[0, 0])
    # x(t) = target - .4 (1 + 10 t) e^(-10 t)
    expected = 0.4 * (1 - (1 + 1.5) * exp(-1.5))
    pin = revolute("pin", "body", ORIGIN, Z, drive=Drive(stiffness=60.0, damping=12.0, target=0.7))
    turn = engine.final(without_gravity(free("body", moments=(0.6, 0.6, 0.6)), joints=(pin,)), 1.2)
    yield near("way after .15 s [m]", early, expected, 5e-3, "the PD law in its closed form, 2 m/s times dt")
    yield near("way when at rest [m]", first, 0.4, 2e-3, "target less position")
    yield near("way after the command to .2 [m]", second, 0.1, 2e-3, "target less position")
    yield aligned("angle of a driven hinge to .7 rad [rad]", turn.q_WB[0], axis_angle(Z, 0.7), 5e-3, "its sense too")


@check("Is a drive's force cut off at its limit in N?", Feature.PRISMATIC | Feature.DRIVES)
def drive_force_is_limited(engine: Engine) -> Comparisons:
    t = 0.5

    for sign in (1.0, -1.0):
        scene = _slide(free("body", mass=2.0), drive=Drive(stiffness=1e3, damping=1.0, target=50.0 * sign, limit=4.0))
        end = engine.final(scene, t)
        speed = 4.0 / 2.0 * t * sign
        yield near("speed under a drive cut off at 4 N [m/s]", end.v_WB[0, 0], speed, 0.02, "F t / m, 2 %")
