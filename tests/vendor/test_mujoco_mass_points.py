"""MuJoCo compiles no free body without inertia, in its own words."""

import pytest

from tests.vendor.mujoco_world import load

pytestmark = pytest.mark.mujoco


def test_a_free_body_without_inertia_is_refused_and_one_of_next_to_none_is_not() -> None:
    inertial = '<inertial pos="0 0 0" mass="1" diaginertia="{0} {0} {0}"/>'
    with pytest.raises(ValueError, match="mass and inertia of moving bodies must be larger than mjMINVAL"):
        load(f"<body><freejoint/>{inertial.format(0)}</body>", 1e-3)
    load(f"<body><freejoint/>{inertial.format(1e-12)}</body>", 1e-3)
