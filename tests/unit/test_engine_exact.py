"""Worlds that the exact contact solver advances: stacks, random piles, slides and blows, and what is refused."""

import math
from typing import Any

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.respond.exact.law import Problem
from plumbline.engine.respond.exact.solver import Solution, solve
from tests.exact_worlds import DEFAULT, DT, EXACT, G, ball, cube, residual, surface, world_of

PATIENT = 1e6
"""An effort [ms] that all methods together do not reach."""


@pytest.mark.parametrize("top", [1.0, 1000.0])
def test_a_stack_of_ten_boxes_rests_exactly_on_the_sum_of_its_weights(top: float) -> None:
    """Velocity errors are round-off times the ratio of masses; the ground carries the weight to as many digits."""
    masses = [1.0] * 9 + [top]
    world = world_of([cube(f"c{i}", m, p_WB=(0, 0, 0.1 + 0.2 * i)) for i, m in enumerate(masses)], surface(0.5))
    world.step(20)
    contacts = world.contacts()
    ground = (contacts.bodies == 0).any(axis=1)
    assert residual(world) <= EXACT
    assert abs(contacts.force[ground, 2].sum()) == pytest.approx(sum(masses) * G, rel=1e-9)
    assert np.abs(world.state()[:, 7:]).max() < 1e-10


@pytest.mark.parametrize("seconds", [0.25, *(pytest.param(longer, marks=pytest.mark.slow) for longer in (1, 10))])
def test_a_stack_with_a_top_a_thousand_times_heavier_does_not_sag(seconds: float) -> None:
    """Velocities err by 1e-11 of the g dt = .04 m/s that a step adds: 4e-13 m over each second, ten times over."""
    masses = [1.0] * 9 + [1000.0]
    world = world_of([cube(f"c{i}", m, p_WB=(0, 0, 0.1 + 0.2 * i)) for i, m in enumerate(masses)], surface(0.5))
    before = world.state()[:, :3].copy()
    world.step(round(240 * seconds))
    assert np.abs(world.state()[:, :3] - before).max() < 4e-12 * seconds
    assert residual(world) <= EXACT


def _pile(seed: int, boxes: int, **chosen: Any) -> engine.World:
    """Boxes of all proportions with masses from 1 to 1e4 kg fall turned at random between four walls."""
    rng = np.random.default_rng(seed)
    bodies = []
    for name, normal in (("e", (1, 0, 0)), ("w", (-1, 0, 0)), ("n", (0, 1, 0)), ("s", (0, -1, 0))):
        place = tuple(-0.35 * np.array(normal))
        wall = engine.Placed(engine.Plane(normal))
        bodies.append(engine.Body(name=name, motion="static", p_WB=place, shapes=[wall]))
    for i in range(boxes):
        mass = (1.0, 1e4)[i] if i < 2 else 1e4 ** rng.uniform()
        half, turn = rng.uniform(0.06, 0.14, 3), rng.normal(size=4)
        inertia = mass / 3 * np.diag((half**2).sum() - half**2)
        shape, place = engine.Placed(engine.Box(tuple(half))), (*rng.uniform(-0.12, 0.12, 2), 0.25 + 0.22 * i)
        state: dict[str, Any] = {"p_WB": place, "q_WB": tuple(turn / np.linalg.norm(turn)), "v_WB": (0, 0, -1.0)}
        bodies.append(engine.Body(name=f"b{i}", mass=mass, inertia=inertia, shapes=[shape], **state))
    return world_of(bodies, surface(rng.uniform(0.2, 0.8)), **chosen)


def _watched(world: engine.World, steps: int, patch: pytest.MonkeyPatch) -> list[tuple[Problem, Solution]]:
    """All problems of these steps in which anything moves, and their solutions."""
    seen = []

    def watch(problem: Problem, *args: Any, **options: Any) -> Solution:
        solution = solve(problem, *args, **options)
        if problem.speed > 0.0:
            seen.append((problem, solution))
        return solution

    patch.setattr("plumbline.engine.respond.exact.steps.solve", watch)
    world.step(steps)
    return seen


def _breach(problem: Problem, impulse: np.ndarray) -> float:
    """The largest breach of Coulomb's law, contact by contact and case by case, over the speed of the problem."""
    w, worst = problem.inverse_mass, 0.0
    u = problem.velocity + (w @ impulse.ravel()).reshape(-1, 3)
    for c, mu in enumerate(problem.friction):
        m = 3.0 / np.trace(w[3 * c : 3 * c + 3, 3 * c : 3 * c + 3])
        slip = math.hypot(u[c, 1], u[c, 2])
        tried = impulse[c] - m * (u[c] + np.array([mu * slip, 0.0, 0.0]))
        pull = math.hypot(tried[1], tried[2])
        if tried[0] >= 0.0 and pull <= mu * tried[0]:
            due = tried  # it sticks
        elif mu * pull <= -tried[0]:
            due = np.zeros(3)  # it opens
        else:  # it slips: on the ray (1, mu t), t against the motion
            ray = np.array([1.0, mu * tried[1] / pull, mu * tried[2] / pull])
            due = (tried @ ray) / (ray @ ray) * ray
        worst = max(worst, float(np.linalg.norm(impulse[c] - due)) / m)
    return worst / problem.speed


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_piles_with_mass_ratios_of_1e4_are_solved_and_certified_contact_by_contact(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Certificate and law both round with W r: 1e-16 times the ratio of masses, 1e4, times a hundred for sums.

    None of these solves missed; one in fifty may, since another order of sums leads to another pile.
    """
    seen = _watched(_pile(seed, 4, effort=PATIENT), 120, monkeypatch)
    assert max(problem.size for problem, _ in seen) > 8
    for problem, solution in seen:
        assert solution.residual == pytest.approx(_breach(problem, solution.impulse), rel=1e-6, abs=EXACT)
    assert sum(solution.residual > EXACT for _, solution in seen) <= len(seen) / 50


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("seed", range(20))
def test_all_of_twenty_piles_are_solved_without_a_miss(seed: int) -> None:
    """Twenty of twenty: 3000 solves, each of which depends on those before it in its pile."""
    seen = _pile(seed, 4, effort=PATIENT)
    seen.step(150)
    assert residual(seen) <= EXACT


@pytest.mark.parametrize("seed", [7, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (10, 33))])
def test_the_first_touches_of_piles_that_are_held_from_two_sides_are_solved(seed: int) -> None:
    """Bodies between others and a wall: gaps of some 1e-9 m that no rigid motion closes together ask who slips at 1e-8 m/s."""
    seen = _pile(seed, 4, effort=PATIENT)
    seen.step(30)
    assert residual(seen) <= EXACT


def test_a_miss_is_answered_within_its_effort_counted_and_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """No residual is at most 1e-30 where anything moves, so that every solve misses: in 5 ms, 41 matrices at .12 ms or more.

    The bits are those of the same world again: matrices are counted, and no clock is looked at.
    """
    worlds = [_pile(1, 3, effort=5.0, tolerance=1e-30) for _ in range(2)]
    seen = _watched(worlds[0], 60, monkeypatch)
    assert len(seen) > 10
    assert 0 < max(solution.matrices for _, solution in seen) <= 41
    certificate = worlds[0].certificate
    assert certificate is not None
    assert certificate.missed == sum(solution.residual > 1e-30 for _, solution in seen) > 0
    assert certificate.residual == max(solution.residual for _, solution in seen)
    for _ in range(60):
        worlds[1].step()
    assert np.array_equal(worlds[0].state(), worlds[1].state())


def test_a_pushed_stack_slides_as_one_on_the_ground() -> None:
    """Gravity turned to tan = .6 under mu = .3 at the ground and .9 between the boxes: a = g (sin - .3 cos) for both."""
    bodies = [
        engine.Body(name="ground", motion="static", material="ice", shapes=[engine.Placed(engine.Plane())]),
        cube("low", half=0.1, p_WB=(0, 0, 0.1)), cube("high", 5.0, half=0.1, p_WB=(0, 0, 0.3)),
    ]  # fmt: skip
    angle = math.atan(0.6)
    g = (G * math.sin(angle), 0.0, -G * math.cos(angle))
    surfaces = {("default", "ice"): surface(0.3), DEFAULT: surface(0.9)}
    world = engine.World(bodies, surfaces=surfaces, gravity=g, options=engine.Options(solver="exact", substeps=1))
    world.step(24)
    assert residual(world) <= EXACT
    assert world.state()[1:, 7] == pytest.approx((g[0] + 0.3 * g[2]) * 24 * DT, rel=1e-9)


@pytest.mark.parametrize("tangent", [0.4999, 0.5001])
def test_a_box_on_an_incline_sticks_below_the_threshold_and_slides_above_it(tangent: float) -> None:
    """mu = .5; v = max(0, g (sin - mu cos)) t."""
    angle = math.atan(tangent)
    world = world_of([cube(p_WB=(0, 0, 0.1))], surface(0.5), (G * math.sin(angle), 0, -G * math.cos(angle)))
    world.step(48)
    speed = max(0.0, G * (math.sin(angle) - 0.5 * math.cos(angle))) * 48 * DT
    assert world.state()[1, 7] == pytest.approx(speed, abs=1e-9)
    assert residual(world) <= EXACT


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_a_falling_sphere_leaves_with_its_restitution_times_the_speed_at_impact(restitution: float) -> None:
    """No gravity, so that nothing else changes the speed; the blow falls into one step."""
    world = world_of([ball(p_WB=(0, 0, 0.15), v_WB=(0, 0, -3.0))], surface(0.0, restitution), (0, 0, 0))
    world.step(12)
    assert world.state()[1, 9] == pytest.approx(3.0 * restitution, abs=1e-12)


def test_a_sliding_sphere_ends_up_rolling_with_five_sevenths_of_its_speed() -> None:
    """Angular momentum about the contact is kept to round-off, since the sphere does not sink: v = 5/7 v_0."""
    world = world_of([ball(p_WB=(0, 0, 0.1), v_WB=(2.0, 0, 0))], surface(0.5))
    world.step(96)
    state = world.state()[1]
    assert state[7] == pytest.approx(10 / 7, rel=1e-9)
    assert state[11] == pytest.approx(state[7] / 0.1, rel=1e-9)


def test_friction_is_the_same_in_every_direction() -> None:
    """After t = .1 s the speed is v - mu g t whatever the azimuth: the cone is round to round-off."""
    for azimuth in (0.0, 0.3, 0.7, 2.0):
        way = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        world = world_of([cube(p_WB=(0, 0, 0.1), v_WB=2 * way)], surface(0.4))
        world.step(24)
        assert world.state()[1, 7:10] == pytest.approx((2.0 - 0.4 * G * 0.1) * way, abs=1e-10)


def test_a_restored_world_repeats_itself_to_the_last_bit() -> None:
    world = world_of([cube(f"c{i}", 10.0**i, p_WB=(0.02 * i, 0, 0.1 + 0.21 * i)) for i in range(3)], surface(0.5))
    world.step(20)
    saved = world.save()
    world.step(10)
    first = world.state().copy()
    world.restore(saved)
    world.step(10)
    assert np.array_equal(world.state(), first)


def test_what_the_law_does_not_hold_is_refused() -> None:
    def refused(law: engine.Surface) -> str:
        with pytest.raises(engine.NotSupported) as caught:
            world_of([cube(p_WB=(0, 0, 0.1))], law)
        return caught.value.what

    assert refused(engine.Surface(static_friction=0.5, kinetic_friction=0.4)) == "static friction above kinetic"
    assert refused(engine.Surface(rolling_friction=0.1)) == "rolling or torsional friction"
    with pytest.raises(ValueError, match="solver 'magic', expected one of tgs_soft, exact"):
        engine.Options(solver="magic")


# --- the adapter ----------------------------------------------------------------------------------


def _scene(**law: float) -> Any:
    from plumbline.harness.scene import Body, Box, PlacedShape, Plane, Scene, Surface

    box, plane = Box(half_extents=(0.1, 0.1, 0.1)), Plane()
    cube = Body(name="cube", collision=(PlacedShape(shape=box),), p_WB=(0.0, 0.0, 0.1))
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=plane),))
    return Scene(bodies=(ground, cube), surfaces=(Surface(between=DEFAULT, **law),))


def test_the_adapter_names_the_largest_residual_in_warnings_and_resolved() -> None:
    from plumbline.adapters.reference import ADAPTER
    from plumbline.harness.adapter import Settings

    simulation = ADAPTER.build(_scene(static_friction=0.5, kinetic_friction=0.5), Settings(dt=DT, solver="exact"))
    assert simulation.warnings() == ()
    simulation.step(12)
    (notice,) = simulation.warnings()
    assert notice.text.startswith("exact: relative residual at most ")
    assert notice.text.endswith(" over 12 solves")
    assert simulation.resolved.solver == "exact"
    assert 0 <= simulation.resolved.options["residual"] <= EXACT


def test_the_adapter_says_how_many_solves_missed_and_what_they_were_given() -> None:
    """A box that turns as it slides leaves round-off above 1e-30 in every step."""
    from plumbline.adapters.reference import ADAPTER
    from plumbline.harness.adapter import Settings

    scene = _scene(static_friction=0.5, kinetic_friction=0.5)
    settings = Settings(dt=DT, solver="exact", tolerance=1e-30, options={"effort": 5.0})
    simulation = ADAPTER.build(scene, settings)
    simulation.step(6)
    (notice,) = simulation.warnings()
    missed = simulation.resolved.options["missed"]
    assert 0 < missed <= 6
    assert f"{missed} of them above the tolerance 1e-30, answered by the best that 5 ms found" in notice.text


def test_the_adapter_refuses_settings_and_laws_that_the_exact_solver_would_ignore() -> None:
    from plumbline.adapters.reference import ADAPTER
    from plumbline.harness.adapter import Settings, SettingsError, Unsupported

    scene = _scene(static_friction=0.5, kinetic_friction=0.5)
    with pytest.raises(SettingsError, match="iterations 2"):
        ADAPTER.build(scene, Settings(solver="exact", iterations=2))
    with pytest.raises(SettingsError, match="'contact_hertz' belongs to the solver 'tgs_soft'"):
        ADAPTER.build(scene, Settings(solver="exact", options={"contact_hertz": 60.0}))
    with pytest.raises(SettingsError, match="'effort' belongs to the solver 'exact'"):
        ADAPTER.build(scene, Settings(options={"effort": 60.0}))
    with pytest.raises(Unsupported, match="static friction above kinetic"):
        ADAPTER.build(_scene(static_friction=0.5, kinetic_friction=0.4), Settings(solver="exact"))


def test_compiling_a_world_runs_what_its_first_contact_will(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ball high above the floor touches nothing in the step that `compile` takes, which alone would call none of these."""
    import importlib

    ran = set()

    def watched(module: str, name: str) -> None:
        place = importlib.import_module(f"plumbline.engine.respond.exact.{module}")
        entry = getattr(place, name)

        def watch(*args: Any) -> Any:
            ran.add(name)
            return entry(*args)

        monkeypatch.setattr(place, name, watch)

    entries = {
        "write_contacts": "problem",
        "write_problem": "problem",
        "give_impulses": "steps",
        "largest_breach": "law",
        "write_scaled": "law",
        "finish_from": "solver",
        "look_at": "trace",
    }
    for name, module in entries.items():
        watched(module, name)
    world = world_of([ball(p_WB=(0, 0, 5.0))], surface(0.5, 0.5))
    world.step()
    assert not ran
    world.compile()
    assert ran == set(entries)
