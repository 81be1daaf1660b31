"""What reads sensors is broken in one way, and the check of mounted sensors that names it fails; sound, it passes."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter.rotations import conjugate
from plumbline.harness.conformance import CHECKS, run_check
from plumbline.harness.scene import multiply
from plumbline.harness.sensors import depth_camera, imu, lidar, spinning
from tests.conformance.engines import adapter

CHECK = {check.name: check for check in CHECKS}
Spoil = Callable[[Callable[..., Any]], Callable[..., Any]]


def _turned_first(sound: Callable[..., Any]) -> Callable[..., Any]:
    """The turn of the mount and that of its body multiplied in the other order."""

    def broken(row: Any, p_BS: Any, q_BS: Any) -> Any:
        p_WS, _ = sound(row, p_BS, q_BS)
        w, x, y, z = row[3:7].tolist()
        return p_WS, np.array(multiply(q_BS, (w, x, y, z)))

    return broken


def _least_range_dropped(sound: Callable[..., Any]) -> Callable[..., Any]:
    return lambda sensor, *more: sound(replace(sensor, min_range=0.0), *more)


def _askew_dropped(sound: Callable[..., Any]) -> Callable[..., Any]:
    return lambda sensor, *more: sound(replace(sensor, q_BS=(1.0, 0.0, 0.0, 0.0)), *more)


def _mounted_backwards(sound: Callable[..., Any]) -> Callable[..., Any]:
    return lambda sensor, *more: sound(replace(sensor, q_BS=conjugate(sensor.q_BS)), *more)


def _units_exchanged(sound: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *told: sound(*told)[::-1]


def _one_focal_length(sound: Callable[..., Any]) -> Callable[..., Any]:
    return lambda camera: sound(replace(camera, focal_y=camera.focal_x))


def _twice_as_strong(sound: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *told: 2.0 * sound(*told)


def _without_noise(sound: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *told: told[1:3]


def _twice_as_wide(sound: Callable[..., Any]) -> Callable[..., Any]:
    return lambda directions, divergence: sound(directions, 2.0 * divergence)


def _all_at_the_stamp(sound: Callable[..., Any]) -> Callable[..., Any]:
    return lambda early, late, interval, share: sound(early, late, interval, np.ones_like(share))


BROKEN: tuple[tuple[str, Any, str, Spoil], ...] = (
    ("lidar_reads_between_its_bounds", lidar, "pose_of", _turned_first),
    ("depth_camera_reads_between_its_bounds", depth_camera, "pose_of", _turned_first),
    ("lidar_reads_between_its_bounds", lidar, "ideal", _least_range_dropped),
    ("inertial_readings_on_a_turning_body", imu, "ideal", _askew_dropped),
    ("inertial_readings_on_a_turning_body", imu, "ideal", _mounted_backwards),
    ("inertial_readings_on_a_turning_body", imu, "ideal", _units_exchanged),
    ("depth_camera_reads_between_its_bounds", depth_camera, "pixel_rays", _one_focal_length),
    ("inertial_noise_has_its_strength", imu, "three_axes", _twice_as_strong),
    ("lidar_noise_has_its_strength", lidar, "noisy", _without_noise),
    ("wide_beams_read_the_mean_of_their_cone", lidar, "spread", _twice_as_wide),
    ("spinning_lidar_fires_column_by_column", spinning, "pose_between", _all_at_the_stamp),
)


@pytest.mark.parametrize(("name", "module", "function", "spoil"), BROKEN)
def test_a_reader_that_is_broken_is_seen_by_check(
    name: str, module: Any, function: str, spoil: Spoil, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine = adapter("mujoco")
    assert run_check(engine, "tuned", CHECK[name]).status == "passed"
    monkeypatch.setattr(module, function, spoil(getattr(module, function)))
    outcome = run_check(engine, "tuned", CHECK[name])
    assert outcome.status == "failed"
    assert "Error:" not in outcome.message, "it is to fail by its numbers"


def test_every_check_of_readings_is_broken_here_or_by_a_planted_fault() -> None:
    broken = {name for name, *_ in BROKEN} | {"camera_is_mounted_on_what_turns"}
    assert {check.name for check in CHECKS if check.subject[1] in ("mounted", "mounted_cameras")} == broken
