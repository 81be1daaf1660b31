"""A free plate that spins fast in MuJoCo, by each of its integrators, asked through mujoco alone."""

import math

import numpy as np
import pytest

from tests.vendor import spinning
from tests.vendor.mujoco_world import blew_up, load, mujoco

pytestmark = pytest.mark.mujoco


def spin(speed: float, dt: float, integrator: str) -> float:
    """The greatest error of the plate's angular momentum within 2 s, as a share of it; infinite where it is reset."""
    diagonal = " ".join(map(repr, spinning.MOMENTS.tolist()))
    inertial = f'<inertial pos="0 0 0" mass="{spinning.PLATE}" diaginertia="{diagonal}"/>'
    model, data = load(f"<body><freejoint/>{inertial}</body>", dt, 0.0, f'integrator="{integrator}"')
    data.qvel[3:] = speed * spinning.UNIT
    R, off = np.zeros(9), 0.0
    for _ in range(round(2 / dt)):
        mujoco.mj_step(model, data)
        if blew_up(data):
            return math.inf
        mujoco.mju_quat2Mat(R, data.qpos[3:])
        turn = R.reshape(3, 3)
        off = max(off, spinning.momentum_off(turn, turn @ data.qvel[3:], speed))
    return off


def test_the_default_integrator_explodes_at_a_tenth_of_a_radian_a_step() -> None:
    """Euler takes the gyroscopic torque of the step's start, which gains energy."""
    assert spin(100.0, 1 / 960, "Euler") == math.inf


def test_the_implicit_integrators_stay_and_lose_a_third_of_the_angular_momentum() -> None:
    assert spin(100.0, 1 / 960, "implicit") == pytest.approx(1 / 3, rel=0.1)


def test_runge_kutta_keeps_it() -> None:
    # Order four: its error of a tenth of a radian a step is far below a thousandth.
    assert spin(100.0, 1 / 960, "RK4") < 1e-5


@pytest.mark.parametrize("flag", [flag for flag in mujoco.mjtDisableBit.__members__ if flag != "mjNDISABLE"])
def test_no_flag_switches_the_gyroscopic_term_off(flag: str) -> None:
    """A top of unlike moments changes its rates by w x I w under every one of them."""
    model, data = load('<body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.2 0.25"/></body>', 1e-3, 0.0, "")
    model.opt.disableflags = int(mujoco.mjtDisableBit.__members__[flag])
    data.qvel[3:] = 3.0, 1.0, -2.0
    for _ in range(100):
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel[3:] - (3.0, 1.0, -2.0)).max() > 0.05
