"""Parameters of sensors that make no sense are refused at the door, by the name of the field."""

from typing import Any

import pytest

from plumbline.harness.scene import AxisNoise, Imu, Lidar, LidarNoise, SceneError

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("kind", "field", "value"),
    [
        *(
            (AxisNoise, field, value)
            for field in ("density", "instability", "random_walk", "quantisation")
            for value in (-1e-9, NAN, INF)
        ),
        *((AxisNoise, field, value) for field in ("bias", "scale_error") for value in (NAN, INF)),
        *((AxisNoise, field, value) for field in ("instability_time", "saturation") for value in (0.0, -1.0, NAN, INF)),
        (AxisNoise, "misalignment", (0.0, NAN, 0.0)),
        *(
            (LidarNoise, field, value)
            for field in ("range_sigma", "range_sigma_slope", "intensity_sigma")
            for value in (-0.01, NAN, INF)
        ),
        *((LidarNoise, field, value) for field in ("dropout", "least_intensity") for value in (-0.1, 1.1, NAN)),
    ],
)
def test_a_number_of_a_noise_law_outside_its_range_is_refused_by_name(kind: Any, field: str, value: Any) -> None:
    with pytest.raises(SceneError, match=field):
        kind(**{field: value})


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("latency", -0.01),
        ("latency", NAN),
        ("rate", 0.0),
        ("rate", INF),
        ("reading", "magic"),
        ("q_BS", (1.0, 1.0, 0.0, 0.0)),
        ("p_BS", (0, 0, NAN)),
    ],
)
def test_an_inertial_sensor_that_cannot_be_is_refused_by_name(field: str, value: Any) -> None:
    with pytest.raises(SceneError, match=field):
        Imu(**{"name": "i", "body": "b", "rate": 100.0, field: value})


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"min_range": 5.0, "max_range": 5.0}, "sensor 'l': min_range 5.0 m reaches max_range 5.0 m"),
        ({"min_range": -1.0}, "min_range"),
        ({"max_range": INF}, "max_range"),
        ({"elevations": (0.1, 0.2), "channels": 3}, "sensor 'l': 2 elevations for 3 channels"),
        ({"elevations": (0.1, 1.6), "channels": 2}, "elevations"),
        ({"elevation_low": 0.2, "elevation_high": 0.1}, "sensor 'l': elevation_low 0.2 lies above elevation_high 0.1"),
        ({"divergence": -0.1}, "divergence"),
        ({"divergence": 1.0}, "divergence"),
        ({"divergence": NAN}, "divergence"),
        ({"channels": 0}, "channels"),
        ({"columns": 0}, "columns"),
    ],
)
def test_a_range_finder_that_cannot_be_is_refused_by_name(fields: dict[str, Any], said: str) -> None:
    with pytest.raises(SceneError, match=said):
        Lidar(**{"name": "l", "body": "b", "rate": 10.0, **fields})


def test_a_bound_below_one_step_of_the_digits_is_refused() -> None:
    with pytest.raises(SceneError, match=r"saturation 0\.1 lies below quantisation 0\.2"):
        AxisNoise(saturation=0.1, quantisation=0.2)
