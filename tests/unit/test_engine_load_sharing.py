"""A body on many contacts: its load is shared evenly, whatever the order of the contacts."""

import numpy as np
import pytest

from plumbline import engine

G, DT, MASS, FRICTION, SPIN, REACH, BALL = 9.81, 1e-3, 2.0, 0.3, 10.0, 0.05, 0.02
RINGS = 5
ROUND = MASS * (RINGS * REACH) ** 2 / 2
"""Moment of inertia [kg m2] of the disc about its axis."""


def _feet() -> np.ndarray:
    """Ninety-one points (91, 2) m of a triangular lattice within a hexagon."""
    cells = [(i, j) for i in range(-RINGS, RINGS + 1) for j in range(-RINGS, RINGS + 1) if abs(i + j) <= RINGS]
    return REACH * np.array([(i + j / 2, j * np.sqrt(3) / 2) for i, j in cells])


def _standing(order: np.ndarray) -> engine.World:
    """A disc that spins on a plane, on feet that are listed in this order."""
    feet = [engine.Placed(engine.Sphere(BALL), (x, y, -BALL)) for x, y in _feet()[order].tolist()]
    disc = engine.Body(
        name="disc",
        mass=MASS,
        inertia=np.diag([ROUND / 2, ROUND / 2, ROUND]),
        shapes=feet,
        p_WB=(0.0, 0.0, 2 * BALL),
        w_WB=(0.0, 0.0, SPIN),
    )
    ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
    law = engine.Surface(static_friction=FRICTION, kinetic_friction=FRICTION)
    options = engine.Options(dt=DT, substeps=4)
    return engine.World([ground, disc], surfaces={("default", "default"): law}, gravity=(0, 0, -G), options=options)


ORDERS = {
    "rings": np.arange(91),
    "back": np.arange(91)[::-1],
    "one": np.random.default_rng(1).permutation(91),
    "two": np.random.default_rng(2).permutation(91),
}


@pytest.mark.parametrize("order", ORDERS)
def test_a_disc_on_ninety_one_feet_is_braked_by_an_even_load_in_any_order(order: str) -> None:
    """The torque of an even load is mu m g times the mean distance of the feet from the axis. It is asked for within one in a
    hundred, half of what would tell two orders apart; in a tenth of a second the contacts have long settled.
    """
    world = _standing(ORDERS[order])
    world.step(300)
    torque = FRICTION * MASS * G * np.hypot(*_feet().T).mean()
    assert SPIN - world.state()[1, 12] == pytest.approx(torque / ROUND * 300 * DT, rel=0.01)
