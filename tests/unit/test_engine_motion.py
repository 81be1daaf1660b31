"""Free motion of single bodies against closed forms and an independent integrator."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline import engine

G = 9.81
MOMENTS = np.array([1.0, 2.0, 3.0])
SPIN = (1.0, 2.0, 0.5)


def _run(
    body: engine.Body, seconds: float, gravity: tuple[float, float, float] = (0.0, 0.0, -G), **options: object
) -> np.ndarray:
    world = engine.World([body], gravity=gravity, options=engine.Options(**options))  # type: ignore[arg-type]
    world.step(round(seconds / world.options.dt))
    return np.array(world.state()[0])


def _true_attitude(seconds: float) -> np.ndarray:
    """Euler's equations in the body frame by an integrator of order eight at a tolerance of 1e-13."""

    def slope(_: float, y: np.ndarray) -> list[float]:
        q, w = y[:4], y[4:]
        turn = 0.5 * np.array([-q[1:] @ w, *(q[0] * w + np.cross(q[1:], w))])
        return [*turn, *(-np.cross(w, MOMENTS * w) / MOMENTS)]

    end = solve_ivp(slope, (0, seconds), [1, 0, 0, 0, *SPIN], method="DOP853", rtol=1e-13, atol=1e-15).y[:4, -1]
    return np.asarray(end / np.linalg.norm(end))


def _attitude_error(dt: float, seconds: float = 10.0) -> float:
    body = engine.Body(inertia=np.diag(MOMENTS), w_WB=SPIN)
    q = _run(body, seconds, (0.0, 0.0, 0.0), dt=dt, integrator="rk4")[3:7]
    true = _true_attitude(seconds)
    return 2 * float(min(np.linalg.norm(q - true), np.linalg.norm(q + true)))


def test_runge_kutta_falls_exactly() -> None:
    """A parabola is integrated exactly; 2400 sums of numbers up to 500 m round off by 2400 * 500 * 1.1e-16 = 1.3e-10 m."""
    end = _run(engine.Body(v_WB=(1.0, 2.0, 3.0)), 10.0, integrator="rk4")
    assert end[:3] == pytest.approx([10.0, 20.0, 30.0 - 0.5 * G * 100.0], abs=1.3e-10)
    assert end[9] == pytest.approx(3.0 - G * 10.0, abs=1e-10)


def test_semi_implicit_euler_falls_g_dt_t_over_2_too_far() -> None:
    """Summing v_k = v_0 - k g dt gives an error of exactly -g dt t / 2, up to round-off of 1e-10 m as above."""
    end = _run(engine.Body(v_WB=(0.0, 0.0, 3.0)), 10.0, substeps=1)
    assert end[2] - (30.0 - 0.5 * G * 100.0) == pytest.approx(-G / 240 * 10.0 / 2, abs=1e-9)


def test_the_asymmetric_top_turns_with_order_four() -> None:
    """Halving dt divides the error by 16; the next term of the series changes the ratio by less than 20 % at these steps.

    The prototype's 1e-10 rad at 240 Hz is the mark for faster tumbling axes; 2e-9 rad leaves room for the choice of spin.
    """
    coarse, fine = _attitude_error(1 / 120), _attitude_error(1 / 240)
    assert 13 < coarse / fine < 20
    assert fine < 2e-9


@pytest.mark.parametrize("integrator", ["rk4", "semi_implicit_euler"])
def test_a_free_body_keeps_its_angular_momentum(integrator: str) -> None:
    """Both schemes carry L itself; turning it into w and back rounds at 1e-16 a step, 2400 steps of L = 4 kg m2/s: 1e-12."""
    end = _run(engine.Body(inertia=np.diag(MOMENTS), w_WB=SPIN), 10.0, (0.0, 0.0, 0.0), integrator=integrator, substeps=1)
    w, x, y, z = end[3:7]
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    assert turn @ np.diag(MOMENTS) @ turn.T @ end[10:] == pytest.approx(MOMENTS * np.array(SPIN), abs=1e-11)


def test_without_the_gyroscopic_effect_the_spin_is_constant() -> None:
    """w' = 0 is integrated without any error."""
    end = _run(engine.Body(inertia=np.diag(MOMENTS), w_WB=SPIN), 1.0, (0.0, 0.0, 0.0), integrator="rk4", gyroscopic=False)
    assert end[10:].tolist() == list(SPIN)


@pytest.mark.parametrize("integrator", ["rk4", "semi_implicit_euler"])
def test_damping_decays_exponentially(integrator: str) -> None:
    """v = v_0 exp(-c t). Euler multiplies by the exponential itself; RK4 errs by (c dt)^5 / 120 a step: 240 * 3e-12 = 1e-9."""
    body = engine.Body(v_WB=(1.0, 0.0, 0.0), w_WB=(0.0, 2.0, 0.0), linear_damping=1.0, angular_damping=0.5)
    end = _run(body, 1.0, (0.0, 0.0, 0.0), integrator=integrator)
    assert end[7] == pytest.approx(math.exp(-1.0), abs=1e-9)
    assert end[11] == pytest.approx(2 * math.exp(-0.5), abs=1e-9)


def test_a_force_at_a_point_is_a_force_and_its_moment() -> None:
    """f = (0, 2, 0) N at x = .5 m from the centre gives a = f/m and a moment of 1 N m about z; both are constant here."""
    world = engine.World(
        [engine.Body(mass=4.0, inertia=2.0 * np.eye(3))], gravity=(0, 0, 0), options=engine.Options(dt=1e-3, substeps=1)
    )
    world.add_force(0, (0.0, 2.0, 0.0), (0.5, 0.0, 0.0))
    world.step(1)
    assert world.state()[0, 7:10] == pytest.approx([0.0, 0.5e-3, 0.0], abs=1e-15)
    assert world.state()[0, 10:] == pytest.approx([0.0, 0.0, 0.5e-3], abs=1e-15)


def test_a_kinematic_body_keeps_its_velocities() -> None:
    """p = v t and the angle w t to round-off, without gravity."""
    body = engine.Body(motion="kinematic", v_WB=(1.0, 0.0, 0.0), w_WB=(0.0, 0.0, 2.0))
    end = _run(body, 1.0, integrator="rk4")
    assert end[:3] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert 2 * math.atan2(end[6], end[3]) == pytest.approx(2.0, abs=1e-12)
