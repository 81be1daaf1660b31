"""Two floating bodies that a hinge turns, in MuJoCo's own words: reduced coordinates lose momentum by the turn of a step."""

import numpy as np
import pytest

from tests.vendor.mujoco_world import load, mujoco

pytestmark = pytest.mark.mujoco

ARM, SPIN = 0.5, 5.0
"""From the hinge, at the centre of the one, to the centre of the other [m]; how fast the other turns about it [rad/s]."""
BALL = 'mass="1" diaginertia=".00667 .00667 .00667"'
MACHINE = (
    f'<body><freejoint/><inertial pos="0 0 0" {BALL}/>'
    f'<body><joint axis="0 1 0"/><inertial pos="{ARM} 0 0" {BALL}/></body></body>'
)


def lost(rate: int, integrator: str) -> float:
    """The share of momentum that changes within a second, with no force from outside."""
    model, data = load(MACHINE, 1 / rate, gravity=0.0, option=f'integrator="{integrator}"')
    data.qvel[6] = SPIN

    def momentum() -> np.ndarray:
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        return 2 * np.array(data.subtree_linvel[0])

    start, worst = momentum(), 0.0
    for _ in range(rate):
        mujoco.mj_step(model, data)
        worst = max(worst, float(np.linalg.norm(momentum() - start)))
    return worst / float(np.linalg.norm(start))


@pytest.mark.parametrize("rate", [240, 480, 960])
def test_momentum_is_off_by_the_turn_of_one_step(rate: int) -> None:
    assert lost(rate, "Euler") == pytest.approx(SPIN / rate, rel=1e-3)


def test_by_the_fourth_order_it_is_not() -> None:
    # (SPIN/240)^4 a radian, five of them in a second: 1e-6 of it.
    assert lost(240, "RK4") < 1e-6
