"""Restitution where one blow leads to the next: balls that fall one behind the other, and a rack that is broken."""

from functools import partial

import numpy as np
import pytest

from plumbline import engine

G, DT, DROP, RADIUS = 9.81, 1e-3, 1.0, 0.1
DEFAULT = ("default", "default")
BETWEEN = partial(pytest.param, marks=pytest.mark.slow)
"""A parameter between two that are tested anyway."""
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])


def _ball(name: str, mass: float, radius: float, p_WB: tuple[float, float, float], **state: object) -> engine.Body:
    inertia = 0.4 * mass * radius**2 * np.eye(3)
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=[engine.Placed(engine.Sphere(radius))], p_WB=p_WB, **state)  # type: ignore[arg-type]


def _fallen(ratio: float, restitution: float, gap: float, end: float) -> tuple[float, float]:
    """Velocities [m/s] at the time `end` of two balls dropped from `DROP`, by parabolas between blows taken in their order."""
    height, speed, left = [DROP, DROP + gap], [0.0, 0.0], end
    while True:
        ground = (speed[0] + np.sqrt(speed[0] ** 2 + 2 * G * height[0])) / G
        closing = speed[0] - speed[1]
        pair = (height[1] - height[0]) / closing if closing > 1e-12 else np.inf
        wait = min(ground if ground > 1e-12 else np.inf, pair, left)
        height = [h + v * wait - G * wait * wait / 2 for h, v in zip(height, speed, strict=True)]
        speed = [v - G * wait for v in speed]
        left -= wait
        if left == 0.0:
            return speed[0], speed[1]
        if wait == pair:
            impulse = (1 + restitution) * (speed[0] - speed[1]) * ratio / (1 + ratio)
            height[1], speed = height[0], [speed[0] - impulse / ratio, speed[1] + impulse]
        else:
            height[0], speed[0] = 0.0, -restitution * speed[0]


@pytest.mark.parametrize("gap", [1e-4, BETWEEN(1e-3), 6e-3])
@pytest.mark.parametrize("restitution", [0.5, 1.0])
@pytest.mark.parametrize("ratio", [1.0, BETWEEN(10.0), BETWEEN(100.0), 1000.0])
def test_the_exact_solver_takes_the_blows_of_two_falling_balls_in_their_order(
    ratio: float, restitution: float, gap: float
) -> None:
    """Semi-implicit Euler is off by half of g dt in the speed of a fall, and again in that of the rise: g dt. Each of the
    speeds is handed on at most (1 + e) r / (1 + r) <= 2 times the closing speed of both: 4 g dt.
    """
    options = engine.Options(dt=DT, solver="exact", substeps=1)
    balls = [
        _ball("low", ratio, RADIUS, (0, 0, DROP + RADIUS)),
        _ball("high", 1.0, RADIUS, (0, 0, DROP + 3 * RADIUS + gap)),
    ]
    world = engine.World(
        [GROUND, *balls], surfaces={DEFAULT: engine.Surface(restitution=restitution)}, gravity=(0, 0, -G), options=options
    )
    world.step(480)
    assert world.state()[1:, 9] == pytest.approx(np.array(_fallen(ratio, restitution, gap, 0.48)), abs=4 * G * DT)


def _rack(solver: str, dt: float) -> float:
    """The kinetic energy after the break of a rack of fifteen balls a millimetre apart, over that before it."""
    radius, apart = 0.028575, 1e-3
    side = 2 * radius + apart
    balls = [
        _ball(f"{row}_{k}", 0.17, radius, (row * side * np.sqrt(3) / 2, (k - row / 2) * side, 0.0))
        for row in range(5)
        for k in range(row + 1)
    ]
    cue = _ball("cue", 0.17, radius, (-0.3, 0.003, 0.0), v_WB=(5.0, 0.0, 0.0))
    world = engine.World(
        [*balls, cue],
        surfaces={DEFAULT: engine.Surface(restitution=1.0)},
        gravity=(0, 0, 0),
        options=engine.Options(dt=dt, solver=solver, substeps=4 if solver == "tgs_soft" else 1),
    )
    world.step(round(0.12 / dt))
    return float((world.state()[:, 7:10] ** 2).sum() / 25.0)


def test_a_rack_broken_without_loss_keeps_its_energy() -> None:
    """The impulse of a blow and its rebound act along one line, so that nothing but round-off is gained: 1e3 of 1e-16."""
    assert _rack("tgs_soft", 1e-3) == pytest.approx(1.0, abs=1e-12)


def test_sequential_impulses_do_not_hold_a_rebound_by_what_it_has_yet_to_strike() -> None:
    """A ball goes a twentieth of its radius in a step; blows that a step takes together lose a share of that order: 5 %."""
    assert _rack("sequential_impulses", 2.5e-4) == pytest.approx(1.0, abs=0.05)
