"""Head-on pairs without restitution in MuJoCo's own words: what is left of the closing speed, by mass and damping ratio.

Of a closing speed c a share s is left; the lighter of masses r : 1 then errs by s c r/(1 + r), which grows with r as if the
mass ratio made it worse.
"""

import numpy as np
import pytest

from tests.vendor.mujoco_world import load, mujoco

pytestmark = pytest.mark.mujoco

CLOSING, RADIUS, DT = 3.0, 0.1, 1 / 240
RATIOS = (1.0, 8.7, 1e3, 1e6)
TUNED, DAMPED = 'solref="0.02 1.2" solimp="0.999 0.999 0.001"', 'solref="0.02 2" solimp="0.999 0.999 0.001"'


def left(ratio: float, solref: str) -> tuple[float, float]:
    """The largest share of the closing speed that is left, and the largest error [m/s], of 16 pairs at phases of the step."""
    balls = "".join(
        f'<body pos="{side * (RADIUS + (0.3 + 0.0007 * row) / 2)!r} {row} 0"><freejoint/>'
        f'<geom type="sphere" size="{RADIUS}" mass="{mass!r}" condim="1" {solref}/></body>'
        for row in range(16)
        for side, mass in ((-1, ratio), (1, 1.0))
    )
    model, data = load(balls, DT, gravity=0.0)
    data.qvel[0::12], data.qvel[6::12] = 2.0, 2.0 - CLOSING
    mujoco.mj_step(model, data, 120)
    heavy, light = data.qvel[0::12], data.qvel[6::12]
    together = (2.0 * ratio + 2.0 - CLOSING) / (ratio + 1)
    return float(np.max(light - heavy)) / CLOSING, float(np.max(np.abs(light - together)))


@pytest.mark.parametrize(("solref", "share"), [(TUNED, 0.111), (DAMPED, 0.049), ("", 0.144)])
def test_what_is_left_of_the_closing_speed_is_the_same_at_every_mass_ratio(solref: str, share: float) -> None:
    assert [left(ratio, solref)[0] for ratio in RATIOS] == pytest.approx([share] * len(RATIOS), abs=1e-3)


@pytest.mark.parametrize("ratio", RATIOS)
def test_the_error_of_the_lighter_is_that_share_times_r_over_1_plus_r(ratio: float) -> None:
    share, error = left(ratio, TUNED)
    assert error == pytest.approx(CLOSING * share * ratio / (1 + ratio), rel=1e-3)


def test_a_damping_ratio_of_2_keeps_the_largest_ratio_within_half_of_a_tenth_of_the_closing_speed() -> None:
    assert left(1e6, TUNED)[1] > 0.1 * CLOSING > 2 * left(1e6, DAMPED)[1]
