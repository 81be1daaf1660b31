"""Event-driven motion: closed forms of bounces, collisions, sliding and rest; conservation; time reversal.

`tests.event_driven` takes exact parabolas between impacts; worlds that are swept from impact to impact are held to it.
"""

import math

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.describe.errors import NotSupported
from tests.event_driven import FlyingSphere, ImpactLaw, Wall, solve_events

G = 9.81
FLOOR = [Wall()]
ELASTIC = ImpactLaw(restitution=1.0)
ROUND = 1e-13
"""Some hundred roundings of 2e-16, in units of the quantity."""


def _ball(position: tuple[float, float, float], velocity: tuple[float, float, float] = (0, 0, 0), **how: float) -> FlyingSphere:
    return FlyingSphere(position=position, velocity=velocity, **{"mass": 1.0, "radius": 0.1, **how})


def test_a_thrown_sphere_follows_its_parabola() -> None:
    time = np.linspace(0.0, 2.0, 9)
    motion = solve_events([_ball((0, 0, 50), (3, -1, 2))], FLOOR, time)
    assert motion.position[:, 0] == pytest.approx(
        np.stack([3 * time, -time, 50 + 2 * time - G / 2 * time**2], axis=1), abs=50 * ROUND
    )
    assert motion.events == ()


@pytest.mark.parametrize("restitution", [0.5, 0.8, 0.9])
def test_every_bounce_and_the_time_of_rest_are_those_of_the_geometric_series(restitution: float) -> None:
    """From 1 m: t_n = t_0 (1 + 2 (e + ... + e^n)), rest at t_0 (1 + e) / (1 - e); each sum of n flights rounds n times."""
    motion = solve_events([_ball((0, 0, 1.1))], FLOOR, [10.0], on_walls=ImpactLaw(restitution=restitution))
    hits = np.array([e.time for e in motion.events if e.kind == "impact"])
    first = math.sqrt(2 / G)
    n = np.arange(len(hits))
    expected = first * (1 + 2 * restitution * (1 - restitution**n) / (1 - restitution))
    assert hits == pytest.approx(expected, abs=len(hits) * 10 * ROUND)
    (rest,) = [e.time for e in motion.events if e.kind == "rest"]
    assert rest == pytest.approx(first * (1 + restitution) / (1 - restitution), abs=len(hits) * 10 * ROUND)
    assert motion.position[-1, 0, 2] == pytest.approx(0.1, abs=1e-12)
    assert not motion.velocity[-1, 0, 2]


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 7.0, 1e3])
@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_a_head_on_collision_gives_the_textbook_velocities(ratio: float, restitution: float) -> None:
    one, two = _ball((0, 0, 0), (2, 0, 0)), _ball((1, 0, 0), (-1, 0, 0), mass=ratio)
    motion = solve_events([one, two], [], [1.0], (0, 0, 0), between_spheres=ImpactLaw(restitution=restitution))
    mean = (2 - ratio) / (1 + ratio)
    assert motion.events[0].time == pytest.approx(0.8 / 3, rel=ROUND)
    assert motion.velocity[-1, 0, 0] == pytest.approx(mean - 3 * restitution * ratio / (1 + ratio), abs=10 * ROUND)
    assert motion.velocity[-1, 1, 0] == pytest.approx(mean + 3 * restitution / (1 + ratio), abs=10 * ROUND)


def test_of_two_cradle_balls_the_struck_one_takes_all_the_speed() -> None:
    motion = solve_events([_ball((0, 0, 0), (1, 0, 0)), _ball((0.5, 0, 0))], [], [1.0], (0, 0, 0), between_spheres=ELASTIC)
    assert motion.velocity[-1, :, 0] == pytest.approx([0.0, 1.0], abs=ROUND)


def test_a_row_of_touching_balls_sends_its_last_one_off() -> None:
    row = [_ball((0, 0, 0), (1, 0, 0)), *[_ball((0.5 + 0.2 * i, 0, 0)) for i in range(4)]]
    motion = solve_events(row, [], [1.0], (0, 0, 0), between_spheres=ELASTIC)
    assert motion.velocity[-1, :, 0] == pytest.approx([0, 0, 0, 0, 1], abs=ROUND)


def test_an_oblique_elastic_collision_of_unequal_masses_turns_the_relative_velocity_about_the_line_of_centres() -> None:
    """u' = u - 2 (u . n) n with n at the moment of touching, shared in the ratio of the masses."""
    one, two = _ball((0, 0, 0), (2.0, 0.1, -0.2)), _ball((1, 0.12, 0.05), mass=5.0)
    motion = solve_events([one, two], [], [1.0], (0, 0, 0), between_spheres=ELASTIC)
    t = motion.events[0].time
    u = np.array(one.velocity)
    apart = np.array(two.position) - u * t
    assert np.linalg.norm(apart) == pytest.approx(0.2, rel=ROUND)
    n = apart / np.linalg.norm(apart)
    change = 2 * 5 / 6 * (u @ n) * n
    assert motion.velocity[-1] == pytest.approx(np.stack([u - change, change / 5]), abs=10 * ROUND)


def _gas(seed: int) -> list[FlyingSphere]:
    rng = np.random.default_rng(seed)
    places = [(x, y, z) for x in (0.3, 0.7) for y in (0.3, 0.7) for z in (0.3, 0.7)]
    return [_ball(p, tuple(rng.normal(size=3)), mass=float(rng.uniform(0.5, 3)), radius=0.1) for p in places]


BOX = [Wall(point=(c, c, c), normal=tuple(s * np.eye(3)[k])) for c, s in ((0.0, 1.0), (1.0, -1.0)) for k in range(3)]


def test_elastic_spheres_without_walls_keep_momentum_and_energy() -> None:
    gas = _gas(3)
    motion = solve_events(gas, [], np.linspace(0, 5, 50), (0, 0, 0), between_spheres=ELASTIC)
    m = np.array([s.mass for s in gas])
    assert len(motion.events) >= 1
    momentum, energy = np.einsum("i,tij->tj", m, motion.velocity), 0.5 * np.einsum("i,tij->t", m, motion.velocity**2)
    assert momentum == pytest.approx(np.broadcast_to(momentum[0], momentum.shape), abs=ROUND * np.abs(momentum).max() * 10)
    assert energy == pytest.approx(energy[0], rel=ROUND)


def test_a_billiard_run_backwards_comes_back() -> None:
    """A collision between spheres stretches an error by about twice its free path over the radius, here 6; 14 events, and
    1e-16 each, stay far below 1e-6; a wrong impact would be off by the size of the box."""
    gas = _gas(5)
    time = [0.8]
    there = solve_events(gas, BOX, time, (0, 0, 0), between_spheres=ELASTIC, on_walls=ELASTIC)
    turned = [
        _ball(tuple(p), tuple(-v), mass=s.mass) for s, p, v in zip(gas, there.position[-1], there.velocity[-1], strict=True)
    ]
    back = solve_events(turned, BOX, time, (0, 0, 0), between_spheres=ELASTIC, on_walls=ELASTIC)
    assert len(back.events) == len(there.events) >= 10
    assert any(e.other < 8 for e in there.events)
    assert back.position[-1] == pytest.approx(np.array([s.position for s in gas]), abs=1e-6)


@pytest.mark.parametrize("seed", [3, 5, 8])
def test_a_world_swept_from_impact_to_impact_moves_as_exact_events_say(seed: int) -> None:
    """Spheres among walls, without gravity: the time of a gap that closes evenly is exact to rounding, and so is its blow.

    Six events stretch roundings of 1e-16 by about six times each, to 1e-11 at worst; a blow at the wrong instant or along the
    wrong normal would be off by far more.
    """
    gas = _gas(seed)
    end = min((e.time for e in solve_events(gas, BOX, [0.8], (0, 0, 0), ELASTIC, ELASTIC).events[6:7]), default=0.8)
    steps = round(end * 240)
    due = solve_events(gas, BOX, [steps / 240], (0, 0, 0), ELASTIC, ELASTIC)
    bodies = [
        engine.Body(name=f"wall{k}", motion="static", p_WB=w.point, shapes=[engine.Placed(engine.Plane(w.normal))])
        for k, w in enumerate(BOX)
    ]
    for k, s in enumerate(gas):
        shape, inertia = engine.Placed(engine.Sphere(s.radius)), s.inertia * s.mass * s.radius**2 * np.eye(3)
        bodies.append(engine.Body(name=f"s{k}", mass=s.mass, inertia=inertia, shapes=[shape], p_WB=s.position, v_WB=s.velocity))
    law = {("default", "default"): engine.Surface(restitution=1.0)}
    options = engine.Options(dt=1 / 240, continuous="swept")
    world = engine.World(bodies, surfaces=law, gravity=(0, 0, 0), options=options)
    world.step(steps)
    assert world.impacts is not None
    assert world.impacts.count == len(due.events)
    assert world.state()[6:, :3] == pytest.approx(due.position[-1], abs=1e-11)
    assert world.state()[6:, 7:10] == pytest.approx(due.velocity[-1], abs=1e-11)


def test_in_a_field_elastic_bounces_keep_the_energy() -> None:
    """Over 100 s: some 100 bounces, each with a few roundings."""
    motion = solve_events([_ball((0, 0, 1.1), (0.3, 0, 0))], FLOOR, np.linspace(0, 100, 77), on_walls=ELASTIC)
    energy = 0.5 * (motion.velocity[:, 0] ** 2).sum(axis=1) + G * motion.position[:, 0, 2]
    assert len(motion.events) > 100
    assert energy == pytest.approx(energy[0], rel=1e-12)


@pytest.mark.parametrize("friction", [0.1, 5.0])
def test_an_oblique_impact_slides_or_sticks_by_coulombs_law(friction: float) -> None:
    """v = (3, 0, -2), e = .5: the normal impulse is 3; sliding takes 3 mu, sticking leaves 5/7 of the speed, rolling."""
    law = ImpactLaw(restitution=0.5, friction=friction)
    motion = solve_events([_ball((0, 0, 1), (3, 0, -2))], FLOOR, [0.6], (0, 0, 0), on_walls=law)
    v, w = motion.velocity[-1, 0], motion.spin[-1, 0]
    along = 3 - 3 * friction if friction < 1 else 15 / 7
    assert v == pytest.approx([along, 0, 1], abs=10 * ROUND)
    assert w[1] == pytest.approx((3 - along) / 0.04, abs=1e3 * ROUND)


def test_a_sliding_sphere_rolls_after_the_time_of_coulombs_friction() -> None:
    """t = 2 v / (7 mu g), v = 5/7 v_0, x = 12 v_0^2 / (49 mu g)."""
    law, v0 = ImpactLaw(friction=0.3), 5.0
    end = 2 * v0 / (7 * 0.3 * G)
    motion = solve_events([_ball((0, 0, 0.1), (v0, 0, 0))], FLOOR, [end + 1.0], on_walls=law)
    (roll,) = [e.time for e in motion.events if e.kind == "roll"]
    assert roll == pytest.approx(end, rel=10 * ROUND)
    assert motion.velocity[-1, 0] == pytest.approx([5 / 7 * v0, 0, 0], abs=100 * ROUND)
    assert motion.position[-1, 0, 0] == pytest.approx(12 * v0**2 / (49 * 0.3 * G) + 5 / 7 * v0, rel=100 * ROUND)


def test_a_sphere_at_rest_is_hit_by_a_falling_one_at_the_root_of_a_quartic() -> None:
    """The lower one rests, so that they accelerate apart: they touch when the upper has fallen by 0.3 m."""
    motion = solve_events([_ball((0, 0, 0.1)), _ball((0, 0, 0.6))], FLOOR, [0.26], between_spheres=ELASTIC)
    hit = next(e for e in motion.events if e.kind == "impact" and e.other == 1)
    assert hit.time == pytest.approx(math.sqrt(2 * 0.3 / G), rel=ROUND)


def test_what_events_do_not_hold_is_refused() -> None:
    with pytest.raises(ValueError, match=r"spheres 0 and 1: overlap by 0\.1 m"):
        solve_events([_ball((0, 0, 1)), _ball((0.1, 0, 1))], FLOOR, [1.0])
    with pytest.raises(ValueError, match=r"sphere 0: lies 0\.05 m inside wall 0"):
        solve_events([_ball((0, 0, 0.05))], FLOOR, [1.0])
    with pytest.raises(NotSupported, match="friction on a slope"):
        solve_events([_ball((0, 0, 0.1))], FLOOR, [1.0], (1, 0, -9), on_walls=ImpactLaw(friction=0.1))
    with pytest.raises(ValueError, match=r"restitution 1\.5"):
        ImpactLaw(restitution=1.5)
