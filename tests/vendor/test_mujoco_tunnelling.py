"""Which balls get through a thin wall in MuJoCo, by its default contacts and by speculative ones, in its own words."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vendor.mujoco_world import load, mujoco

pytestmark = pytest.mark.mujoco

DT, R, PHASES = 1 / 240, 0.05, 16


def centres(
    thickness: float, speed: float, ways: NDArray[np.float64], flag: str = "", contact: str = ""
) -> NDArray[np.float64]:
    """Where balls end [m], beyond the middle of a wall, in a quarter of a second that are shot at its face from `ways` [m]."""
    count, law = len(ways), f'contype="1" conaffinity="2" {contact}'
    world = (
        f'<geom type="box" size="{thickness / 2} {count / 2 + 1} .5" pos="0 {(count - 1) / 2} 0" contype="2" conaffinity="1" '
        f"{contact}/>"
    )
    for k, way in enumerate(ways.tolist()):
        ball = f'<geom type="sphere" size="{R}" mass="1" {law}/>'
        world += f'<body pos="{-thickness / 2 - R - way!r} {k} 0"><freejoint/>{ball}</body>'
    model, data = load(world, DT, gravity=0.0, more=flag)
    data.qvel[::6] = speed
    mujoco.mj_step(model, data, 60)
    return np.array(data.qpos[::7])


def share_through(thickness: float, speed: float) -> float:
    """The share of 16 balls, each shot from another phase of a step, whose centre ends beyond the middle."""
    phases = (np.arange(PHASES) + 0.5) / PHASES
    return float((centres(thickness, speed, 0.05 + speed * DT * phases) > 0).mean())


@pytest.mark.parametrize(("thickness", "held", "through"), [(0.005, 5.0, 7.5), (0.02, 7.0, 10.0), (0.1, 10.0, 15.0)])
def test_the_default_contact_lets_balls_through_that_were_seen_in_time(thickness: float, held: float, through: float) -> None:
    # A step's way at these speeds, 31, 42 and 63 mm, is less than R + thickness/2, so that every ball is found before its
    # centre is beyond the middle: what lets it through is a spring with a time constant of 20 ms, five steps.
    assert through * DT < R + thickness / 2
    assert share_through(thickness, held) == 0.0
    assert share_through(thickness, through) > 0.0


@pytest.mark.parametrize(("flag", "passed"), [("", 64), ('<option><flag speculative="enable"/></option>', 0)])
def test_balls_pass_a_wall_of_a_centimetre_at_50_m_per_s_unless_contacts_are_speculative(flag: str, passed: int) -> None:
    """Balls of 5 cm, each at another phase of its step of 21 cm; speculative contacts are off by default."""
    ends = centres(0.01, 50.0, 0.05 + np.random.default_rng(0).uniform(0.0, 50 / 60, 64), flag)
    # The centre beyond the wall's middle, or the front deeper than it: here the same balls.
    assert int((ends > 0.0).sum()) == int((ends + R > 0.0).sum()) == passed


TWO_STEPS = f'solref="{2 * DT!r} 1"'
"""The least time constant that the documentation advises: "Modeling", solver parameters."""


@pytest.mark.parametrize(("contact", "through"), [("", 64), (TWO_STEPS, 0)])
def test_contacts_of_two_steps_hold_a_wall_at_12_m_per_s_that_all_balls_pass_by_default(contact: str, through: int) -> None:
    ways = 0.05 + np.random.default_rng(0).uniform(0.0, 12 / 60, 64)
    assert int((centres(0.01, 12.0, ways, contact=contact) > 0.0).sum()) == through


ROD, POST, HALF, LEVER, AHEAD = 0.01, 0.01, 0.5, 0.4, 0.15


def rods_through(spin: float, contact: str) -> int:
    """How many of 64 rods that spin [rad/s] between two posts, each from another phase, turn their middle beyond a post's."""
    meeting = math.asin((ROD + POST) / LEVER)
    angles = (AHEAD + np.random.default_rng(0).uniform(0.0, spin / 240, 64)).tolist()
    middle = 0.1 * (len(angles) - 1) / 2
    post = f'<geom type="capsule" size="{POST} {middle + 0.1}" contype="2" conaffinity="1" {contact}'
    world = "".join(f'{post} pos="{side * LEVER} 0 {middle}"/>' for side in (-1, 1))
    for k, angle in enumerate(angles):
        rod = f'<geom type="capsule" size="{ROD} {HALF}" euler="0 90 0" mass=".5" contype="1" conaffinity="2" {contact}/>'
        world += f'<body pos="0 0 {0.1 * k!r}" euler="0 0 {-math.degrees(angle + meeting)!r}"><freejoint/>{rod}</body>'
    model, data = load(world, DT, gravity=0.0)
    data.qvel[5::6] = spin
    passed = np.zeros(len(angles), dtype=bool)
    for _ in range(60):
        mujoco.mj_step(model, data)
        azimuth = 2 * np.arctan2(data.qpos[6::7], data.qpos[3::7])
        passed |= np.sin(azimuth) > 0
    return int(passed.sum())


@pytest.mark.parametrize(("spin", "contact", "through"), [(5.6, "", 0), (11.2, "", 61), (11.2, TWO_STEPS, 0)])
def test_contacts_of_two_steps_hold_rods_at_twice_the_rate(spin: float, contact: str, through: int) -> None:
    assert rods_through(spin, contact) == through
