"""A fast top on a ball joint in MuJoCo, by its integrators, asked through mujoco alone."""

import math

import numpy as np
import pytest

from tests.vendor import spinning
from tests.vendor.mujoco_world import blew_up, load, mujoco

pytestmark = pytest.mark.mujoco


def lean(integrator: str) -> float:
    """How far [m] a top of 100 rad/s gets from its way within 2 s at 1/240 s; infinite where it is reset."""
    dt, turn = 1 / 240, math.degrees(spinning.TILT)
    diagonal = " ".join(map(repr, spinning.TOP))
    inertial = f'<inertial pos="0 0 {spinning.STEM}" mass="1" diaginertia="{diagonal}"/>'
    top = f'<body euler="0 {turn!r} 0"><joint type="ball"/>{inertial}</body>'
    model, data = load(top, dt, option=f'integrator="{integrator}"')
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, model.body_quat[1])
    data.qvel[:] = R.reshape(3, 3).T @ spinning.top_rate(100.0)
    off = 0.0
    for n in range(1, round(2 / dt) + 1):
        mujoco.mj_step(model, data)
        if blew_up(data):
            return math.inf
        mujoco.mj_kinematics(model, data)
        off = max(off, float(np.linalg.norm(data.xipos[1] - spinning.centre(100.0, n * dt))))
    return off


def test_by_the_default_integrator_a_top_of_100_rad_per_s_lies_down() -> None:
    # Two stems away at the most; a tenth of the stem counts as lost.
    assert lean("Euler") > spinning.STEM


def test_by_runge_kutta_it_precesses() -> None:
    assert lean("RK4") < spinning.STEM / 100
