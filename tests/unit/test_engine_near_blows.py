"""More sweeps near a blow: what lies elsewhere changes no bit of how a body lands, and costs what it would cost alone."""

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.memory import arena as at
from plumbline.engine.steps.stages import RINGS
from tests.engine_entries import list_near_blows

GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
INERTIA = 0.04 / 6 * np.eye(3)


def box(name: str, x: float, z: float, turned: bool = False) -> engine.Body:
    q = (0.9, 0.2, 0.3, (1 - 0.81 - 0.04 - 0.09) ** 0.5) if turned else (1.0, 0.0, 0.0, 0.0)
    return engine.Body(
        name=name, inertia=INERTIA, shapes=[engine.Placed(engine.Box((0.1, 0.1, 0.1)))], p_WB=(x, 0.0, z), q_WB=q
    )


def test_what_lies_elsewhere_changes_no_bit_of_a_landing() -> None:
    """A turned box falls on a tower of three; ten metres away others lie, and another one lands at another time."""
    tower = [*(box(f"t{k}", 0.0, 0.1 + 0.2 * k) for k in range(3)), box("falling", 0.05, 0.95, turned=True)]
    far = [*(box(f"f{k}", 10.0 + 0.5 * k, 0.1) for k in range(20)), box("late", 10.0, 1.4, turned=True)]
    alone, beside = (
        engine.World(bodies, options=engine.Options(dt=1 / 240)) for bodies in ([GROUND, *tower], [GROUND, *tower, *far])
    )
    for world in (alone, beside):
        world.step(240)
    assert np.array_equal(alone.state(), beside.state()[: 1 + len(tower)])


@pytest.mark.parametrize(
    ("struck", "near"), [((0,), [0, 1, 2]), ((3,), [1, 2, 3, 4, 5]), ((0, 6), [0, 1, 2, 4, 5, 6]), ((), [])]
)
def test_near_is_one_contact_further_and_not_through_the_ground(struck: tuple[int, ...], near: list[int]) -> None:
    """A chain of bodies 1-2-3-4-5-6-7, of which the first stands on the ground, body 0; another one stands there alone."""
    assert RINGS == 1
    pairs = [(0, 1), *((b, b + 1) for b in range(1, 7)), (0, 8)]
    kind = np.zeros((9, 4), np.int64)
    kind[1:, at.MOTION] = at.DYNAMIC
    key = np.zeros((len(pairs), 9), np.int64)
    key[:, [at.BODY_A, at.BODY_B]], key[:, at.BEGUN] = pairs, -2
    key[list(struck), at.STRIKES] = 1
    assert found(kind, key, -1) == near
    key[:, at.STRIKES] = 0
    key[list(struck), at.BEGUN] = 7
    assert found(kind, key, 7) == near
    assert found(kind, key, -1) == []


def found(kind: np.ndarray, key: np.ndarray, step: int) -> list[int]:
    """The rows of the contacts near a blow."""
    order, room = np.arange(len(key))[:, None], np.full((len(key), 1), -1)
    count = list_near_blows(kind, np.zeros((len(key), 61)), key, order, room, step)
    return room[:count, 0].tolist()
