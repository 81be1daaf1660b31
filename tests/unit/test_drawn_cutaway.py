"""What a container holds is seen: the walls between it and the eye are left out, and nothing else is."""

from typing import Any

import numpy as np
import pytest

from plumbline.harness.trajectory import Floats
from plumbline.reports.drawn.solids import opened

WALLS = [(1.0, 0, 0), (-1.0, 0, 0), (0, 1.0, 0), (0, -1.0, 0), (0, 0, 1.0), (0, 0, -1.0)]
EYE = np.array([2.0, -2.0, 1.0]) / 3.0
UPRIGHT, TURNED = np.array([1.0, 0, 0, 0]), np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
"""Not turned, and by a quarter about z: the wall at +x looks along +y."""


def case(balls: list[tuple[float, float, float]], q_WB: Floats = UPRIGHT) -> tuple[list[dict[str, Any]], Floats, Floats]:
    """A box of six walls about the origin, and balls."""
    middle = np.array([5.0, 6.0, 7.0])
    walls = [{"shape": {"type": "box", "half_extents": [1, 1, 1]}, "p_BS": p} for p in WALLS]
    ball: dict[str, Any] = {"motion": "dynamic", "collision": [{"shape": {"type": "sphere", "radius": 0.1}}]}
    bodies: list[dict[str, Any]] = [{"motion": "dynamic", "collision": walls}, *(ball for _ in balls)]
    p_WB = np.array([middle, *(middle + place for place in balls)])
    return bodies, p_WB, np.array([q_WB, *(UPRIGHT for _ in balls)])


def left(bodies: list[dict[str, Any]], p_WB: Floats, q_WB: Floats) -> set[tuple[float, ...]]:
    """Where the walls that are drawn sit in their body."""
    shown = opened(bodies, p_WB, q_WB, EYE)
    assert shown[1:] == bodies[1:]
    return {shape["p_BS"] for shape in shown[0].get("visual", shown[0]["collision"])}


@pytest.mark.parametrize(
    ("q_WB", "near"),
    # In a body turned by a quarter the eye, along (2, -2, 1), is along (-2, -2, 1).
    [(UPRIGHT, {(1.0, 0, 0), (0, -1.0, 0), (0, 0, 1.0)}), (TURNED, {(-1.0, 0, 0), (0, -1.0, 0), (0, 0, 1.0)})],
)
def test_walls_towards_the_eye_are_left_out(q_WB: Floats, near: set[tuple[float, ...]]) -> None:
    assert left(*case([(0.0, 0.0, 0.0), (0.5, 0.5, -0.5)], q_WB)) == set(WALLS) - near


def test_a_body_that_holds_nothing_is_whole() -> None:
    """Nor one that holds half of what else moves, as a machine's trunk holds some of its links."""
    assert left(*case([(3.0, 0.0, 0.0)])) == set(WALLS)
    assert left(*case([(0.0, 0.0, 0.0), (3.0, 0.0, 0.0)])) == set(WALLS)
    assert left(*case([])) == set(WALLS)
