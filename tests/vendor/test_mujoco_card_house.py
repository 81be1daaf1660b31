"""Two houses of two cards in MuJoCo's own words: one with more friction at its feet than it needs, one with less."""

import math

import pytest

from tests.vendor.mujoco_world import load, mujoco

pytestmark = pytest.mark.mujoco

DT, ANGLE = 1 / 240, math.radians(20.0)
THICK, WIDE, LONG = 0.01, 0.15, 0.2
"""Half extents of a card [m]."""
CRITICAL = (math.tan(ANGLE) - THICK / LONG) / 2
"""The least friction at the feet with which a house stands."""


def height(friction: float, azimuth: float = 0.0, cone: str = "elliptic") -> float:
    """The height of the lower of two cards after 2 s, over that at the start; card on card 1, the gable turned."""
    across = LONG * math.sin(ANGLE) + THICK * math.cos(ANGLE)
    high = LONG * math.cos(ANGLE) + THICK * math.sin(ANGLE)
    cards = "".join(
        f'<body pos="{-way * across * math.cos(azimuth)} {-way * across * math.sin(azimuth)} {high}" '
        f'euler="{math.degrees(azimuth)} {way * math.degrees(ANGLE)} 0"><freejoint/>'
        f'<geom name="card{way}" type="box" size="{THICK} {WIDE} {LONG}" mass="0.1"/></body>'
        for way in (1, -1)
    )
    pairs = "".join(f'<pair geom1="plate" geom2="card{way}" friction="{friction} {friction}"/>' for way in (1, -1))
    model, data = load(
        f'<geom name="plate" type="box" size="2 2 0.05" pos="0 0 -0.05"/>{cards}',
        DT,
        option=f'cone="{cone}" impratio="100"',
        more='<compiler eulerseq="zyx"/><default><geom contype="0" conaffinity="0"/></default>'
        f'<contact>{pairs}<pair geom1="card1" geom2="card-1" friction="1 1"/></contact>',
    )
    for _ in range(round(2 / DT)):
        mujoco.mj_step(model, data)
    return float(min(data.qpos[2], data.qpos[9])) / high


@pytest.mark.parametrize("margin", [0.5, 0.1, 0.05])
def test_a_house_stands_with_more_friction_than_it_needs_and_falls_with_less(margin: float) -> None:
    # A card that lies down has its centre at its half thickness, 0.05 of its height when it stands.
    assert height((1 + margin) * CRITICAL) > 0.9
    assert height((1 - margin) * CRITICAL) < 0.2


def test_under_a_pyramid_the_way_that_a_house_looks_decides_whether_it_stands() -> None:
    # A pyramid with its corners on the axes holds mu/sqrt(2) between them: a fifth more than needed is 15 % too little.
    friction = 1.2 * CRITICAL
    assert height(friction, 0.0, "pyramidal") > 0.9
    assert height(friction, math.pi / 4, "pyramidal") < 0.2
    assert height(friction, math.pi / 4, "elliptic") > 0.9
