"""What MuJoCo makes of an ellipsoid, in its own words: heights, rocking and rays as closed forms say."""

import math

import numpy as np
import pytest

from tests.vendor.mujoco_world import G, load, mujoco

pytestmark = pytest.mark.mujoco

A, B, C = 0.2, 0.15, 0.1
PERIOD = 2 * math.pi * math.sqrt(C * (A**2 + 6 * C**2) / (5 * G * (A**2 - C**2)))
"""Of small rocking without slip about y, on the end of C [s]."""


def _rocker(tilt: float, more: str = "") -> str:
    height = math.hypot(A * math.sin(tilt), C * math.cos(tilt))
    geom = f'<geom type="ellipsoid" size="{A} {B} {C}" mass="1" friction="1"/>'
    plane = '<geom type="plane" size="0 0 1" friction="1"/>'
    return f'{plane}<body pos="0 0 {height}" euler="0 {math.degrees(tilt)} 0"><freejoint/>{geom}{more}</body>'


def test_its_inertia_is_that_of_a_solid_ellipsoid() -> None:
    model, _ = load(_rocker(0.0), 1e-3)
    assert model.body_inertia[1] == pytest.approx([(B**2 + C**2) / 5, (A**2 + C**2) / 5, (A**2 + B**2) / 5])


def test_it_rocks_with_the_period_of_its_curvature() -> None:
    """Level at a quarter of a period and each half later, to 2 %: a tilt of .05 rad lengthens it by .5 %."""
    model, data = load(_rocker(0.05), 1e-3)
    tilts = []
    for _ in range(round(2 * PERIOD / 1e-3)):
        mujoco.mj_step(model, data)
        tilts.append(2 * math.atan2(data.qpos[5], data.qpos[3]))
    levels = 1e-3 * (1 + np.flatnonzero(np.array(tilts[:-1]) * np.array(tilts[1:]) < 0))
    assert levels[:4] == pytest.approx(PERIOD * (0.25 + 0.5 * np.arange(4)), abs=0.02 * PERIOD)


def test_rays_meet_it_at_its_semi_axes() -> None:
    model, data = load('<body><geom type="ellipsoid" size=".1 .2 .3"/></body>', 1e-3)
    mujoco.mj_forward(model, data)
    met = np.zeros(1, np.int32)
    for axis, half in zip(np.eye(3), (0.1, 0.2, 0.3), strict=True):
        assert mujoco.mj_ray(model, data, 2 * axis, -axis, None, 1, -1, met, None) == pytest.approx(2 - half, abs=1e-12)
