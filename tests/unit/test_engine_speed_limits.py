"""Speed limits of joints in the reference engine: kept beside stops, drives, contacts and in chains."""

import math
from typing import Any

import numpy as np
import pytest

from plumbline import engine

pytestmark = pytest.mark.usefixtures("both_coordinates")

LIMIT = 1.5
FREE = (0.0, 0.0, 0.0)


def _body(name: str, mass: float = 2.0, **state: Any) -> engine.Body:
    return engine.Body(name=name, mass=mass, inertia=0.3 * np.eye(3), **state)


def _slide(parent: str, child: str, **law: Any) -> engine.Prismatic:
    return engine.Prismatic(name=f"to {child}", parent=parent, child=child, anchor_W=FREE, axis_W=(1, 0, 0), **law)


def _force(size: float) -> engine.Drive:
    """A motor of a constant force, but for a share of 2e-6 of the rate."""
    return engine.Drive(damping=abs(size) / 5e5, target_velocity=math.copysign(1e6, size), limit=abs(size))


@pytest.mark.parametrize("threads", [1, 2])
def test_two_bodies_pushed_apart_part_by_the_limit_and_keep_their_momentum(threads: int) -> None:
    """Closed form: m_1 v_1 + m_2 v_2 = 0 and v_2 - v_1 = s, to rounding of 500 steps."""
    bodies = [_body("one"), _body("two", 3.0), _body("far", p_WB=(9.0, 9.0, 9.0))]
    joints = [_slide("one", "two", speed_limit=LIMIT, drive=_force(6.0)), _slide(engine.WORLD, "far")]
    world = engine.World(bodies, joints, gravity=FREE, options=engine.Options(threads=threads))
    world.step(500)
    assert world.state()[:2, 7] == pytest.approx([-0.6 * LIMIT, 0.4 * LIMIT], abs=1e-11)


def test_a_force_that_turns_within_a_step_never_passes_the_limit() -> None:
    """A drive so stiff that it would reverse the rate in each step, both ways: no step ends beyond."""
    drive = engine.Drive(stiffness=1e6, damping=0.0, target=0.0)
    world = engine.World(
        [_body("one", p_WB=(0.3, 0, 0))], [_slide(engine.WORLD, "one", speed_limit=LIMIT, drive=drive, position=0.3)]
    )
    fastest = 0.0
    for _ in range(300):
        world.step(1)
        fastest = max(fastest, abs(float(world.state()[0, 7])))
    assert LIMIT * (1 - 1e-9) < fastest < LIMIT * (1 + 1e-9)


def test_a_stop_holds_at_once_what_comes_at_its_limit() -> None:
    """Falling at 1.5 m/s for .4 m under a limit, then against the stop: it ends there at rest."""
    limits = engine.Limits(upper=0.4)
    joint = _slide(engine.WORLD, "one", speed_limit=LIMIT, limits=limits, drive=_force(40.0))
    world = engine.World([_body("one")], [joint], gravity=FREE)
    world.step(240)
    assert world.state()[0, 0] == pytest.approx(0.4, abs=1e-6)
    assert world.state()[0, 7] == pytest.approx(0.0, abs=1e-6)


def test_a_chain_keeps_every_limit() -> None:
    """Five links that swing down hard, each hinge at most 2 rad/s: none ever turns faster than rounding allows."""
    links = [_body(f"b{k}", p_WB=(0.2 * k + 0.1, 0, 0)) for k in range(5)]
    ends = [engine.WORLD, *(body.name for body in links)]
    joints = [
        engine.Revolute(
            name=f"j{k}", parent=ends[k], child=ends[k + 1], anchor_W=(0.2 * k, 0, 0), axis_W=(0, 1, 0), speed_limit=2.0
        )
        for k in range(5)
    ]
    world = engine.World(links, joints)
    fastest = 0.0
    for _ in range(120):
        world.step(1)
        w = world.state()[:, 11]
        fastest = max(fastest, float(np.abs(np.diff(w, prepend=0.0)).max()))
    # SHAKE closes the joints after the limits are kept: of the order of w^2 h of the sub-step, 4 x 1e-3.
    assert 1.9 < fastest < 2.02


def test_a_limit_holds_beside_contact() -> None:
    """A box pushed over the ground on a slide along it: at the limit after s/a, a = F/m - mu g."""
    ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
    box = _body("box", shapes=[engine.Placed(engine.Box((0.1, 0.1, 0.1)))], p_WB=(0, 0, 0.1))
    law = {("default", "default"): engine.Surface(static_friction=0.2, kinetic_friction=0.2)}
    joint = engine.Prismatic(
        name="rail", parent=engine.WORLD, child="box", anchor_W=(0, 0, 0.1), axis_W=(1, 0, 0), speed_limit=LIMIT,
        drive=_force(20.0),
    )  # fmt: skip
    world = engine.World([ground, box], [joint], surfaces=law)
    world.step(240)
    assert world.state()[1, 7] == pytest.approx(LIMIT, abs=1e-9)


def test_runge_kutta_is_refused_beside_a_speed_limit() -> None:
    with pytest.raises(engine.NotSupported, match="a limit of speed in a joint"):
        engine.World([_body("one")], [_slide(engine.WORLD, "one", speed_limit=1.0)], options=engine.Options(integrator="rk4"))


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan")])
def test_a_speed_limit_is_above_nothing(bad: float) -> None:
    with pytest.raises(ValueError, match="speed_limit"):
        _slide(engine.WORLD, "one", speed_limit=bad)
