"""What metrics are called in sentences."""

import pytest

from plumbline.harness.metric.titles import metric_title


@pytest.mark.parametrize(
    ("name", "title"),
    [
        ("joint_gap", "joint gap"),
        ("position_error_max", "largest position error"),
        ("orbit_energy_drift_staggered_max", "largest staggered orbit energy drift"),
        ("rms_speed", "rms speed"),
        ("range_error_rms", "rms range error"),
        ("silhouette_iou", "silhouette IoU"),
        ("creep #2", "creep (2)"),
        ("max", "max"),
        ("", ""),
    ],
)
def test_a_name_is_said_in_words_with_its_way_of_summing_up_first(name: str, title: str) -> None:
    assert metric_title(name) == title
