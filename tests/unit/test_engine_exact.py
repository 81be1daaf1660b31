"""The exact contact solver: its certificate, hand-solved cases, an independent route, stacks and random piles."""

import math
from typing import Any

import numpy as np
import pytest

import engine
from engine.respond.exact.law import Problem
from engine.respond.exact.residual import project_coulomb, relative_residual
from engine.respond.exact.solver import Solution, solve

G, DT = 9.81, 1 / 240
DEFAULT = ("default", "default")
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
EXACT = 1e-10
"""What is called exact: round-off, 1e-16, times the largest ratio of masses, 1e4, times a hundred for sums."""


def _law(friction: float = 0.0, restitution: float = 0.0) -> engine.Surface:
    return engine.Surface(static_friction=friction, kinetic_friction=friction, restitution=restitution)


def _cube(name: str = "cube", mass: float = 1.0, half: float = 0.1, **state: Any) -> engine.Body:
    inertia = mass * (2 * half) ** 2 / 6 * np.eye(3)
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=[engine.Placed(engine.Box((half,) * 3))], **state)


def _ball(name: str = "ball", mass: float = 1.0, radius: float = 0.1, **state: Any) -> engine.Body:
    inertia = 0.4 * mass * radius**2 * np.eye(3)
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=[engine.Placed(engine.Sphere(radius))], **state)


def _world(bodies: list[engine.Body], law: engine.Surface, gravity: tuple[float, float, float] = (0, 0, -G)) -> engine.World:
    options = engine.Options(solver="exact", substeps=1)
    return engine.World([GROUND, *bodies], surfaces={DEFAULT: law}, gravity=gravity, options=options)


def _residual(world: engine.World) -> float:
    assert world.certificate is not None
    assert world.certificate.solves > 0
    return world.certificate.residual


# --- problems by hand -----------------------------------------------------------------------------


def _point(velocity: tuple[float, float, float], friction: float, mass: float = 2.0) -> Problem:
    """One mass point on the ground."""
    q = np.array([velocity])
    return Problem(np.eye(3) / mass, q, np.array([friction]), float(np.linalg.norm(q)))


def _random_problem(seed: int, bodies: int = 4, contacts: int = 6, ratio: float = 1e4) -> Problem:
    """Random contacts between random bodies and the ground, approaching; rest satisfies the law, so a solution exists."""
    rng = np.random.default_rng(seed)
    reach = np.zeros((3 * contacts, 6 * bodies))
    inverse = np.repeat(ratio ** rng.uniform(-1.0, 0.0, bodies), 6)
    for c in range(contacts):
        frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        pair = rng.permutation(bodies)[:2] if c % 2 else [c % bodies]
        for sign, b in zip((1.0, -1.0), pair, strict=False):
            arm = rng.normal(size=3)
            reach[3 * c : 3 * c + 3, 6 * b : 6 * b + 3] = sign * frame
            reach[3 * c : 3 * c + 3, 6 * b + 3 : 6 * b + 6] = sign * np.cross(arm, frame)
    q = (reach @ rng.normal(size=6 * bodies)).reshape(-1, 3)
    half = reach * np.sqrt(inverse)
    return Problem(half @ half.T, q, rng.uniform(0.1, 0.8, contacts), float(np.linalg.norm(q, axis=1).max()))


def _gauss_seidel(problem: Problem, sweeps: int) -> np.ndarray:
    """Projected block relaxation, one contact after the other: slow, and nothing in common with the solver but the law."""
    r, w = np.zeros((problem.size, 3)), problem.inverse_mass
    for _ in range(sweeps):
        for c in range(problem.size):
            own = slice(3 * c, 3 * c + 3)
            step = 1.0 / np.linalg.eigvalsh(w[own, own])[-1]
            for _ in range(20):
                u = problem.velocity[c] + w[own] @ r.ravel()
                u[0] += problem.friction[c] * math.hypot(u[1], u[2])
                r[c] = project_coulomb((r[c] - step * u)[None], problem.friction[c : c + 1])[0]
    return r


def test_the_certificate_accepts_the_impulses_that_stop_slide_and_free_a_point() -> None:
    """m = 2, mu = .5: it sticks under (m, m .4), slides with (m, m .5) and leaves without impulse; all by Coulomb's law."""
    assert relative_residual(_point((-1.0, -0.4, 0.0), 0.5), np.array([[2.0, 0.8, 0.0]])) < 1e-15
    assert relative_residual(_point((-1.0, 0.0, -3.0), 0.5), np.array([[2.0, 0.0, 1.0]])) < 1e-15
    assert relative_residual(_point((1.0, 2.0, 0.0), 0.5), np.zeros((1, 3))) == 0.0


@pytest.mark.parametrize(
    "wrong",
    [
        (2.0 + 2e-8, 0.0, 1.0),  # too hard by a part in 1e8: it would lift off
        (2.0 - 2e-8, 0.0, 1.0),  # too soft: it would sink
        (2.0, 0.0, 1.0 + 2e-8),  # outside the cone
        (2.0, 0.0, 1.0 - 2e-8),  # sliding with less than full friction
        (2.0, 2e-8, 1.0),  # friction not against the motion
        (-1e-8, 0.0, 0.0),  # a contact that pulls
        (0.0, 0.0, 0.0),
    ],
)
def test_the_certificate_sees_a_planted_wrong_impulse(wrong: tuple[float, float, float]) -> None:
    """An error of 1e-8 of the impulse is a velocity of 1e-8, a few parts in 1e9 of 3.2 m/s: far above round-off."""
    assert relative_residual(_point((-1.0, 0.0, -3.0), 0.5), np.array([wrong])) > 1e-9


def test_the_certificate_of_a_contact_without_friction_sees_a_pull_and_accepts_a_departure() -> None:
    """At rest a pull leaves |r| / m = .5 m/s of 1 m/s; a contact that separates needs no impulse."""
    held = Problem(np.eye(3) / 2.0, np.array([[0.5, 0.0, 0.0]]), np.zeros(1), 1.0)
    assert relative_residual(held, np.array([[-1.0, 0.0, 0.0]])) == pytest.approx(0.5)
    assert relative_residual(held, np.zeros((1, 3))) == 0.0
    assert relative_residual(held, np.array([[-1e-15, 0.0, 0.0]])) < 1e-14


def test_the_certificate_sees_an_error_on_the_light_one_of_two_bodies() -> None:
    """1e-7 of the light body's impulse is 1e-11 of the heavy one's, and is not hidden by it."""
    masses = np.array([1e4, 1.0])
    problem = Problem(np.diag(np.repeat(1 / masses, 3)), np.array([[-1.0, 0, 0]] * 2), np.full(2, 0.5), 1.0)
    right = np.stack([masses, [0, 0], [0, 0]], axis=1)
    assert relative_residual(problem, right) < 1e-15
    assert relative_residual(problem, right + np.array([[0, 0, 0], [1e-7, 0, 0]])) > 1e-8


def test_the_certificate_calls_impulses_that_are_not_numbers_infinitely_wrong() -> None:
    assert relative_residual(_point((-1.0, 0.0, 0.0), 0.5), np.full((1, 3), math.nan)) == math.inf


@pytest.mark.parametrize("seed", range(2))
def test_relaxation_to_convergence_finds_the_same_velocities(seed: int) -> None:
    """Six contacts with twelve or more degrees of freedom: W is regular, so velocities agree as far as relaxation got."""
    problem = _random_problem(seed, ratio=10.0)
    slow, exact = _gauss_seidel(problem, 1000), solve(problem)
    reached = relative_residual(problem, slow)
    assert exact.residual <= EXACT
    assert reached < 1e-6
    assert np.abs(problem.after(slow) - problem.after(exact.impulse)).max() < 1e3 * reached + 1e-9


@pytest.mark.parametrize("seed", range(20))
def test_random_problems_with_mass_ratios_of_1e4_are_solved_to_round_off(seed: int) -> None:
    assert solve(_random_problem(100 + seed, bodies=8, contacts=20)).residual <= EXACT


def test_a_frictionless_contact_beside_a_rough_one_gets_no_tangential_impulse() -> None:
    problem = _random_problem(7)
    friction = problem.friction.copy()
    friction[::2] = 0.0
    smooth = Problem(problem.inverse_mass, problem.velocity, friction, problem.speed)
    solution = solve(smooth)
    assert solution.residual <= EXACT
    assert not solution.impulse[::2, 1:].any()


# --- worlds ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("top", [1.0, 1000.0])
def test_a_stack_of_ten_boxes_rests_exactly_on_the_sum_of_its_weights(top: float) -> None:
    """Velocity errors are round-off times the ratio of masses; the ground carries the weight to as many digits."""
    masses = [1.0] * 9 + [top]
    world = _world([_cube(f"c{i}", m, p_WB=(0, 0, 0.1 + 0.2 * i)) for i, m in enumerate(masses)], _law(0.5))
    world.step(20)
    contacts = world.contacts()
    ground = (contacts.bodies == 0).any(axis=1)
    assert _residual(world) <= EXACT
    assert abs(contacts.force[ground, 2].sum()) == pytest.approx(sum(masses) * G, rel=1e-9)
    assert np.abs(world.state()[:, 7:]).max() < 1e-10


@pytest.mark.parametrize("seconds", [1, pytest.param(10, marks=pytest.mark.slow)])
def test_a_stack_with_a_top_a_thousand_times_heavier_does_not_sag(seconds: int) -> None:
    """Velocities err by 1e-11 of the g dt = .04 m/s that a step adds: 4e-13 m over each second, ten times over."""
    masses = [1.0] * 9 + [1000.0]
    world = _world([_cube(f"c{i}", m, p_WB=(0, 0, 0.1 + 0.2 * i)) for i, m in enumerate(masses)], _law(0.5))
    before = world.state()[:, :3].copy()
    world.step(240 * seconds)
    assert np.abs(world.state()[:, :3] - before).max() < 4e-12 * seconds
    assert _residual(world) <= EXACT


def _pile(seed: int, boxes: int) -> engine.World:
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
    return _world(bodies, _law(rng.uniform(0.2, 0.8)))


def _watched(world: engine.World, steps: int, patch: pytest.MonkeyPatch) -> list[tuple[Problem, Solution]]:
    """All problems of these steps in which anything moves, and their solutions."""
    seen = []

    def watch(problem: Problem, *args: Any, **options: Any) -> Solution:
        solution = solve(problem, *args, **options)
        if problem.speed > 0.0:
            seen.append((problem, solution))
        return solution

    patch.setattr("engine.respond.exact.steps.solve", watch)
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


def test_piles_with_mass_ratios_of_1e4_are_solved_and_certified_contact_by_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    """Certificate and law both round with W r: 1e-16 times the ratio of masses, 1e4, times a hundred for sums.

    None of these solves missed; one in fifty may, since another order of sums leads to another pile.
    """
    for seed in (1, 2):
        seen = _watched(_pile(seed, 4), 120, monkeypatch)
        assert max(problem.size for problem, _ in seen) > 8
        for problem, solution in seen:
            assert solution.residual == pytest.approx(_breach(problem, solution.impulse), rel=1e-6, abs=EXACT)
        assert sum(solution.residual > EXACT for _, solution in seen) <= len(seen) / 50


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("seed", range(20))
def test_all_of_twenty_piles_are_solved_without_a_miss(seed: int) -> None:
    """Twenty of twenty: 3000 solves, each of which depends on those before it in its pile."""
    seen = _pile(seed, 4)
    seen.step(150)
    assert _residual(seen) <= EXACT


@pytest.mark.parametrize("seed", [7, 10, 33])
def test_the_first_touches_of_piles_that_are_held_from_two_sides_are_solved(seed: int) -> None:
    """Bodies between others and a wall: gaps of some 1e-9 m that no rigid motion closes together ask who slips at 1e-8 m/s."""
    seen = _pile(seed, 4)
    seen.step(30)
    assert _residual(seen) <= EXACT


# --- motions far below the others -------------------------------------------------------------------


def _held(misfit: float) -> Problem:
    """A body on two points 1 m apart that falls at 1 m/s, where no rigid motion keeps both points by `misfit` m/s.

    Normals up, tangents along the line (x) and across it; mass and inertia one, centre between the points. Their velocities
    along the line are one and the same for a rigid body, and q asks for two.
    """
    rows = [([0, 0, 1, 0, -x, 0], [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, x]) for x in (-0.5, 0.5)]
    reach = np.array(rows, float).reshape(6, 6)
    q = np.array([[-1.0, -0.5 * misfit, 0.0], [-1.0, 0.5 * misfit, 0.0]])
    return Problem(reach @ reach.T, q, np.full(2, 0.5), 1.0)


@pytest.mark.parametrize("misfit", [1e-3, 1e-6, 1e-8, 1e-9])
def test_points_that_cannot_both_stick_slip_however_slowly(misfit: float) -> None:
    """Were both stuck, misfit / 2 would remain as a residual. Each carries half of m v; friction is full where it slips."""
    problem = _held(misfit)
    solution = solve(problem)
    slip = np.abs(problem.after(solution.impulse)[:, 1])
    assert solution.residual <= 1e-11
    assert solution.impulse[:, 0] == pytest.approx(0.5, rel=1e-9)
    assert slip.sum() == pytest.approx(misfit, rel=1e-2)
    assert np.abs(solution.impulse[slip > 0.1 * misfit, 1]) == pytest.approx(0.25, rel=1e-9)


def test_a_pushed_stack_slides_as_one_on_the_ground() -> None:
    """Gravity turned to tan = .6 under mu = .3 at the ground and .9 between the boxes: a = g (sin - .3 cos) for both."""
    bodies = [
        engine.Body(name="ground", motion="static", material="ice", shapes=[engine.Placed(engine.Plane())]),
        _cube("low", half=0.1, p_WB=(0, 0, 0.1)), _cube("high", 5.0, half=0.1, p_WB=(0, 0, 0.3)),
    ]  # fmt: skip
    angle = math.atan(0.6)
    g = (G * math.sin(angle), 0.0, -G * math.cos(angle))
    surfaces = {("default", "ice"): _law(0.3), DEFAULT: _law(0.9)}
    world = engine.World(bodies, surfaces=surfaces, gravity=g, options=engine.Options(solver="exact", substeps=1))
    world.step(24)
    assert _residual(world) <= EXACT
    assert world.state()[1:, 7] == pytest.approx((g[0] + 0.3 * g[2]) * 24 * DT, rel=1e-9)


@pytest.mark.parametrize("tangent", [0.4999, 0.5001])
def test_a_box_on_an_incline_sticks_below_the_threshold_and_slides_above_it(tangent: float) -> None:
    """mu = .5; v = max(0, g (sin - mu cos)) t."""
    angle = math.atan(tangent)
    world = _world([_cube(p_WB=(0, 0, 0.1))], _law(0.5), (G * math.sin(angle), 0, -G * math.cos(angle)))
    world.step(48)
    speed = max(0.0, G * (math.sin(angle) - 0.5 * math.cos(angle))) * 48 * DT
    assert world.state()[1, 7] == pytest.approx(speed, abs=1e-9)
    assert _residual(world) <= EXACT


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_a_falling_sphere_leaves_with_its_restitution_times_the_speed_at_impact(restitution: float) -> None:
    """No gravity, so that nothing else changes the speed; the blow falls into one step."""
    world = _world([_ball(p_WB=(0, 0, 0.15), v_WB=(0, 0, -3.0))], _law(0.0, restitution), (0, 0, 0))
    world.step(12)
    assert world.state()[1, 9] == pytest.approx(3.0 * restitution, abs=1e-12)


def test_a_sliding_sphere_ends_up_rolling_with_five_sevenths_of_its_speed() -> None:
    """Angular momentum about the contact is kept to round-off, since the sphere does not sink: v = 5/7 v_0."""
    world = _world([_ball(p_WB=(0, 0, 0.1), v_WB=(2.0, 0, 0))], _law(0.5))
    world.step(96)
    state = world.state()[1]
    assert state[7] == pytest.approx(10 / 7, rel=1e-9)
    assert state[11] == pytest.approx(state[7] / 0.1, rel=1e-9)


def test_friction_is_the_same_in_every_direction() -> None:
    """After t = .1 s the speed is v - mu g t whatever the azimuth: the cone is round to round-off."""
    for azimuth in (0.0, 0.3, 0.7, 2.0):
        way = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        world = _world([_cube(p_WB=(0, 0, 0.1), v_WB=2 * way)], _law(0.4))
        world.step(24)
        assert world.state()[1, 7:10] == pytest.approx((2.0 - 0.4 * G * 0.1) * way, abs=1e-10)


def test_a_restored_world_repeats_itself_to_the_last_bit() -> None:
    world = _world([_cube(f"c{i}", 10.0**i, p_WB=(0.02 * i, 0, 0.1 + 0.21 * i)) for i in range(3)], _law(0.5))
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
            _world([_cube(p_WB=(0, 0, 0.1))], law)
        return caught.value.what

    assert refused(engine.Surface(static_friction=0.5, kinetic_friction=0.4)) == "static friction above kinetic"
    assert refused(engine.Surface(rolling_friction=0.1)) == "rolling or torsional friction"
    with pytest.raises(ValueError, match="solver 'magic', expected one of tgs_soft, exact"):
        engine.Options(solver="magic")


# --- the adapter ----------------------------------------------------------------------------------


def _scene(**law: float) -> Any:
    from harness.scene import Body, Box, PlacedShape, Plane, Scene, Surface

    box, plane = Box(half_extents=(0.1, 0.1, 0.1)), Plane()
    cube = Body(name="cube", collision=(PlacedShape(shape=box),), p_WB=(0.0, 0.0, 0.1))
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=plane),))
    return Scene(bodies=(ground, cube), surfaces=(Surface(between=DEFAULT, **law),))


def test_the_adapter_names_the_largest_residual_in_warnings_and_resolved() -> None:
    from adapters.reference import ADAPTER
    from harness.adapter import Settings

    simulation = ADAPTER.build(_scene(static_friction=0.5, kinetic_friction=0.5), Settings(dt=DT, solver="exact"))
    assert simulation.warnings() == ()
    simulation.step(12)
    (notice,) = simulation.warnings()
    assert notice.text.startswith("exact: relative residual at most ")
    assert notice.text.endswith(" over 12 solves")
    assert simulation.resolved.solver == "exact"
    assert 0 <= simulation.resolved.options["residual"] <= EXACT


def test_the_adapter_refuses_settings_and_laws_that_the_exact_solver_would_ignore() -> None:
    from adapters.reference import ADAPTER
    from harness.adapter import Settings, SettingsError, Unsupported

    scene = _scene(static_friction=0.5, kinetic_friction=0.5)
    with pytest.raises(SettingsError, match="iterations 2"):
        ADAPTER.build(scene, Settings(solver="exact", iterations=2))
    with pytest.raises(SettingsError, match="'contact_hertz' belongs to the solver 'tgs_soft'"):
        ADAPTER.build(scene, Settings(solver="exact", options={"contact_hertz": 60.0}))
    with pytest.raises(Unsupported, match="static friction above kinetic"):
        ADAPTER.build(_scene(static_friction=0.5, kinetic_friction=0.4), Settings(solver="exact"))
