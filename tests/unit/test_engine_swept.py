"""Swept continuous collision: nothing passes, nothing is deflected by what it passes."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline import engine
from tests.forks import Fork
from tests.swept_worlds import DT, SHAPES, SHEET, WALL, bullet_of, world_of

Array = NDArray[np.float64]


def _speeds() -> list[float]:
    return [1.0, 7.3, 50.0, 150.0, 500.0]


@pytest.mark.parametrize("speed", _speeds())
@pytest.mark.parametrize("continuous", ["speculative", "swept"])
def test_no_sphere_gets_through_a_thin_wall_at_any_phase(continuous: str, speed: float) -> None:
    """64 phases of the step: the wall of 1 cm stops each, at its face to the micrometre within which shapes touch."""
    ball, v = engine.Sphere(0.05), (speed, 0, 0)
    spheres = [
        bullet_of(ball, name=f"s{k}", material="sphere", p_WB=(-0.06 - speed * DT * k / 64, k, 0), v_WB=v) for k in range(64)
    ]
    wall = engine.Body(name="wall", motion="static", shapes=[engine.Placed(engine.Box((0.005, 100, 1)))])
    world = engine.World(
        [wall, *spheres], surfaces={("sphere", "default"): engine.Surface()}, gravity=(0, 0, 0), apart=[("sphere", "sphere")],
        options=engine.Options(continuous=continuous),
    )  # fmt: skip
    world.step(24 if speed > 5 else 40)
    x = world.state()[1:, 0]
    assert x.max() < -0.055 + 1e-6
    assert x.min() > -0.0551
    assert np.abs(world.state()[1:, 7]).max() < 1e-6


@pytest.mark.parametrize("barrier", [WALL, SHEET], ids=["wall", "mesh"])
@pytest.mark.parametrize("name", SHAPES)
def test_no_bullet_gets_through_at_any_attitude(name: str, barrier: engine.Body) -> None:
    """Each spins, arrives with another attitude, phase and speed, and is never found behind. A mesh is one-sided: it stops what
    comes from its outer side.
    """
    for seed in range(12):
        rng = np.random.default_rng(seed)
        speed = float(rng.choice([5.0, 40.0, 200.0, 500.0]))
        start = -0.15 - rng.uniform(0, 2) * speed * DT
        bullet = bullet_of(
            SHAPES[name], p_WB=(start, *rng.uniform(-0.3, 0.3, 2)), q_WB=rng.normal(size=4), v_WB=(speed, *rng.normal(size=2)),
            w_WB=rng.normal(size=3) * 30,
        )  # fmt: skip
        world = world_of([barrier, bullet], engine.Surface(static_friction=0.3, kinetic_friction=0.3, restitution=0.4))
        for _ in range(int(0.3 / (speed * DT)) + 12):
            world.step()
            assert world.state()[1, 0] < 0, (seed, speed)
        assert world.impacts is not None
        assert world.impacts.count > 0


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("name", SHAPES)
def test_a_bullet_never_gains_energy(name: str, restitution: float) -> None:
    """Without friction a blow gives back at most what it takes, and with e = 1 all of it: to rounding of a hundred operations a
    step, 1e-13, also where a second corner strikes within the same step. With e = 0 the bullet stays in touch and springs push
    out what it sinks in, so there the whole is judged by its start. The inertia is the same about every axis: no spin, however
    fast, makes an error of flight.
    """
    for seed in range(12):
        rng = np.random.default_rng(1000 + seed)
        speed = 10 ** rng.uniform(0.5, 2.7)
        bullet = engine.Body(
            name="bullet", inertia=2e-3 * np.eye(3), shapes=[engine.Placed(SHAPES[name])], p_WB=(-0.15 - speed * DT, 0, 0),
            q_WB=rng.normal(size=4), v_WB=(speed, *rng.normal(size=2) * speed * 0.3), w_WB=rng.normal(size=3) * 100,
        )  # fmt: skip
        world = world_of([WALL, bullet], engine.Surface(restitution=restitution))
        energy = []
        for _ in range(10):
            state = world.state()[1]
            energy.append(0.5 * state[7:10] @ state[7:10] + 1e-3 * state[10:] @ state[10:])
            world.step()
        ratio = np.divide(energy[1:], energy[0] if restitution == 0 else energy[:-1])
        assert ratio.max() < 1 + 1e-13
        assert restitution < 1 or ratio.min() > 1 - 1e-13


@pytest.mark.parametrize("spin", [30.0, 100.0, 300.0])
def test_a_spinning_blade_never_passes_a_thin_post(spin: float) -> None:
    """The tip goes up to 0.4 m x 300 rad/s / 240 Hz = 0.5 m in a step, 50 times the post. A heavy hub holds the middle, so that
    the blade is stopped: m v = J and I w = J d give the middle I w / (m d) = 4 cm/s at most.
    """
    for angle in (0.5, 1.3, 2.1):
        plate = engine.Placed(engine.Box((0.45, 0.004, 0.02)))
        blade = engine.Body(name="blade", mass=1000, inertia=np.diag([1e-3, 0.06, 0.06]), shapes=[plate], w_WB=(0, 0, spin))
        place = (0.4 * math.cos(angle), 0.4 * math.sin(angle), 0)
        post = engine.Body(name="post", motion="static", shapes=[engine.Placed(engine.Cylinder(0.005, 0.3))], p_WB=place)
        world = world_of([post, blade])
        for _ in range(40):
            world.step()
            q = world.state()[1, 3:7]
            assert 2 * math.atan2(q[3], q[0]) % (2 * math.pi) < angle
        assert abs(world.state()[1, 12]) < 1e-3 * spin


@pytest.mark.parametrize("spin", [100.0, 300.0])
def test_a_driven_blade_hits_a_small_ball_and_never_passes_it(spin: float) -> None:
    """The ball leaves along the normal with the velocity of the place that hit it, e = 1 doubles it: w d (1 + e)."""
    blade = engine.Body(
        name="blade", motion="kinematic", shapes=[engine.Placed(engine.Box((0.45, 0.004, 0.02)))], w_WB=(0, 0, spin)
    )  # fmt: skip
    ball = bullet_of(engine.Sphere(0.005), p_WB=(0.2 * math.cos(1.1), 0.2 * math.sin(1.1), 0))
    world = world_of([blade, ball], engine.Surface(restitution=1.0))
    world.step(6)
    assert world.impacts is not None
    assert world.impacts.count == 1
    # The place of impact on the face lies 9 mm behind the ball's centre, at sqrt(0.2^2 - 0.009^2) from the middle.
    assert np.linalg.norm(world.state()[1, 7:10]) == pytest.approx(2 * spin * math.sqrt(0.2**2 - 0.009**2), rel=1e-9)


@pytest.mark.parametrize("pair", [("sphere", "sphere"), ("box", "capsule"), ("hull", "cylinder")], ids="-".join)
def test_two_bodies_head_on_at_500_metres_per_second_do_not_change_places(pair: tuple[str, str]) -> None:
    """They meet at 1000 m/s, four metres in a step. Momentum is kept to rounding of 500 kg m/s; energy does not grow."""
    for phase in np.linspace(0, 1, 8, endpoint=False):
        one = bullet_of(SHAPES[pair[0]], name="one", p_WB=(-0.2 - phase * 500 * DT, 0.003, 0), v_WB=(500, 0, 0))
        two = bullet_of(SHAPES[pair[1]], name="two", p_WB=(0.2, 0, 0.004), v_WB=(-500, 0, 0))
        world = world_of([one, two], engine.Surface(restitution=0.5))
        world.step(3)
        state = world.state()
        assert state[0, 0] < state[1, 0]
        assert np.abs(state[:, 7:10].sum(axis=0)).max() < 1e-10
        assert 0.5 * (state[:, 7:10] ** 2).sum() < 250_000


def test_a_grazing_pass_is_not_deflected_where_speculation_does() -> None:
    """A ball passes an edge at 0.1 mm. Ahead of it, the plane of a contact made for the way of the whole step stands across its
    path: a ghost. Swept, nothing touches, and the velocity stays as it is to the bit.
    """
    block = engine.Body(name="block", motion="static", shapes=[engine.Placed(engine.Box((0.1, 0.1, 0.1)))])
    turned = {}
    for continuous in ("speculative", "swept"):
        ball = bullet_of(engine.Sphere(0.05), p_WB=(-0.6, 0, 0.1501), v_WB=(90.0, 0, 0))
        world = world_of([block, ball], continuous=continuous)
        world.step(6)
        turned[continuous] = world.state()[1, 7:10].copy()
    assert turned["swept"].tolist() == [90.0, 0.0, 0.0]
    assert np.abs(turned["speculative"] - (90.0, 0, 0)).max() > 1.0


def test_a_bounce_keeps_the_height_that_its_restitution_says() -> None:
    """From 1 m with e = 0.8: h_1 = e^2 h. A swept ball flies its parabola to the place and moment of impact and from there:
    100 additions, each rounded by 1e-16 of the height. The speculative way joins flights and blow by sub-steps of semi-implicit
    Euler, which err by g h dt / 2 = 2e-5 m and more.
    """
    missed = {}
    for continuous in ("speculative", "swept"):
        worst = 0.0
        for height in np.linspace(1.0, 1.02, 9):
            ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
            ball = bullet_of(engine.Sphere(0.05), p_WB=(0, 0, 0.05 + height))
            law = engine.Surface(restitution=0.8)
            world = world_of([ground, ball], law, (0, 0, -9.81), continuous=continuous, integrator="rk4")
            world.step(160)
            state = world.state()[1]
            top = state[2] - 0.05 + 0.5 * state[9] ** 2 / 9.81
            worst = max(worst, abs(top / (0.64 * height) - 1))
        missed[continuous] = worst
    assert missed["swept"] < 1e-13
    assert missed["speculative"] > 1e-5


def test_a_swept_world_repeats_itself_bit_for_bit_and_from_a_save() -> None:
    """Balls, boxes and hulls shot into each other in a box."""
    rng = np.random.default_rng(5)
    walls = [
        engine.Body(name=f"w{k}", motion="static", shapes=[engine.Placed(engine.Plane(-place))], p_WB=place)
        for k, place in enumerate(np.concatenate([np.eye(3), -np.eye(3)]))
    ]
    bodies = []
    for k, name in enumerate(("sphere", "box", "hull") * 3):
        p, v, q = rng.uniform(-0.7, 0.7, 3), rng.normal(size=3) * 40, rng.normal(size=4)
        bodies.append(bullet_of(SHAPES[name], name=f"b{k}", p_WB=p, v_WB=v, q_WB=q))
    law = engine.Surface(static_friction=0.2, kinetic_friction=0.2, restitution=0.5)
    one, two = world_of([*walls, *bodies], law), world_of([*walls, *bodies], law)
    one.step(20)
    for _ in range(20):
        two.step()
    assert one.state().tobytes() == two.state().tobytes()
    assert np.abs(one.state()[:, :3]).max() < 1.0 + 1e-9
    saved = one.save()
    one.step(10)
    later = one.state().tobytes()
    one.restore(saved)
    one.step(10)
    assert one.state().tobytes() == later


def _swarm(broad_phase: str | None) -> engine.World:
    """Twenty balls, boxes and rods that fly at a thin wall, past it and into each other, over a floor."""
    rng = np.random.default_rng(5)
    kinds = [SHAPES["sphere"], SHAPES["box"], SHAPES["capsule"]]
    bodies = [
        bullet_of(
            kinds[k % 3], f"b{k}", p_WB=(-1 + 0.1 * rng.normal(), 0.4 * (k % 5) - 0.8, 0.2 + 0.25 * (k // 5)),
            v_WB=rng.normal(size=3) * (40, 10, 10), w_WB=20 * rng.normal(size=3),
        )
        for k in range(20)
    ]  # fmt: skip
    floor = engine.Body(name="floor", motion="static", shapes=[engine.Placed(engine.Plane())])
    law = engine.Surface(static_friction=0.3, kinetic_friction=0.3, restitution=0.5)
    return world_of([floor, WALL, *bodies], law, gravity=(0, 0, -9.81), broad_phase=broad_phase)


@pytest.mark.parametrize("name", ["uniform_grid", "bvh"])
def test_pairs_found_before_each_part_of_a_step_are_those_found_in_it(name: str) -> None:
    """Bodies move between the parts of a step, so that pairs of its start would miss some: the bits end up the same."""
    one, two = _swarm("brute_force"), _swarm(name)
    one.step(60)
    two.step(60)
    assert one.impacts is not None
    assert one.impacts.count > 20
    assert np.array_equal(one.state(), two.state())
    assert one.impacts == two.impacts


def test_a_world_to_be_thrown_away_compiles_the_blow_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing strikes in the first step, and yet the next worlds shall not wait for their first impact."""
    blows: list[object] = []
    monkeypatch.setattr("plumbline.engine.swept.steps.strike", lambda *given: blows.append(given) or 0)
    world = world_of([WALL, bullet_of(SHAPES["sphere"], p_WB=(-1, 0, 0), v_WB=(1, 0, 0))])
    world.step(1)
    assert not blows
    world.compile()
    assert blows


def test_more_impacts_than_are_followed_are_said_and_nothing_passes() -> None:
    """A ball with a tenth of a millimetre of room between two walls at 500 m/s strikes 20 000 times in a step."""
    walls = [
        engine.Body(name=f"w{s}", motion="static", shapes=[engine.Placed(engine.Box((0.005, 1, 1)))], p_WB=(s * 0.05505, 0, 0))
        for s in (-1, 1)
    ]
    world = world_of([*walls, bullet_of(engine.Sphere(0.05), v_WB=(500, 0, 0))], engine.Surface(restitution=1.0))
    with pytest.warns(engine.ManyImpacts):
        world.step(3)
    assert abs(world.state()[2, 0]) < 0.003
    assert world.impacts is not None
    assert world.impacts.crowded >= 1
    assert np.linalg.norm(world.state()[2, 7:10]) < 500 * (1 + 1e-9)


def test_slow_bodies_rest_as_without_the_sweep() -> None:
    """Nothing goes a margin in a step, so no impact is looked for and the states are the same to the bit."""
    ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
    stack = [bullet_of(engine.Box((0.1, 0.1, 0.1)), name=f"c{k}", p_WB=(0, 0, 0.1 + 0.2 * k)) for k in range(3)]
    law = engine.Surface(static_friction=0.5, kinetic_friction=0.5)
    worlds = [world_of([ground, *stack], law, (0, 0, -9.81), continuous=one) for one in ("off", "swept")]
    for world in worlds:
        world.step(240)
    assert worlds[0].state().tobytes() == worlds[1].state().tobytes()
    assert worlds[1].impacts is not None
    assert worlds[1].impacts.count == 0


def test_the_forces_of_all_parts_of_a_step_add_up_to_the_change_of_momentum() -> None:
    """The step in which the ball strikes has several parts; their impulses are m (v_1 - v_0), to rounding of 80 N s."""
    world = world_of(
        [WALL, bullet_of(engine.Sphere(0.05), p_WB=(-0.2, 0, 0), v_WB=(50, 0, 0))], engine.Surface(restitution=0.6)
    )
    world.step()
    found = world.contacts()
    pushed = np.where(found.bodies[:, :1] == 1, -found.force, found.force).sum(axis=0) * DT
    assert pushed == pytest.approx([-80.0, 0, 0], abs=1e-9)


def test_joints_and_the_exact_solver_refuse_the_sweep() -> None:
    tied = engine.Ball(name="j", parent=engine.WORLD, child="bullet", anchor_W=(0, 0, 2))
    bodies = [WALL, bullet_of(engine.Sphere(0.05), p_WB=(-1, 0, 0))]
    with pytest.raises(engine.NotSupported, match="swept collision with joints"):
        engine.World(bodies, [tied], options=engine.Options(continuous="swept"))
    with pytest.raises(engine.NotSupported, match="swept collision with the exact solver"):
        engine.World(bodies, options=engine.Options(continuous="swept", solver="exact"))
    with pytest.raises(ValueError, match="options: continuous True, expected one of off, speculative, swept"):
        engine.Options(continuous=True)  # type: ignore[arg-type]


def test_scenes_without_the_sweep_never_load_it(fork: Fork) -> None:
    """Nor the second solver; the one condition on which contacts begin is part of the narrow phase."""
    code = (
        "import sys, engine; p = engine.Placed;"
        "w = engine.World([engine.Body(name='g', motion='static', shapes=[p(engine.Plane())]),"
        "engine.Body(shapes=[p(engine.Box((.1, .1, .1)))], p_WB=(0, 0, .1))]); w.step(1);"
        "loaded = [m for m in sys.modules if m.startswith('plumbline.engine.swept.') or 'sequential' in m];"
        "assert loaded == ['plumbline.engine.swept.begin'], loaded"
    )
    fork(code)


@pytest.mark.slow
@pytest.mark.parametrize("barrier", [WALL, SHEET], ids=["wall", "mesh"])
@pytest.mark.parametrize("name", SHAPES)
def test_none_of_a_thousand_bullets_gets_through(name: str, barrier: engine.Body) -> None:
    """As above, with any speed of 3 to 500 m/s, any slant, spins of 1 to 300 rad/s and any restitution."""
    for seed in range(100):
        rng = np.random.default_rng(1000 + seed)
        speed, spin = 10 ** rng.uniform(0.5, 2.7), 10 ** rng.uniform(0, 2.5)
        start = -0.15 - rng.uniform(0, 2) * speed * DT
        bullet = bullet_of(
            SHAPES[name], p_WB=(start, *rng.uniform(-0.3, 0.3, 2)), q_WB=rng.normal(size=4),
            v_WB=(speed, *rng.normal(size=2) * speed * 0.3), w_WB=rng.normal(size=3) * spin,
        )  # fmt: skip
        law = engine.Surface(static_friction=0.3, kinetic_friction=0.3, restitution=rng.uniform(0, 1))
        world = world_of([barrier, bullet], law)
        for _ in range(int(0.3 / (speed * DT)) + 12):
            world.step()
            x, y, z = world.state()[1, :3]
            assert x < 0 or max(abs(y), abs(z)) > 1, (seed, speed)
