"""Figures of data sheets in SI units, by hand and by the standard's own examples."""

import math

import numpy as np
import pytest

from harness.metrics.allan import expected_variance
from harness.scene import AxisNoise
from harness.sensors import data_sheet as sheet


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        # One degree an hour is 4.848 urad/s; the earth turns at 15.041 of them.
        (sheet.from_deg_per_hour(15.041067), 7.292115e-5),
        (sheet.from_deg_per_second(180.0), math.pi),
        # .3 deg/sqrt(h) is 5e-3 deg/s/sqrt(Hz).
        (sheet.from_deg_per_root_hour(0.3), sheet.from_deg_per_second(5e-3)),
        (sheet.from_metre_per_second_per_root_hour(0.06), 1e-3),
        (sheet.from_ug(100.0), 9.80665e-4),
        (sheet.from_mg(2.0), 1.96133e-2),
        (sheet.from_g(16.0), 156.9064),
        # 1 deg/h/sqrt(h): the rate walks by one degree an hour in an hour.
        (sheet.from_deg_per_hour_per_root_hour(1.0) * math.sqrt(3600.0), sheet.from_deg_per_hour(1.0)),
        (sheet.quantisation_from_bits(16.0, 16), 32.0 / 65536.0),
        (sheet.floor_from_coefficient(1.0), 0.66428),
        (sheet.density_from_spread(0.1, 100.0), 0.01),
        (sheet.two_sided(1.0), 0.70711),
    ],
)
def test_figures_are_those_by_hand(found: float, expected: float) -> None:
    assert found == pytest.approx(expected, rel=1e-5)


def test_levels_read_off_an_allan_plot_give_back_their_process() -> None:
    """Read off at 4 s each, the law has those deviations there: N/sqrt(t), K sqrt(t/3) (1 + 1/(2 m^2)) for discrete steps."""
    interval, m = 0.01, 400
    white = AxisNoise(density=sheet.density_from_allan(2e-3, 4.0))
    walk = AxisNoise(random_walk=sheet.random_walk_from_allan(5e-3, 4.0))
    assert math.sqrt(expected_variance(white, m, 40_000, interval)[0]) == pytest.approx(2e-3, rel=1e-9)
    assert math.sqrt(expected_variance(walk, m, 40_000, interval)[0]) == pytest.approx(5e-3, rel=1e-5)


def test_a_one_sided_density_has_the_variance_of_its_band() -> None:
    """A one-sided density d over the band f/2 has the variance d^2 f/2, which N^2 f of the two-sided one must be."""
    rate, d = 200.0, 3e-3
    assert sheet.two_sided(d) ** 2 * rate == pytest.approx(d**2 * rate / 2)
    assert np.isfinite(sheet.two_sided(0.0))
