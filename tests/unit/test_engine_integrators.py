"""Every integrator of free bodies: its order, what it conserves, its loads and damping, and where it refuses."""

import itertools
import math
import time

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import engine
from adapters.reference import ADAPTER
from cases.spin_asymmetric_top import CASE
from engine.build.principal_frame import principal_frame
from engine.integrate.splitting import KAHAN_LI_8, SUZUKI_4
from engine.options import FREE_INTEGRATORS, INTEGRATORS
from harness.adapter import Settings, SettingsError, Unsupported
from harness.scene import Ball, Body, PlacedShape, Plane, Scene, Sphere, Surface, principal_inertia
from harness.trajectory import Trajectory

MOMENTS = np.array([1.0, 2.0, 3.0])
SPIN = (0.5, 0.7, 1.2)
ORDERS = {
    "explicit_euler": 1,
    "semi_implicit_euler": 1,
    "velocity_verlet": 2,
    "implicit_midpoint": 2,
    "rk4": 4,
    "splitting_4": 4,
    "dormand_prince": 5,
    "splitting_8": 8,
}
SECONDS = 2.0
LADDERS = {
    1: (1024, 2048, 4096, 8192),
    2: (128, 256, 512, 1024),
    4: (32, 64, 128, 256),
    5: (8, 16, 32, 64),
    8: (4, 6, 8, 12),
}
"""Steps in SECONDS for each order: asymptotic on the coarsest rung, far above round-off on the finest."""
LOADED_LADDERS = LADDERS | {5: (16, 32, 64, 128)}
"""Where the errors of damping and torque cancel in part, order five is asymptotic later."""
KICKED = ("velocity_verlet", "implicit_midpoint", "splitting_4", "splitting_8")


def _options(integrator: str, dt: float, **more: object) -> engine.Options:
    """One step of the integrator per dt: the adaptive one is told to take whatever error that has."""
    loose = {"step_tolerance": 1e-2} if integrator == "dormand_prince" else {}
    return engine.Options(**{"dt": dt, "substeps": 1, "integrator": integrator, **loose, **more})  # type: ignore[arg-type]


def _run(
    body: engine.Body, options: engine.Options, seconds: float, gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    load: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None,
) -> np.ndarray:  # fmt: skip
    world = engine.World([body], gravity=gravity, options=options)
    if load is not None:
        world.set_load([load[0]], [load[1]])
    world.step(round(seconds / options.dt))
    return np.array(world.state()[0])


def _top(**changes: object) -> engine.Body:
    return engine.Body(**{"inertia": np.diag(MOMENTS), "w_WB": SPIN, **changes})  # type: ignore[arg-type]


def _angle(q: np.ndarray, true: np.ndarray) -> float:
    """The small angle [rad] between two attitudes."""
    return 2 * float(min(np.linalg.norm(q - true), np.linalg.norm(q + true)))


def _true_attitude(seconds: float) -> np.ndarray:
    """q_WB of the free top by elliptic functions."""
    assert CASE.expected is not None
    truth = CASE.expected(np.array([seconds]), moments=tuple(MOMENTS), spin=SPIN)
    assert isinstance(truth, Trajectory)
    return np.asarray(truth.q_WB[0, 0])


def _attitude_error(integrator: str, dt: float, seconds: float) -> float:
    end = _run(_top(), _options(integrator, dt), seconds)
    return _angle(end[3:7], _true_attitude(seconds))


def _order_and_interval(steps: tuple[int, ...], errors: list[float], floor: float) -> tuple[float, float]:
    """The order fitted on the two finest of the rungs, and the half width of its interval.

    e = C h^p (1 + a h^k + ...) gives a slope whose excess over p shrinks as h^k from one pair of rungs to the next. With k >= 1
    and rungs a factor 2 apart, or k >= 2 (symmetric methods) and sqrt 2, it at least halves, so that what remains is the
    difference of the last two slopes to leading order; twice that leaves room for the next. An error known to `floor` only
    adds floor / e on either rung, over the logarithm of their ratio.
    """
    slopes = [
        math.log(coarse / fine) / math.log(more / few)
        for (coarse, fine), (few, more) in zip(itertools.pairwise(errors), itertools.pairwise(steps), strict=True)
    ]
    return slopes[-1], 2 * abs(slopes[-1] - slopes[-2]) + 2 * floor / (errors[-1] * math.log(steps[-1] / steps[-2]))


def _assert_order(integrator: str, steps: tuple[int, ...], errors: list[float], floor: float) -> None:
    """The order of the paper lies in the fitted interval, and no other integer does."""
    order = ORDERS[integrator]
    fitted, half_width = _order_and_interval(steps, errors, floor)
    print(f"{integrator}: order {fitted:.3f} +- {half_width:.3f}, errors {errors}")
    assert half_width < 0.5
    assert abs(fitted - order) <= half_width


@pytest.mark.parametrize("integrator", ORDERS)
def test_the_free_top_turns_with_the_order_of_the_paper(integrator: str) -> None:
    """Against the closed form, known to 2e-14 rad here."""
    ladder = LADDERS[ORDERS[integrator]]
    errors = [_attitude_error(integrator, SECONDS / steps, SECONDS) for steps in ladder]
    _assert_order(integrator, ladder, errors, 2e-14)


@pytest.mark.parametrize("integrator", ORDERS)
def test_the_order_holds_under_loads_and_damping_with_a_tilted_inertia(integrator: str) -> None:
    """Force, torque, gravity, both dampings and a full inertia tensor, against DOP853 in short steps, good to 2e-14.

    200 sums of numbers up to 20 m round off by at most 200 * 20 * 1.1e-16 = 5e-13, the floor of an error.
    """
    tilt = np.linalg.qr(np.array([[1.0, 2.0, 0.5], [-1.0, 1.0, 2.0], [0.3, -1.0, 1.0]]))[0]
    inertia = tilt @ np.diag(MOMENTS) @ tilt.T
    inertia = (inertia + inertia.T) / 2
    force, torque, gravity, c, d = (1.0, -2.0, 0.5), (1.0, -2.0, 1.5), (0.0, 0.0, -9.81), 0.2, 0.1
    body = _top(mass=2.0, inertia=inertia, v_WB=(1.0, 2.0, 3.0), linear_damping=c, angular_damping=d)

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        q, v, w = y[3:7], y[7:10], y[10:]
        turn = _matrix(q)
        world_inertia = turn @ inertia @ turn.T
        spin = np.linalg.solve(world_inertia, np.array(torque) - np.cross(w, world_inertia @ w)) - d * w
        dq = 0.5 * np.array([-w @ q[1:], *(q[0] * w + np.cross(w, q[1:]))])
        return np.concatenate([v, dq, np.array(gravity) + np.array(force) / 2.0 - c * v, spin])

    start = [0, 0, 0, 1, 0, 0, 0, 1, 2, 3, *SPIN]
    true = solve_ivp(slope, (0, SECONDS), start, method="DOP853", rtol=2.3e-14, atol=1e-15, max_step=0.02).y[:, -1]
    errors, ladder = [], LOADED_LADDERS[ORDERS[integrator]]
    for steps in ladder:
        end = _run(body, _options(integrator, SECONDS / steps), SECONDS, gravity, (force, torque))
        error = np.append(np.delete(end - true, np.s_[3:7]), _angle(end[3:7], true[3:7]))
        errors.append(float(np.linalg.norm(error)))
    _assert_order(integrator, ladder, errors, 5e-13)


def _matrix(q: np.ndarray) -> np.ndarray:
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@pytest.mark.parametrize(("integrator", "most"), [("splitting_8", 1e-12), ("splitting_4", 1e-11), ("rk4", 1e-9)])
def test_the_attitude_after_ten_seconds_meets_the_goal(integrator: str, most: float) -> None:
    """The engine's goals at 240 Hz: 1e-12 rad in the best integrator and 1e-9 rad with Runge-Kutta."""
    assert _attitude_error(integrator, 1 / 240, 10.0) <= most


def _energy_errors(integrator: str, dt: float, steps: int, pieces: int) -> np.ndarray:
    """Relative errors of the kinetic energy of the free top, (pieces,)."""
    world = engine.World([_top()], gravity=(0, 0, 0), options=_options(integrator, dt))
    start, errors = 0.5 * MOMENTS @ np.array(SPIN) ** 2, []
    for _ in range(pieces):
        world.step(steps // pieces)
        w_B = _matrix(world.state()[0, 3:7]).T @ world.state()[0, 10:]
        errors.append(0.5 * MOMENTS @ w_B**2 / start - 1)
    return np.asarray(np.abs(errors))


@pytest.mark.parametrize("integrator", KICKED)
def test_the_energy_error_stays_bounded_over_a_hundred_thousand_steps(integrator: str) -> None:
    """A symplectic or conserving method's error oscillates: the last tenth is no worse than the first, at a step of 0.1 s.

    The thousand samples of a tenth miss the crest of an oscillation by less than 5 %. Round-off may be biased by half a unit in
    the last place in each of 1e5 steps: 1e5 * 1.1e-16 / 2 = 5.5e-12.
    """
    errors = _energy_errors(integrator, 0.1, 100_000, 10_000)
    print(f"{integrator}: largest energy error {errors.max():.1e}, last {errors[-1]:.1e}")
    assert errors[-1000:].max() <= 1.05 * errors[:1000].max() + 5.5e-12


def test_explicit_euler_gains_energy_without_bound() -> None:
    """The control of the test above: its gain is h^2/2 times a square in each step, so ten times the steps give over five."""
    errors = _energy_errors("explicit_euler", 1 / 240, 10_000, 10)
    assert np.all(np.diff(errors) > 0)
    assert errors[-1] > 5 * errors[0]


def test_implicit_midpoint_keeps_energy_and_momentum_at_any_step() -> None:
    """At six steps a turn both are kept to round-off, 100 steps of some 40 roundings: 4e-13; Runge-Kutta is off by far more."""
    off = {}
    for integrator in ("implicit_midpoint", "rk4"):
        end = _run(_top(), _options(integrator, 0.5), 50.0)
        turn = _matrix(end[3:7])
        w_B = turn.T @ end[10:]
        energy = MOMENTS @ w_B**2 / (MOMENTS @ np.array(SPIN) ** 2) - 1
        momentum = np.linalg.norm(turn @ (MOMENTS * w_B) - MOMENTS * SPIN) / np.linalg.norm(MOMENTS * SPIN)
        off[integrator] = abs(energy), momentum
    assert max(off["implicit_midpoint"]) <= 4e-13
    assert off["rk4"][0] > 1e-4


@pytest.mark.parametrize("integrator", KICKED)
def test_a_step_back_undoes_a_step(integrator: str) -> None:
    """Symmetric methods: with reversed velocities 100 steps return to the start, but for 200 steps of 40 roundings: 1e-12."""
    out = engine.World([_top()], gravity=(0, 0, 0), options=_options(integrator, 0.1))
    out.step(100)
    out.state()[0, 7:] *= -1
    out.step(100)
    assert out.state()[0, 10:] == pytest.approx(-np.array(SPIN), abs=1e-12)
    assert _angle(out.state()[0, 3:7], np.array([1.0, 0.0, 0.0, 0.0])) < 1e-12


@pytest.mark.parametrize("integrator", [name for name in ORDERS if ORDERS[name] > 1])
def test_a_parabola_is_exact(integrator: str) -> None:
    """Order two or more integrates it exactly; 2400 sums of numbers up to 500 m round off by at most 1.3e-10 m."""
    end = _run(_top(v_WB=(1.0, 2.0, 3.0)), _options(integrator, 1 / 240), 10.0, (0.0, 0.0, -9.81))
    assert end[:3] == pytest.approx([10.0, 20.0, 30.0 - 0.5 * 9.81 * 100.0], abs=1.3e-10)


def test_explicit_euler_falls_g_dt_t_over_2_too_little() -> None:
    """Old velocities are summed, so that the error is exactly +g dt t / 2, up to round-off."""
    end = _run(_top(), _options("explicit_euler", 1 / 240), 10.0, (0.0, 0.0, -9.81))
    assert end[2] + 0.5 * 9.81 * 100.0 == pytest.approx(9.81 / 240 * 10.0 / 2, abs=1e-9)


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_substeps_divide_the_step(integrator: str) -> None:
    """Four sub-steps of a step are four steps of a quarter, to the rounding of dt / 4: none for a power of two."""
    body = _top(angular_damping=0.5)
    one = _run(body, _options(integrator, 1 / 64, substeps=4), 1.0, (0.0, 0.0, -9.81))
    other = _run(body, _options(integrator, 1 / 256), 1.0, (0.0, 0.0, -9.81))
    assert one.tolist() == other.tolist()


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_without_the_gyroscopic_effect_the_spin_is_constant(integrator: str) -> None:
    """w' = 0: turning w into the body and back rounds 240 times by some 1e-15.

    The methods with kicks turn exactly. The others turn about the axis of w too, as q' = q w / 2 has no other direction.
    """
    end = _run(_top(), _options(integrator, 1 / 240, gyroscopic=False), 1.0)
    assert end[10:] == pytest.approx(SPIN, abs=2.4e-13)
    if integrator in KICKED:
        angle, axis = np.linalg.norm(SPIN), np.array(SPIN) / np.linalg.norm(SPIN)
        assert _angle(end[3:7], np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)])) < 2.4e-13


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_a_kinematic_body_keeps_its_velocities_and_a_static_one_its_place(integrator: str) -> None:
    """p = v t and the angle w t to round-off, whatever the loads."""
    moving = engine.Body(name="a", motion="kinematic", v_WB=(1.0, 0.0, 0.0), w_WB=(0.0, 0.0, 2.0))
    still = engine.Body(name="b", motion="static", p_WB=(5.0, 0.0, 0.0))
    world = engine.World([moving, still], options=_options(integrator, 1 / 240))
    world.set_load(np.ones((2, 3)), np.ones((2, 3)))
    world.step(240)
    assert world.state()[0, :3] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert 2 * math.atan2(world.state()[0, 6], world.state()[0, 3]) == pytest.approx(2.0, abs=1e-12)
    assert world.state()[1].tolist() == [5.0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]


@pytest.mark.parametrize("diagonal", [*itertools.permutations((1.0, 2.0, 3.0)), (2.0, 2.0, 2.0), (2.0, 2.0, 3.0)])
def test_principal_axes_of_a_diagonal_inertia_are_the_bodys(diagonal: tuple[float, float, float]) -> None:
    """Ascending moments; the turned inertia comes back to the rounding of sums of squares of halves and roots: 1e-15."""
    moments, q = principal_frame(np.diag(diagonal))
    assert moments.tolist() == sorted(diagonal)
    assert _matrix(q) @ np.diag(moments) @ _matrix(q).T == pytest.approx(np.diag(diagonal), abs=4e-15)


def test_principal_axes_of_a_full_inertia_rebuild_it() -> None:
    """R diag(moments) R^T = I for 200 random tensors, to 1e-14 of their size."""
    rng = np.random.default_rng(3)
    for _ in range(200):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        inertia = turn @ np.diag(rng.uniform(1.0, 3.0, 3)) @ turn.T
        moments, q = principal_frame((inertia + inertia.T) / 2)
        assert np.all(np.diff(moments) >= 0)
        assert _matrix(q) @ np.diag(moments) @ _matrix(q).T == pytest.approx(inertia, abs=3e-14)


@pytest.mark.parametrize("weights", [SUZUKI_4, KAHAN_LI_8], ids=["suzuki", "kahan_li"])
def test_compositions_are_symmetric_and_of_sum_one(weights: np.ndarray) -> None:
    """Sum g = 1 and, for order four, sum g^3 = 0 (Hairer, Lubich, Wanner, section II.4), up to the rounding of 17 terms."""
    assert weights.tolist() == weights[::-1].tolist()
    assert [weights.sum(), (weights**3).sum()] == pytest.approx([1.0, 0.0], abs=2e-15)


def test_the_adaptive_error_is_proportional_to_its_tolerance() -> None:
    """Steps h ~ tol^(1/5) and an error ~ h^5 make it proportional; limits on the step and whole steps in dt blur the slope by
    less than the fifth that one order more or less would change it."""
    tolerances = [1e-5, 1e-7, 1e-9, 1e-11]
    true = _true_attitude(10.0)
    errors = [_angle(_run(_top(), _options("dormand_prince", 2.0, step_tolerance=t), 10.0)[3:7], true) for t in tolerances]
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    print(f"dormand_prince: error ~ tolerance^{slope:.3f}, errors {errors}")
    assert slope == pytest.approx(1.0, abs=0.2)


def test_adaptive_steps_land_on_dt_and_repeat_bit_for_bit() -> None:
    """v = g t and the number of dt done are those of fixed steps; a restored world takes the same steps again."""
    world = engine.World([_top()], gravity=(0, 0, -9.81), options=_options("dormand_prince", 0.7, step_tolerance=1e-10))
    world.step(3)
    assert world.state()[0, 9] == pytest.approx(-9.81 * 2.1, abs=1e-13)
    assert world.state()[0, 2] == pytest.approx(-0.5 * 9.81 * 2.1**2, abs=1e-13)
    saved = world.save()
    world.step(5)
    first = world.state().tobytes()
    world.restore(saved)
    for _ in range(5):
        world.step()
    assert world.state().tobytes() == first


def test_adaptive_bodies_do_not_disturb_each_other() -> None:
    """Each body has a step of its own: beside a top that spins thirty times faster the slow one moves bit for bit as alone."""
    options = _options("dormand_prince", 0.5, step_tolerance=1e-9)
    alone = engine.World([_top(name="slow")], options=options)
    both = engine.World([_top(name="fast", w_WB=(20.0, 30.0, 10.0)), _top(name="slow")], options=options)
    for world in (alone, both):
        world.step(4)
    assert both.state()[1].tolist() == alone.state()[0].tolist()


def test_a_step_that_cannot_be_solved_is_named() -> None:
    """1e9 rad/s for a second is more turns than the adaptive method may step through: its loop ends and says so."""
    world = engine.World([_top(w_WB=(1e9, 2e9, 1e9))], options=_options("dormand_prince", 1.0, step_tolerance=1e-12))
    with pytest.raises(engine.Diverged, match=r"dormand_prince.*no solution"):
        world.step()


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"integrator": "euler"}, "integrator 'euler'"),
        ({"step_tolerance": 1e-9}, "does not adapt"),
        ({"integrator": "dormand_prince", "step_tolerance": 1e-16}, "expected 1e-14"),
        ({"integrator": "dormand_prince", "step_tolerance": math.nan}, "expected 1e-14"),
    ],
)
def test_bad_options_are_named(options: dict[str, object], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        engine.Options(**options)  # type: ignore[arg-type]


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_joints_and_contacts_are_refused_at_build(integrator: str) -> None:
    options = engine.Options(integrator=integrator)
    ball = engine.Body(name="ball", shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0, 0, 1))
    ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
    tied = engine.Ball(name="j", parent=engine.WORLD, child="ball", anchor_W=(0, 0, 2))
    with pytest.raises(engine.NotSupported, match=f"'{integrator}' with contacts"):
        engine.World([ground, ball], options=options)
    with pytest.raises(engine.NotSupported, match=f"'{integrator}' with joints"):
        engine.World([ball], [tied], options=options)
    free = engine.Options(integrator=integrator, contacts=False)
    assert engine.World([ground, ball], options=free).stages == ("integrator",)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_adapter_offers_and_names_each_integrator(integrator: str) -> None:
    assert integrator in ADAPTER.knobs["integrator"]
    scene = Scene(bodies=(Body(name="top", mass=1.0, inertia=principal_inertia(*MOMENTS), w_WB=SPIN),))
    simulation = ADAPTER.build(scene, Settings(integrator=integrator))
    assert simulation.resolved.integrator == integrator
    assert simulation.resolved.options.get("step_tolerance") == (1e-12 if integrator == "dormand_prince" else None)
    simulation.close()


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_the_adapter_says_unsupported_where_constraints_act(integrator: str) -> None:
    ball = Body(
        name="ball",
        mass=1.0,
        inertia=principal_inertia(0.1, 0.1, 0.1),
        collision=(PlacedShape(shape=Sphere(radius=0.1)),),
        p_WB=(0, 0, 1),
    )
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    for scene in (
        Scene(bodies=(ground, ball), surfaces=(Surface(between=("default", "default")),)),
        Scene(bodies=(ball,), joints=(Ball(name="j", parent="world", child="ball", anchor_W=(0, 0, 2)),)),
    ):
        with pytest.raises(Unsupported, match=integrator):
            ADAPTER.build(scene, Settings(integrator=integrator))
    with pytest.raises(SettingsError, match="step_tolerance"):
        ADAPTER.build(scene, Settings(integrator="rk4", options={"step_tolerance": 1e-9}))


def test_a_dearer_integrator_is_a_more_exact_one() -> None:
    """Prints cost ratios, measured in turn in one process; what is asserted is that errors fall with the order at 60 Hz."""
    errors = {name: _attitude_error(name, 1 / 60, 10.0) for name in ORDERS}
    worlds = {name: engine.World([_top()], gravity=(0, 0, 0), options=_options(name, 1 / 240)) for name in ORDERS}
    starts = {name: world.save() for name, world in worlds.items()}
    seconds: dict[str, list[float]] = {name: [] for name in ORDERS}
    for _ in range(7):
        for name, world in worlds.items():
            world.restore(starts[name])
            begin = time.process_time()
            world.step(2400)
            seconds[name].append(time.process_time() - begin)
    base = np.array(seconds["semi_implicit_euler"])
    for name in ORDERS:
        print(f"{name}: {np.median(np.array(seconds[name]) / base):.2f} times the cost, {errors[name]:.1e} rad at 60 Hz")
    by_order = sorted(ORDERS, key=lambda name: ORDERS[name])
    for low, high in itertools.product(by_order, by_order):
        if ORDERS[low] < ORDERS[high]:
            assert errors[high] < errors[low], (low, high)
