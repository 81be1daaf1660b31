"""Metrics of cameras: what is sound passes in many seeds, and each planted fault is seen by the metric made for it."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.cameras import (
    BANDS,
    depth_correlation_score,
    depth_error_max,
    depth_error_median,
    depth_error_rms,
    depth_lost_but_answered_share,
    depth_mean_score,
    depth_missing_score,
    depth_spread_score,
    disparity_step_error,
    pixel_error,
    range_unwrapped_share,
    silhouette_iou,
)
from plumbline.harness.scene import (
    Body,
    Box,
    Camera,
    DepthCamera,
    PlacedShape,
    Plane,
    Scene,
    Sphere,
    StereoNoise,
    StructuredLightNoise,
    TimeOfFlightNoise,
    axis_angle,
)
from plumbline.harness.sensors.depth_camera import answer
from plumbline.harness.sensors.reader import generator
from plumbline.harness.sensors.true_views import true_frames, true_sight
from plumbline.harness.trajectory import Floats, State, Trajectory

FALSE_ALARM = 5.0
STEREO = StereoNoise(baseline=0.2, disparity_sigma=0.1, disparity_step=0.125, missing=0.05)
PATTERN = StructuredLightNoise(baseline=0.1, disparity_sigma=0.05, disparity_step=0.05, missing=0.05)
PHASE = TimeOfFlightNoise(range_sigma=0.01, range_sigma_slope=0.004, unambiguous_range=4.0, missing=0.05)
LAWS = (STEREO, PATTERN, PHASE)
CAMERA = DepthCamera(
    name="d", body="world", rate=10.0, width=80, height=60, focal_x=60.0, focal_y=60.0, centre_x=40.0, centre_y=30.0
)
BODIES = (
    Body(
        name="slope",
        motion="static",
        collision=(PlacedShape(shape=Plane()),),
        p_WB=(0, 0, 5),
        q_WB=axis_angle((1, 0.2, 0), 2.4),
    ),
    Body(name="ball", motion="static", collision=(PlacedShape(shape=Sphere(radius=0.4)),), p_WB=(0.5, 0.1, 2.0)),
    Body(name="box", motion="static", collision=(PlacedShape(shape=Box(half_extents=(0.3, 0.4, 0.2))),), p_WB=(-0.6, 0.0, 2.2)),
)


def _scene(law: Any = None) -> Scene:
    return Scene(bodies=BODIES, sensors=(replace(CAMERA, noise=law),))


def _of(streams: dict[str, Floats]) -> Trajectory:
    return replace(Trajectory.of(np.zeros(1), 3), streams=streams)


def _truth(law: Any = None, frames: int = 3) -> dict[str, Floats]:
    """In a dictionary of the caller's own; its arrays are everybody's."""
    return dict(_true_frames(law, frames))


@cache
def _true_frames(law: Any, frames: int) -> dict[str, Floats]:
    camera: Any = _scene(law).sensors[0]
    found = true_frames(_scene(law), camera, np.arange(frames) / 10)
    for array in found.values():
        array.flags.writeable = False
    return found


@cache
def _sight(law: Any) -> Any:
    """What the camera of a law sees at the start."""
    scene = _scene(law)
    camera: Any = scene.sensors[0]
    return true_sight(scene, camera, State.initial(scene))


def _answered(law: Any, made_by: Any = None, seed: int = 1, frames: int = 3) -> dict[str, Floats]:
    """Frames of a sound camera of law `made_by` (the same unless told) whose scene says `law`."""
    truth, made_by = _truth(law, frames), made_by or law
    sight = _sight(made_by)
    normal, uniform = generator(seed, "d", "depth"), generator(seed, "d", "missing")
    found = []
    for lost in truth["d/lost"]:
        depth = answer(made_by, sight, normal.standard_normal(len(sight.depth))).reshape(lost.shape)
        found.append(np.where((lost > 0) | (uniform.random(lost.shape) < made_by.missing), np.nan, depth))
    return truth | {"d/depth": np.array(found)}


def _all(law: Any, streams: dict[str, Floats], truth: dict[str, Floats] | None = None) -> dict[str, float]:
    found = {}
    for metric in (
        depth_mean_score,
        depth_spread_score,
        depth_missing_score,
        depth_lost_but_answered_share,
        disparity_step_error,
    ):
        try:
            found[metric.name] = metric(_scene(law), _of(streams), _of(_truth(law) if truth is None else truth))
        except NotMeasurable:
            found[metric.name] = np.nan
    return found


@pytest.mark.parametrize("seeds", [30, pytest.param(100, marks=pytest.mark.slow)])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.type)
def test_noise_of_the_law_raises_no_alarm_in_many_seeds_and_scores_as_normal_variables_do(law: Any, seeds: int) -> None:
    truth = _truth(law)
    rows = [_all(law, _answered(law, seed=seed), truth) for seed in range(seeds)]
    scores = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    missing = scores["depth_missing_score"]
    assert missing.max() < FALSE_ALARM
    # |z| of a normal variable has the mean sqrt(2/pi) and the variance 1 - 2/pi.
    assert missing.mean() == pytest.approx(np.sqrt(2 / np.pi), abs=5 * np.sqrt((1 - 2 / np.pi) / seeds))
    from scipy.stats import norm

    # The largest of n such |z| lies below x with the probability (2 Phi(x) - 1)^n: uniform if the scores are what they say.
    for name in ("depth_mean_score", "depth_spread_score"):
        assert scores[name].max() < FALSE_ALARM
        level = (2 * norm.cdf(scores[name]) - 1) ** BANDS
        assert level.mean() == pytest.approx(0.5, abs=5 * np.sqrt(1 / 12 / seeds))
    assert max(depth_correlation_score(_scene(law), _of(_answered(law, seed=seed))) for seed in range(20)) < FALSE_ALARM
    if law is not PHASE:
        assert scores["disparity_step_error"].max() < 1e-12
        assert scores["depth_lost_but_answered_share"].max() == 0.0


@pytest.mark.parametrize(
    ("law", "wrong"),
    [
        (STEREO, {"disparity_sigma": 0.2}),
        (STEREO, {"baseline": 0.1}),
        (PATTERN, {"disparity_sigma": 0.0}),
        (PATTERN, {"disparity_step": 0.2}),
        (PHASE, {"range_sigma": 0.02}),
        (PHASE, {"range_sigma_slope": 0.0}),
        (PHASE, {"range_sigma": 0.018, "range_sigma_slope": 0.0}),
    ],
)
def test_a_wrong_spread_is_seen_even_where_only_its_growth_with_depth_is_wrong(law: Any, wrong: dict[str, float]) -> None:
    streams = _answered(law, replace(law, **wrong))
    assert depth_spread_score(_scene(law), _of(streams)) > FALSE_ALARM


def test_a_bias_of_a_quarter_of_sigma_in_one_band_is_seen_in_the_mean() -> None:
    streams = _answered(STEREO)
    ideal, depth = streams["d/depth_ideal"], streams["d/depth"]
    near = ideal < np.quantile(ideal[np.isfinite(ideal)], 1 / BANDS)
    shifted = np.where(near, 1.0 / (1.0 / depth + 0.25 * 0.1 / (60.0 * 0.2)), depth)
    assert depth_mean_score(_scene(STEREO), _of(streams | {"d/depth": shifted})) > FALSE_ALARM


@pytest.mark.parametrize("axis", [0, 1, 2], ids=["frames", "rows", "columns"])
def test_noise_that_neighbours_share_is_seen_in_the_correlation_alone(axis: int) -> None:
    law = replace(STEREO, disparity_step=0.0, missing=0.0)
    sound = _answered(law)
    ideal = sound["d/depth_ideal"]
    normal = np.random.default_rng(4).standard_normal(ideal.shape)
    # Half of each deviation is the neighbour's: of the right spread, and no longer its own.
    shared = (normal + np.roll(normal, 1, axis=axis)) / np.sqrt(2)
    depth = np.where(np.isnan(sound["d/depth"]), np.nan, 1.0 / (1.0 / ideal + 0.1 / (60.0 * 0.2) * shared))
    assert depth_correlation_score(_scene(law), _of(sound)) < FALSE_ALARM
    assert depth_correlation_score(_scene(law), _of(sound | {"d/depth": depth})) > FALSE_ALARM


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.type)
@pytest.mark.parametrize("rate", [0.0, 0.03, 0.1])
def test_a_wrong_share_of_missing_pixels_is_seen(law: Any, rate: float) -> None:
    assert _all(law, _answered(law, replace(law, missing=rate)))["depth_missing_score"] > FALSE_ALARM


def test_depths_without_a_second_view_are_seen_and_so_is_a_shadow_where_none_should_be() -> None:
    truth = _truth(STEREO)
    assert truth["d/lost"].mean() > 0.02
    sound = _answered(STEREO)
    see_through = sound | {"d/depth": np.where(truth["d/lost"] > 0, 2.0, sound["d/depth"])}
    assert _all(STEREO, see_through)["depth_lost_but_answered_share"] == 1.0
    wider = truth["d/lost"].copy()
    wider[:, :, :-3] = np.maximum(wider[:, :, :-3], truth["d/lost"][:, :, 3:])
    dark = sound | {"d/depth": np.where(wider > 0, np.nan, sound["d/depth"])}
    assert _all(STEREO, dark)["depth_missing_score"] > FALSE_ALARM


def test_a_law_without_missing_pixels_allows_none() -> None:
    law = replace(STEREO, missing=0.0)
    assert _all(law, _answered(law))["depth_missing_score"] == 0.0
    assert _all(law, _answered(law, replace(law, missing=0.001)))["depth_missing_score"] == np.inf


@pytest.mark.parametrize(("step", "error"), [(0.025, 0.5), (0.1, 1.0), (0.0, 0.4), (0.04, 0.1)])
def test_a_step_that_is_finer_coarser_or_none_is_seen(step: float, error: float) -> None:
    streams = _answered(PATTERN, replace(PATTERN, disparity_step=step))
    assert disparity_step_error(_scene(PATTERN), _of(streams)) >= error - 1e-9


def test_ranges_that_never_wrap_are_seen() -> None:
    sound = range_unwrapped_share(_scene(PHASE), _of(_answered(PHASE)))
    assert sound == 0.0
    endless = range_unwrapped_share(_scene(PHASE), _of(_answered(PHASE, replace(PHASE, unambiguous_range=None))))
    assert endless > 0.1
    near = replace(PHASE, unambiguous_range=50.0)
    with pytest.raises(NotMeasurable, match="nothing beyond its unambiguous range 50"):
        range_unwrapped_share(_scene(near), _of(_answered(near)))


def test_sound_frames_have_no_error_and_whole_silhouettes() -> None:
    truth = _of(_truth())
    for metric in (depth_error_median, depth_error_rms, depth_error_max, pixel_error):
        assert metric(_scene(), truth, truth) == 0.0
    assert silhouette_iou(_scene(), truth, truth) == 1.0


def test_range_taken_for_depth_is_seen_in_the_median_of_the_worst_body() -> None:
    truth = _truth()
    slant = np.sqrt(1 + ((np.arange(80) + 0.5 - 40) / 60)[None, :] ** 2 + ((np.arange(60) + 0.5 - 30) / 60)[:, None] ** 2)
    assert depth_error_median(_scene(), _of(truth | {"d/depth_ideal": truth["d/depth_ideal"] * slant}), _of(truth)) > 0.05


def test_one_bad_ball_is_not_hidden_by_a_wide_wall_and_one_bad_pixel_shows_in_the_maximum() -> None:
    truth = _truth()
    ball = truth["d/body"] == 1
    off = _of(truth | {"d/depth_ideal": truth["d/depth_ideal"] + 0.01 * ball})
    assert depth_error_median(_scene(), off, _of(truth)) == pytest.approx(0.01, rel=1e-12)
    seen = np.isfinite(truth["d/depth_ideal"])
    assert depth_error_rms(_scene(), off, _of(truth)) == pytest.approx(0.01 * np.sqrt(ball.sum() / seen.sum()), rel=1e-12)
    spot = truth["d/depth_ideal"].copy()
    spot[1, 30, 50] += 0.3
    assert depth_error_max(_scene(), _of(truth | {"d/depth_ideal": spot}), _of(truth)) == pytest.approx(0.3, rel=1e-12)
    assert depth_error_median(_scene(), _of(truth | {"d/depth_ideal": spot}), _of(truth)) == 0.0


def _moved(truth: dict[str, Floats], pixels: int) -> dict[str, Floats]:
    return truth | {name: np.roll(truth[name], pixels, axis=2) for name in ("d/body", "d/depth_ideal")}


def test_a_picture_moved_by_a_pixel_is_seen_in_silhouettes_and_centroids() -> None:
    truth = _truth()
    moved = _of(_moved(truth, 1))
    assert pixel_error(_scene(), moved, _of(truth)) == pytest.approx(1.0, abs=0.3)
    # A box of 0.6 m at 2 m is 18 pixels wide: 17 of 19 stay.
    assert silhouette_iou(_scene(), moved, _of(truth)) == pytest.approx(17 / 19, abs=0.03)


def test_a_pixel_centre_half_a_pixel_off_is_seen() -> None:
    truth = _truth(frames=1)
    camera: Any = replace(CAMERA, centre_x=40.5, centre_y=30.5)
    off = true_frames(_scene(), camera, np.zeros(1))
    assert pixel_error(_scene(), _of(off), _of(truth)) > 0.4


def test_bodies_that_are_missing_or_exchanged_leave_nothing_of_a_silhouette() -> None:
    truth = _truth()
    gone = _of(truth | {"d/body": np.where(truth["d/body"] == 1, -1, truth["d/body"])})
    assert silhouette_iou(_scene(), gone, _of(truth)) == 0.0
    assert np.isnan(pixel_error(_scene(), gone, _of(truth)))
    swapped = np.choose(truth["d/body"].astype(int) + 1, [-1, 0, 2, 1])
    assert silhouette_iou(_scene(), _of(truth | {"d/body": swapped}), _of(truth)) == 0.0


def test_a_bad_number_is_swallowed_by_no_metric() -> None:
    truth = _truth(STEREO)
    ideal = truth["d/depth_ideal"].copy()
    ideal[2, 20, 40] = np.nan
    bad = _of(_answered(STEREO) | {"d/depth_ideal": ideal})
    for metric in (depth_error_median, depth_error_rms, depth_error_max):
        assert np.isnan(metric(_scene(STEREO), bad, _of(truth))), metric.name
    for metric in (depth_mean_score, depth_spread_score, depth_correlation_score):
        assert np.isnan(metric(_scene(STEREO), bad, _of(truth))), metric.name
    for metric in (depth_missing_score, depth_lost_but_answered_share, disparity_step_error):
        assert np.isnan(metric(_scene(STEREO), bad, _of(truth))), metric.name
    wrapped = _of(_answered(PHASE) | {"d/depth_ideal": ideal})
    assert np.isnan(range_unwrapped_share(_scene(PHASE), wrapped, None))


def test_a_colour_cameras_picture_is_judged_by_its_depth() -> None:
    camera = Camera(
        name="c", body="world", rate=10.0, width=80, height=60, focal_x=60.0, focal_y=60.0, centre_x=40.0, centre_y=30.0
    )
    scene = Scene(bodies=BODIES, sensors=(camera,))
    truth = true_frames(scene, camera, np.zeros(1))
    off = _of(truth | {"c/depth": truth["c/depth"] + 0.02})
    assert depth_error_median(scene, off, _of(truth)) == pytest.approx(0.02, rel=1e-12)
    assert silhouette_iou(scene, off, _of(truth)) == 1.0


def test_missing_cameras_streams_truths_and_laws_are_not_measurable() -> None:
    truth = _of(_truth())
    blind = replace(_scene(), sensors=())
    for metric in (
        depth_error_median,
        silhouette_iou,
        pixel_error,
        depth_missing_score,
        depth_mean_score,
        disparity_step_error,
    ):
        with pytest.raises(NotMeasurable):
            metric(blind, truth, truth)
    with pytest.raises(NotMeasurable, match="the truth has no stream 'd/body'"):
        depth_error_median(_scene(), truth)
    with pytest.raises(NotMeasurable, match="was not recorded"):
        silhouette_iou(_scene(), _of({}), truth)
    later = _of(_truth() | {"d/time": np.arange(3) / 10 + 0.05})
    with pytest.raises(NotMeasurable, match="other times"):
        pixel_error(_scene(), later, truth)
    with pytest.raises(NotMeasurable, match="no stream 'd/lost'"):
        depth_missing_score(_scene(STEREO), _of(_answered(STEREO)), truth)
    coarse = replace(STEREO, disparity_step=0.5)
    with pytest.raises(NotMeasurable, match=r"a step of 0\.5 px"):
        depth_spread_score(_scene(coarse), _of(_answered(coarse)))
    dim = replace(PHASE, shot_sigma=0.01)
    with pytest.raises(NotMeasurable, match="more than depth"):
        depth_spread_score(_scene(dim), _of(_answered(dim)))
