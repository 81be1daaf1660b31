"""Worlds of spheres alone: contacts that stay in their rows while others come and go, and the sums of their impulses."""

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.compile.jit import jit_is_off

GRAVITY, DT = 9.81, 1 / 240
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
STEPS = 30 if jit_is_off() else 120


def ball(name: str, *place: float, v: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> engine.Body:
    """A ball of 1 kg and .1 m at a place [m] with a velocity [m/s]."""
    shapes = [engine.Placed(engine.Sphere(0.1))]
    return engine.Body(name=name, inertia=0.004 * np.eye(3), shapes=shapes, p_WB=place, v_WB=v)


def world(balls: list[engine.Body], restitution: float = 0.0) -> engine.World:
    """Balls above the ground, rough, static friction above kinetic."""
    law = engine.Surface(static_friction=0.6, kinetic_friction=0.4, restitution=restitution)
    made = engine.World([GROUND, *balls], surfaces={("default", "default"): law}, options=engine.Options(dt=DT))
    assert made.spheres
    return made


def test_contacts_that_last_do_not_depend_on_which_rows_they_stand_in() -> None:
    """A ball that is thrown up and lands stands before a bed of balls in every table, and moves all its contacts by a row.

    The bed has so many contacts that a new one does not change how often all are swept, and the ball does not reach it.
    """
    bed = [ball(f"b{i}{j}", 0.2 * i, 0.2 * j, 0.1) for i in range(5) for j in range(5)]
    hopper = ball("hopper", -3.0, 0.0, 0.13, v=(0.0, 0.0, 0.2))
    alone, beside = world(bed), world([hopper, *bed])
    rows = set()
    for _ in range(STEPS):
        alone.step()
        beside.step()
        rows.add(len(beside.contacts().gap) - len(alone.contacts().gap))
        assert beside.state()[2:].tobytes() == alone.state()[1:].tobytes()
    assert rows == {0, 1}


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_the_forces_of_a_step_are_what_changes_the_momentum(restitution: float) -> None:
    """Balls that fall, slide and strike the ground, whose normal does not turn: m (v' - v) = (m g + forces) dt, to rounding.

    Velocities are some m/s, each summed of some ten impulses a step, so 1e-13 leaves them a hundred roundings.
    """
    balls = [ball(f"b{k}", 0.5 * k, 0.0, 0.1 + 0.03 * k, v=(0.7 * k, 0.0, -0.4 * k)) for k in range(5)]
    made, struck = world(balls, restitution), 0
    for _ in range(STEPS):
        before = made.state()[1:, 7:10].copy()
        made.step()
        contacts, push = made.contacts(), np.zeros((len(balls) + 1, 3))
        np.add.at(push, contacts.bodies[:, 1], contacts.force)
        np.add.at(push, contacts.bodies[:, 0], -contacts.force)
        expected = DT * (push[1:] - np.array([0.0, 0.0, GRAVITY]))
        assert np.abs(made.state()[1:, 7:10] - before - expected).max() < 1e-13
        struck += int((np.abs(push[1:, 2]) > 10 * GRAVITY).sum())
    assert struck > 3


@pytest.mark.parametrize("relaxations", [0, 1])
def test_a_ball_on_a_steep_slope_breaks_away_and_slides_whatever_the_sweeps(relaxations: int) -> None:
    """To roll down a slope of 2 takes friction of 4/7 of the pressure, more than the static .2: it slides under the kinetic .1.

    Its speed is g (sin - .1 cos) t but for the sub-steps until it breaks away, within two of which nothing is noticed.
    """
    down, across = GRAVITY * 2 / 5**0.5, GRAVITY / 5**0.5
    slope = engine.World(
        [GROUND, ball("ball", 0.0, 0.0, 0.1)],
        surfaces={("default", "default"): engine.Surface(static_friction=0.2, kinetic_friction=0.1)},
        gravity=(down, 0.0, -across),
        options=engine.Options(dt=DT, relaxations=relaxations),
    )
    slope.step(STEPS)
    speed = (down - 0.1 * across) * STEPS * DT
    assert slope.state()[1, 7] == pytest.approx(speed, abs=0.1 * across * 2 * DT)
