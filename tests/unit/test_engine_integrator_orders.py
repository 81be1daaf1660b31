"""Every integrator of free bodies has the order of its paper, and meets the engine's goals."""

import itertools
import math
import time
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline import engine
from tests.free_tops import MOMENTS, SPIN, angle_between, matrix, options_of, run, top, true_attitude

Vector = tuple[float, float, float]
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


def _attitude_error(integrator: str, dt: float, seconds: float) -> float:
    end = run(top(), options_of(integrator, dt), seconds)
    return angle_between(end[3:7], true_attitude(seconds))


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


@cache
def _loaded() -> tuple[engine.Body, Vector, Vector, Vector, np.ndarray]:
    """A body with a tilted inertia, gravity, force, torque, and the state at the end by DOP853 in short steps."""
    tilt = np.linalg.qr(np.array([[1.0, 2.0, 0.5], [-1.0, 1.0, 2.0], [0.3, -1.0, 1.0]]))[0]
    inertia = tilt @ np.diag(MOMENTS) @ tilt.T
    inertia = (inertia + inertia.T) / 2
    force, torque, gravity, c, d = (1.0, -2.0, 0.5), (1.0, -2.0, 1.5), (0.0, 0.0, -9.81), 0.2, 0.1
    body = top(mass=2.0, inertia=inertia, v_WB=(1.0, 2.0, 3.0), linear_damping=c, angular_damping=d)

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        q, v, w = y[3:7], y[7:10], y[10:]
        turn = matrix(q)
        world_inertia = turn @ inertia @ turn.T
        spin = np.linalg.solve(world_inertia, np.array(torque) - np.cross(w, world_inertia @ w)) - d * w
        dq = 0.5 * np.array([-w @ q[1:], *(q[0] * w + np.cross(w, q[1:]))])
        return np.concatenate([v, dq, np.array(gravity) + np.array(force) / 2.0 - c * v, spin])

    start = [0, 0, 0, 1, 0, 0, 0, 1, 2, 3, *SPIN]
    true = solve_ivp(slope, (0, SECONDS), start, method="DOP853", rtol=2.3e-14, atol=1e-15, max_step=0.02).y[:, -1]
    return body, gravity, force, torque, true


@pytest.mark.parametrize("integrator", ORDERS)
def test_the_order_holds_under_loads_and_damping_with_a_tilted_inertia(integrator: str) -> None:
    """Force, torque, gravity, both dampings and a full inertia tensor, against DOP853 in short steps, good to 2e-14.

    200 sums of numbers up to 20 m round off by at most 200 * 20 * 1.1e-16 = 5e-13, the floor of an error.
    """
    body, gravity, force, torque, true = _loaded()
    errors, ladder = [], LOADED_LADDERS[ORDERS[integrator]]
    for steps in ladder:
        end = run(body, options_of(integrator, SECONDS / steps), SECONDS, gravity, (force, torque))
        error = np.append(np.delete(end - true, np.s_[3:7]), angle_between(end[3:7], true[3:7]))
        errors.append(float(np.linalg.norm(error)))
    _assert_order(integrator, ladder, errors, 5e-13)


@pytest.mark.parametrize(("integrator", "most"), [("splitting_8", 1e-12), ("splitting_4", 1e-11), ("rk4", 1e-9)])
def test_the_attitude_after_ten_seconds_meets_the_goal(integrator: str, most: float) -> None:
    """The engine's goals at 240 Hz: 1e-12 rad in the best integrator and 1e-9 rad with Runge-Kutta."""
    assert _attitude_error(integrator, 1 / 240, 10.0) <= most


@pytest.mark.parametrize("integrator", [name for name in ORDERS if ORDERS[name] > 1])
def test_a_parabola_is_exact(integrator: str) -> None:
    """Order two or more integrates it exactly; 2400 sums of numbers up to 500 m round off by at most 1.3e-10 m."""
    end = run(top(v_WB=(1.0, 2.0, 3.0)), options_of(integrator, 1 / 240), 10.0, (0.0, 0.0, -9.81))
    assert end[:3] == pytest.approx([10.0, 20.0, 30.0 - 0.5 * 9.81 * 100.0], abs=1.3e-10)


def test_explicit_euler_falls_g_dt_t_over_2_too_little() -> None:
    """Old velocities are summed, so that the error is exactly +g dt t / 2, up to round-off."""
    end = run(top(), options_of("explicit_euler", 1 / 240), 10.0, (0.0, 0.0, -9.81))
    assert end[2] + 0.5 * 9.81 * 100.0 == pytest.approx(9.81 / 240 * 10.0 / 2, abs=1e-9)


def test_the_adaptive_error_is_proportional_to_its_tolerance() -> None:
    """Steps h ~ tol^(1/5) and an error ~ h^5 make it proportional; limits on the step and whole steps in dt blur the slope by
    less than the fifth that one order more or less would change it."""
    tolerances = [1e-5, 1e-7, 1e-9, 1e-11]
    true = true_attitude(10.0)
    errors = [
        angle_between(run(top(), options_of("dormand_prince", 2.0, step_tolerance=t), 10.0)[3:7], true) for t in tolerances
    ]
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    print(f"dormand_prince: error ~ tolerance^{slope:.3f}, errors {errors}")
    assert slope == pytest.approx(1.0, abs=0.2)


def test_a_dearer_integrator_is_a_more_exact_one() -> None:
    """Prints cost ratios, measured in turn in one process; what is asserted is that errors fall with the order at 60 Hz."""
    errors = {name: _attitude_error(name, 1 / 60, 10.0) for name in ORDERS}
    worlds = {name: engine.World([top()], gravity=(0, 0, 0), options=options_of(name, 1 / 240)) for name in ORDERS}
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
