"""Closed loops whose joints have limits, drives and ropes: against loops without, and against one angle on its own."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline import engine
from plumbline.engine.compile.jit import entry
from plumbline.engine.constrain.principal_pivoting import Bounded, settle
from tests.four_bar import MASSES, PINS, START, G, Linkage, Pose, angles_of, coordinates_of, falls, no_torque, widest_gap
from tests.loops import bennett

TRACKS = pytest.mark.parametrize("integrator", ["rk4", "semi_implicit_euler"])
FIRST = pytest.mark.parametrize("integrator", [pytest.param("rk4", marks=pytest.mark.slow), "semi_implicit_euler"])
WIDE = engine.Limits(lower=-50.0, upper=50.0)
Floats = NDArray[np.float64]

STOPS = {
    "crank_pin": engine.Limits(upper=1.6),
    "coupler_pin": engine.Limits(lower=-2.3),
    "coupler_end": engine.Limits(lower=-0.1),
    "rocker_pin": engine.Limits(lower=-0.5),
}
"""Ranges that the fall from the start uses up within .3 s, where gravity goes on pressing; none is used up before."""


@FIRST
@pytest.mark.parametrize("last", ["revolute", "ball"])
@pytest.mark.parametrize("limited", [pytest.param(("rocker_pin",), marks=pytest.mark.slow), PINS], ids=["one", "all"])
@pytest.mark.parametrize("steps", [1500, pytest.param(5000, marks=pytest.mark.slow)])
def test_limits_that_are_never_reached_change_nothing(steps: int, limited: tuple[str, ...], last: str, integrator: str) -> None:
    """Bit for bit: their rows are held at no impulse. Crank and coupler pass through one line, five times in 1.5 s, where that
    of the rocker's limit all but follows from the others.
    """
    spring = engine.Spring(stiffness=0.3, damping=0.002, rest=-0.35)
    free = Linkage(last=last, spring=spring)
    held = replace(free, limits={pin: WIDE for pin in limited if pin != "coupler_end" or last == "revolute"})
    worlds = free.world(integrator), held.world(integrator)
    for world in worlds:
        world.step(steps)
    assert worlds[0].state().tolist() == worlds[1].state().tolist()
    assert widest_gap(worlds[1]) < 1e-9


def test_the_free_linkage_follows_one_angle_integrated_independently() -> None:
    """What the others below are measured with. Rates of 25/s at dt = 5e-4: (w dt)^4 / 120 = 2e-10 a radian, of some 20."""
    world = Linkage().world("rk4", dt=5e-4)
    world.step(1800)
    angle, _, pose = falls(0.9, no_torque, {})
    assert angles_of(world) == pytest.approx([(angle + math.pi) % (2 * math.pi) - math.pi, pose.coupler, pose.rocker], abs=1e-6)


@TRACKS
@pytest.mark.parametrize("pins", [*((pin,) for pin in PINS), ("crank_pin", "coupler_pin", "rocker_pin")], ids="-".join)
def test_a_limit_of_any_pin_stops_the_loop_where_it_is_reached(pins: tuple[str, ...], integrator: str) -> None:
    """Three at once, which all say the same, stop it as one does. One freedom: what stops one pin stops all.

    The way there: Runge-Kutta as above; semi-implicit Euler errs by half a step of its rates, 20/s * 5e-4. At rest gravity adds
    g dt^2 / l = 1e-4 in a step, which the next takes back; other pins turn by up to five times as much.
    """
    limits = {pin: STOPS[pin] for pin in pins}
    if pins[1:]:
        _, _, pose = falls(2.0, no_torque, {"crank_pin": STOPS["crank_pin"]})
        at = coordinates_of(1.6, pose)
        limits = {pin: engine.Limits(upper=at[pin]) if at[pin] > 0 else engine.Limits(lower=at[pin]) for pin in pins}
    stop, time, at_stop = falls(2.0, no_torque, limits)
    world, steps = Linkage(limits=limits).world(integrator), round(time / 1e-3) - 5
    world.step(steps)
    angle, _, pose = falls(steps * 1e-3, no_torque, limits)
    there = pytest.approx([angle, pose.coupler, pose.rocker], abs=1e-6 if integrator == "rk4" else 2e-2)
    assert angles_of(world) == there
    for _ in range(50):
        world.step(10)
        assert widest_gap(world) < 1e-9
    assert angles_of(world) == pytest.approx([stop, at_stop.coupler, at_stop.rocker], abs=5e-4)
    assert np.abs(world.state()[:, 7:]).max() < 0.05


def test_a_loop_leaves_its_limit_when_it_is_pulled_away() -> None:
    """Loads of twice its weight upwards turn gravity round: it goes from rest at the stop, known to 5e-4 rad."""
    limits = {"rocker_pin": STOPS["rocker_pin"]}
    stop, _, _ = falls(2.0, no_torque, limits)
    world = Linkage(limits=limits).world("rk4")
    world.step(1000)
    force = np.zeros((3, 3))
    force[:, 2] = 2 * G * np.array(MASSES)
    world.set_load(force, np.zeros((3, 3)))
    world.step(100)
    angle, _, _ = falls(0.1, no_torque, {}, start=stop, gravity=-G)
    assert abs(angle - stop) > 0.1
    assert angles_of(world)[0] == pytest.approx(angle, abs=5e-3)


@TRACKS
@pytest.mark.parametrize("pins", [(), PINS], ids=["free", "wide"])
def test_a_drive_in_a_loop_gives_its_limit_and_no_more(pins: tuple[str, ...], integrator: str) -> None:
    """The torque has corners where it meets its limit: dt^2 of its slope there. Semi-implicit Euler: half a step of 10/s."""
    drive = engine.Drive(stiffness=20.0, damping=0.2, target=-1.0, limit=0.15)

    def torque(angle: float, rate: float, _: Pose) -> float:
        return min(max(20.0 * (-1.0 - angle) - 0.2 * rate, -0.15), 0.15)

    world = Linkage(drive=drive, limits=dict.fromkeys(pins, WIDE)).world(integrator)
    world.step(400)
    angle, _, pose = falls(0.4, torque, {})
    assert abs(torque(angle, 0.0, pose)) == 0.15
    assert angles_of(world) == pytest.approx([angle, pose.coupler, pose.rocker], abs=1e-5 if integrator == "rk4" else 2e-2)


@FIRST
def test_a_drive_presses_a_loop_against_a_limit_of_another_pin(integrator: str) -> None:
    """It would lift the crank back to the start and beyond, but for the coupler's pin: what it cannot move it leaves."""
    drive = engine.Drive(stiffness=200.0, damping=2.0, target=-3.0, limit=5.0)
    stop = engine.Limits(upper=0.3)
    world = Linkage(drive=drive, limits={"coupler_pin": stop, "rocker_pin": WIDE, "crank_pin": WIDE}).world(integrator)
    angle, _, pose = falls(2.0, lambda *_: -5.0, {"coupler_pin": stop})
    world.step(1000)
    assert angles_of(world) == pytest.approx([angle, pose.coupler, pose.rocker], abs=5e-3)
    assert np.abs(world.state()[:, 7:]).max() < 0.1
    assert widest_gap(world) < 1e-9


@FIRST
def test_a_rope_to_a_loop_is_slack_or_stops_it(integrator: str) -> None:
    """Slack, it changes nothing but the order of the joints: round-off, 1e-15 a step. Taut, it is as long as it may be."""
    worlds = [Linkage(rope=rope).world(integrator) for rope in (None, engine.Limits(upper=9.0), engine.Limits(upper=0.56))]
    for world in worlds:
        world.step(1000)
    assert worlds[0].state() == pytest.approx(worlds[1].state(), abs=1e-9)
    middle = worlds[2].state()[1, [0, 2]]
    hook = np.add(START[1], START[2]) / 2 + (0.0, 1.5)
    assert np.linalg.norm(middle - hook) == pytest.approx(0.56, abs=5e-4)
    assert np.abs(worlds[2].state()[:, 7:]).max() < 0.05
    assert widest_gap(worlds[2]) < 1e-9


@pytest.mark.parametrize("sleeping", [False, True])
def test_limits_in_a_loop_beside_contacts_change_nothing_until_they_are_reached(sleeping: bool) -> None:
    """A ball falls on the coupler, without friction, and lies on the ground. Bit for bit; with the stop, as far as it allows:
    within what a sub-step of the fall goes, and the gaps within the way that a turn of w h leaves the tangent, (w h)^2 / 2 l.
    """
    shape = (engine.Placed(engine.Sphere(0.03)),)
    ground = engine.Body(name="ground", motion="static", shapes=(engine.Placed(engine.Plane()),))
    x, z = np.add(START[1], START[2]) / 2
    ball = engine.Body(name="ball", mass=0.1, inertia=4e-5 * np.eye(3), p_WB=(x + 0.01, 0.0, z + 1.1), shapes=shape)
    free = Linkage(beside=(ground, ball), shapes=shape)
    stop = {pin: STOPS[pin] if pin == "rocker_pin" else WIDE for pin in PINS}
    worlds = [replace(free, limits=limits).world("semi_implicit_euler", sleeping=sleeping)
              for limits in ({}, dict.fromkeys(PINS, WIDE), stop)]  # fmt: skip
    for world in worlds:
        world.step(500)
        assert widest_gap(world) < (25 * 1e-3 / 4) ** 2 / 2 * 0.3
    assert worlds[0].state().tolist() == worlds[1].state().tolist()
    for world in worlds:
        world.step(1000)
    assert worlds[2].state()[4, 2] == pytest.approx(0.03, abs=1e-4)
    assert angles_of(worlds[2])[2] == pytest.approx(-0.5, abs=2e-3)


@FIRST
def test_equal_limits_of_all_cranks_of_a_parallelogram_chain_act_as_one(integrator: str) -> None:
    """Three cranks of 1 m and a coupler, one crank too many, fall through their flat pose onto three stops at 2 rad.

    As above: g dt^2 at rest.
    """
    bodies = [engine.Body(name="coupler", p_WB=(1, 0, 1), v_WB=(1, 0, 0), inertia=0.01 * np.eye(3))]
    joints: list[engine.Joint] = []
    for k in range(3):
        name = f"crank{k}"
        bodies.append(engine.Body(name=name, p_WB=(k, 0, 0.5), v_WB=(0.5, 0, 0), w_WB=(0, 1, 0), inertia=0.01 * np.eye(3)))
        joints += [
            engine.Revolute(
                name=f"foot{k}", parent=engine.WORLD, child=name, anchor_W=(k, 0, 0), axis_W=(0, 1, 0),
                limits=engine.Limits(upper=2.0),
            ),
            engine.Revolute(
                name=f"head{k}", parent=name, child="coupler", anchor_W=(k, 0, 1), axis_W=(0, 1, 0),
                limits=engine.Limits(lower=-2.0, upper=9.0),
            ),
        ]  # fmt: skip
    world = engine.World(bodies, joints, options=engine.Options(integrator=integrator, dt=1e-3))
    world.step(2000)
    state = world.state()
    assert state[0, :7] == pytest.approx([1 + math.sin(2), 0, math.cos(2), 1, 0, 0, 0], abs=1e-4)
    assert np.abs(state[:, 7:]).max() < 0.05


@FIRST
def test_a_spatial_loop_with_constraints_too_many_has_limits_too(integrator: str) -> None:
    """Bennett's linkage: far ranges change nothing, bit for bit; a range of .2 rad of all hinges is kept, to w dt of a step."""
    worlds = [bennett(limits, integrator) for limits in (None, WIDE, engine.Limits(lower=-0.2, upper=0.2))]
    for _ in range(800):
        for world in worlds:
            world.step()
        q = worlds[2].state()[0, 3:7]
        assert 2 * math.acos(min(abs(q[0]), 1.0)) < 0.2 + 1e-3
    assert worlds[0].state().tolist() == worlds[1].state().tolist()
    assert np.abs(worlds[2].state()[:, 7:]).max() < 0.05


@entry
def _settled(matrix: Floats, asked: Floats, low: Floats, high: Floats) -> Floats:
    """Sides of rows with bounds."""
    side = np.zeros(len(asked))
    settle(Bounded(matrix, asked, low, high, 1e-12 * (1.0 + np.abs(asked)), side))
    return side


@pytest.mark.parametrize("draws", [500, pytest.param(2000, marks=pytest.mark.slow)])
def test_sides_found_one_by_one_are_those_of_the_problem(draws: int) -> None:
    """Rows of up to three independent directions, some of them twice and opposite, soft ones between finite bounds.

    Impulses between their bounds, and at a bound what is left presses against it: 1e-8 of numbers of order one. Hard rows of
    odd draws may contradict each other; such a row, and no other, may be left with no impulse.
    """
    rng = np.random.default_rng(0)
    unmet = 0
    for draw in range(draws):
        m, k = rng.integers(1, 6), rng.integers(1, 4)
        J = np.round(rng.normal(size=(m, k))) if draw % 4 < 2 else rng.normal(size=(m, k))
        hard = rng.random(m) < 0.6
        S = J @ J.T + np.diag(np.where(hard, 0.0, rng.uniform(0.1, 1.0, m)))
        low, high = np.where(hard, 0.0, -rng.random(m)), np.where(hard, np.inf, rng.random(m))
        meant = J @ rng.normal(size=k) - hard * rng.random(m) * (rng.random(m) < 0.7)
        asked = rng.normal(size=m) if draw % 2 else np.where(hard, meant, rng.normal(size=m))
        asked[(np.diag(S) == 0) & (draw % 2 == 0)] = -0.1
        side = _settled(S, asked, low, high)
        free = side == 0
        impulse = np.select([side < 0, side > 0], [low, high], 0.0)
        rest = asked[free] - S[np.ix_(free, ~free)] @ impulse[~free]
        impulse[free] = np.linalg.lstsq(S[np.ix_(free, free)], rest, rcond=1e-11)[0]
        left = asked - S @ impulse
        vain = hard & (impulse == 0.0) & (left > 1e-8)
        unmet += int(vain.any())
        assert draw % 2 or not vain.any()
        assert (impulse >= low - 1e-8).all()
        assert (impulse <= high + 1e-8).all()
        assert (np.abs(left[free & ~vain]) < 1e-8).all()
        assert (left[(side < 0) & ~vain] < 1e-8).all()
        assert (left[side > 0] > -1e-8).all()
    assert unmet > 0
