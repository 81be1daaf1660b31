"""Cameras at the door: what no camera can be is refused with the field's name."""

import math
from typing import Any

import pytest

from plumbline.harness.scene import Camera, DepthCamera, SceneError, StereoNoise, StructuredLightNoise, TimeOfFlightNoise

PLACE: dict[str, Any] = {"name": "eye", "body": "b", "rate": 10.0}


@pytest.mark.parametrize("kind", [Camera, DepthCamera])
@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("width", 0),
        ("height", -3),
        ("width", 20_000),
        ("width", 64.5),
        ("focal_x", 0.0),
        ("focal_y", -500.0),
        ("focal_x", math.nan),
        ("centre_x", math.inf),
        ("centre_y", math.nan),
        ("rate", 0.0),
        ("p_BS", (0.0, math.nan, 0.0)),
        ("q_BS", (0.0, 0.0, 0.0, 0.0)),
    ],
)
def test_a_camera_without_a_picture_or_a_place_is_refused(kind: Any, field: str, value: object) -> None:
    with pytest.raises(SceneError, match=field):
        kind(**PLACE | {field: value})


@pytest.mark.parametrize(("near", "far"), [(1.0, 1.0), (2.0, 1.0)])
def test_a_far_bound_that_does_not_lie_beyond_the_near_one_is_refused(near: float, far: float) -> None:
    with pytest.raises(SceneError, match=rf"sensor 'eye': far {far} m does not lie beyond near {near} m"):
        DepthCamera(**PLACE, near=near, far=far)


@pytest.mark.parametrize(
    ("field", "value"), [("near", 0.0), ("near", math.nan), ("far", math.inf), ("seen_by", "sonar"), ("principle", "stereo")]
)
def test_bounds_and_sources_that_are_none_are_refused(field: str, value: object) -> None:
    with pytest.raises(SceneError, match=field):
        DepthCamera(**PLACE | {field: value})


BASELINE: dict[str, Any] = {"baseline": 0.1}


@pytest.mark.parametrize(
    ("law", "sound", "field", "value"),
    [
        (StereoNoise, BASELINE, "baseline", 0.0),
        (StereoNoise, BASELINE, "baseline", math.nan),
        (StereoNoise, BASELINE, "disparity_sigma", -0.1),
        (StereoNoise, BASELINE, "disparity_step", math.inf),
        (StereoNoise, BASELINE, "least_texture", 1.5),
        (StereoNoise, BASELINE, "steepest", 0.0),
        (StereoNoise, BASELINE, "steepest", 1.6),
        (StereoNoise, BASELINE, "missing", 1.01),
        (StereoNoise, BASELINE, "range_sigma", 0.1),
        (StructuredLightNoise, BASELINE, "baseline", -0.1),
        (StructuredLightNoise, BASELINE, "disparity_sigma", math.nan),
        (StructuredLightNoise, BASELINE, "least_signal", -1e-9),
        (StructuredLightNoise, BASELINE, "least_contrast", math.nan),
        (StructuredLightNoise, BASELINE, "missing", -0.1),
        (TimeOfFlightNoise, {}, "range_sigma", -0.01),
        (TimeOfFlightNoise, {}, "range_sigma_slope", math.nan),
        (TimeOfFlightNoise, {}, "shot_sigma", -1.0),
        (TimeOfFlightNoise, {}, "unambiguous_range", 0.0),
        (TimeOfFlightNoise, {}, "multipath", 1.2),
        (TimeOfFlightNoise, {}, "missing", 2.0),
    ],
)
def test_a_law_of_noise_that_cannot_be_is_refused_by_its_field(
    law: Any, sound: dict[str, Any], field: str, value: object
) -> None:
    law(**sound)
    with pytest.raises(SceneError, match=field):
        law(**sound | {field: value})


def test_a_second_path_without_a_wavelength_is_refused() -> None:
    with pytest.raises(SceneError, match=r"multipath 0\.3 without unambiguous_range"):
        TimeOfFlightNoise(multipath=0.3)


def test_the_principle_is_told_by_the_noises_type() -> None:
    camera = DepthCamera(**PLACE, noise={"type": "structured_light", "baseline": 0.075})
    assert camera.noise == StructuredLightNoise(baseline=0.075)
    with pytest.raises(SceneError, match="ultrasound"):
        DepthCamera(**PLACE, noise={"type": "ultrasound"})
