"""Checks of what acts along a joint"s coordinate: limits, springs and drives."""

from math import exp, sqrt

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Settings
from plumbline.harness.conformance.check import CheckResult, check, judge, near
from plumbline.harness.conformance.room import FINE, built, final, record, state_of
from plumbline.harness.conformance.scenes import angle_between, free
from plumbline.harness.scene import (
    WORLD,
    Body,
    Drive,
    Limits,
    Prismatic,
    Revolute,
    Scene,
    Spring,
    Vector3,
    axis_angle,
)

_NOWHERE: Vector3 = (0.0, 0.0, 0.0)
_FIRST = "a staggered scheme of first order is off by half a step of motion"


@check("Do limits hold on both sides, counted by the joint's own coordinate?", Feature.REVOLUTE | Feature.LIMITS)
def limits_hold(adapter: Adapter, settings: Settings) -> CheckResult:
    """A hinge at coordinate .1 within [-.2, .5]: it turns .4 rad forth and .3 rad back, counted from where it stands."""
    comparisons = []
    for w, room in ((1.5, 0.4), (-1.5, -0.3)):
        pin = Revolute(
            name="pin",
            parent=WORLD,
            child="body",
            anchor_W=_NOWHERE,
            axis_W=(0.0, 0.0, 1.0),
            position=0.1,
            limits=Limits(lower=-0.2, upper=0.5),
        )
        body = free("body", p=(0.5, 0.0, 0.0), v=(0.0, 0.5 * w, 0.0), w=(0.0, 0.0, w))
        run = record(adapter, Scene(bodies=(body,), joints=(pin,), gravity=_NOWHERE), settings.with_dt(FINE), 0.5, every=5)
        angle = np.arctan2(run.p_WB[:, 0, 1], run.p_WB[:, 0, 0])
        furthest = angle[int(np.argmax(angle * np.sign(room)))]
        comparisons.append(
            near(f"furthest turn at {w} rad/s [rad]", furthest, room, 0.04, "a limit of 1/50 s compliance gives .02 rad")
        )
    return judge(*comparisons)


@check(
    "Is a coordinate with one limit free the other way?",
    Feature.REVOLUTE | Feature.PRISMATIC | Feature.LIMITS,
)
def one_limit_leaves_the_other_side_open(adapter: Adapter, settings: Settings) -> CheckResult:
    """Two slides and two hinges, each with one limit .2 m or rad behind it, go the other way: 2.4 m or rad in .6 s."""
    t, rate = 0.6, 4.0
    bodies, joints = [], []
    for k, (kind, sign) in enumerate(((Prismatic, 1.0), (Prismatic, -1.0), (Revolute, 1.0), (Revolute, -1.0))):
        along = (sign * rate, 0.0, 0.0)
        v, w = (along, _NOWHERE) if kind is Prismatic else (_NOWHERE, along)
        body = free(f"body{k}", p=(0.0, 5.0 * k, 0.0), v=v, w=w)
        only = Limits(lower=-0.2) if sign > 0 else Limits(upper=0.2)
        bodies.append(body)
        joints.append(
            kind(name=f"joint{k}", parent=WORLD, child=body.name, anchor_W=body.p_WB, axis_W=(1.0, 0.0, 0.0), limits=only)
        )
    end = final(adapter, Scene(bodies=tuple(bodies), joints=tuple(joints), gravity=_NOWHERE), settings.with_dt(FINE), t)
    turns = [angle_between(end.q_WB[k], axis_angle((1.0, 0.0, 0.0), sign * rate * t)) for k, sign in ((2, 1.0), (3, -1.0))]
    because = "a damping that is on by default takes up to 20 % a second; a limit in the way, more than a metre"
    return judge(
        near("ways of two slides [m]", end.p_WB[:2, 0], (rate * t, -rate * t), 0.2 * t / 2 * rate * t, because),
        near("turns of two hinges, off [rad]", turns, (0.0, 0.0), 0.2 * t / 2 * rate * t, because),
    )


def _slide(body: Body, **extra: object) -> Scene:
    joint = Prismatic(name="slide", parent=WORLD, child=body.name, anchor_W=_NOWHERE, axis_W=(1.0, 0.0, 0.0), **extra)  # type: ignore[arg-type]
    return Scene(bodies=(body,), joints=(joint,), gravity=_NOWHERE)


@check("Does a spring swing at sqrt(k/m) about its rest, and its damper damp?", Feature.PRISMATIC | Feature.SPRINGS)
def spring_frequency(adapter: Adapter, settings: Settings) -> CheckResult:
    """m x'' = -k (x - rest) from x = .2 + rest, undamped and damped."""
    comparisons = []
    for c in (0.0, 4.0):
        scene = _slide(free("body", mass=2.0), position=0.5, spring=Spring(stiffness=80.0, damping=c, rest=0.3))
        run = record(adapter, scene, settings.with_dt(FINE), 0.8, every=20)
        decay, omega = c / 4.0, sqrt(80.0 / 2.0 - (c / 4.0) ** 2)
        t = run.time
        x = 0.2 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
        worst = float(np.abs(run.p_WB[:, 0, 0] - (x - 0.2)).max())
        comparisons.append(
            near(f"worst distance to the closed form at damping {c} N s/m [m]", worst, 0.0, 4e-3, f"1.3 m/s times dt: {_FIRST}")
        )
    return judge(*comparisons)


@check("Does a drive obey its PD law, its coordinate and commands?", Feature.PRISMATIC | Feature.REVOLUTE | Feature.DRIVES)
def drive_reaches_its_target(adapter: Adapter, settings: Settings) -> CheckResult:
    """A critically damped drive from .1 to .5, then on command to .2; and one about an axis, right-handed."""
    drive = Drive(stiffness=200.0, damping=40.0, target=0.5)
    scene = _slide(free("body", mass=2.0), position=0.1, drive=drive)
    with built(adapter, scene, settings.with_dt(FINE)) as simulation:
        simulation.step(150)
        early = float(state_of(simulation, scene).p_WB[0, 0])
        simulation.step(1050)
        first = float(state_of(simulation, scene).p_WB[0, 0])
        simulation.command({"slide": 0.2})
        simulation.step(1200)
        second = float(state_of(simulation, scene).p_WB[0, 0])
    # x(t) = target - .4 (1 + 10 t) e^(-10 t)
    expected = 0.4 * (1 - (1 + 1.5) * exp(-1.5))
    pin = Revolute(
        name="pin",
        parent=WORLD,
        child="body",
        anchor_W=_NOWHERE,
        axis_W=(0.0, 0.0, 1.0),
        drive=Drive(stiffness=60.0, damping=12.0, target=0.7),
    )
    turn = final(
        adapter,
        Scene(bodies=(free("body", moments=(0.6, 0.6, 0.6)),), joints=(pin,), gravity=_NOWHERE),
        settings.with_dt(FINE),
        1.2,
    )
    return judge(
        near("way after .15 s [m]", early, expected, 5e-3, "the PD law in its closed form, 2 m/s times dt"),
        near("way when at rest [m]", first, 0.4, 2e-3, "target less position"),
        near("way after the command to .2 [m]", second, 0.1, 2e-3, "target less position"),
        near(
            "angle of a driven hinge to .7 rad [rad]",
            angle_between(turn.q_WB[0], axis_angle((0, 0, 1), 0.7)),
            0.0,
            5e-3,
            "its sense too",
        ),
    )


@check("Is a drive's force cut off at its limit in N?", Feature.PRISMATIC | Feature.DRIVES)
def drive_force_is_limited(adapter: Adapter, settings: Settings) -> CheckResult:
    t = 0.5
    comparisons = []
    for sign in (1.0, -1.0):
        scene = _slide(free("body", mass=2.0), drive=Drive(stiffness=1e3, damping=1.0, target=50.0 * sign, limit=4.0))
        end = final(adapter, scene, settings.with_dt(FINE), t)
        speed = 4.0 / 2.0 * t * sign
        comparisons.append(near("speed under a drive cut off at 4 N [m/s]", end.v_WB[0, 0], speed, 0.02, "F t / m, 2 %"))
    return judge(*comparisons)
