"""Recordings of sensors: pictures, depth, clouds and plots stand in the file as they stood in the store."""

import io
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun.blueprint as rrb
from PIL import Image

from plumbline.harness.store.store import Store
from plumbline.reports.recordings import write_recordings
from plumbline.reports.recordings.blueprint import layout
from plumbline.reports.recordings.camera import framing
from plumbline.reports.recordings.pixels import srgb
from plumbline.reports.recordings.runs import stage_of
from plumbline.reports.recordings.sensors import MOST_PIXELS, beams, lit, sensed, shown_frames
from plumbline.reports.recordings.viewer import viewer_command
from tests.recorded_folder import Read
from tests.sensor_folder import CASE, PIXELS, sensing, swinging, write_sensor_folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_sensor_folder(tmp_path_factory.mktemp("recordings") / "run")


@pytest.fixture(scope="module")
def path(folder: Path) -> Path:
    return write_recordings(folder)[0]


@pytest.fixture(scope="module")
def read(path: Path) -> Read:
    return Read(path)


def test_the_recording_is_whole(path: Path) -> None:
    done = subprocess.run([*viewer_command(), "rrd", "verify", str(path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_camera_stands_where_its_body_carries_it_with_its_own_lens(read: Read) -> None:
    where = "/sensors/camera/camera/reference/tuned"
    (matrix,) = read.column(where, "Pinhole:image_from_camera")
    # Columns first: focal lengths on the diagonal, the principal point in the last column.
    assert np.reshape(matrix, (3, 3)) == pytest.approx(np.array([[30.0, 0, 0], [0, 30.0, 0], [16.0, 12.0, 1]]))
    places = read.array(where, "Transform3D:translation").reshape(-1, 3)
    assert places == pytest.approx(np.tile([1.0, 2.0, 3.0], (10, 1)))
    turns = read.array(where, "Transform3D:quaternion").reshape(-1, 4)
    angle = swinging(np.arange(10) / 10.0)[0]
    assert turns[:, 2:] == pytest.approx(np.stack([np.sin(angle / 2), np.cos(angle / 2)], axis=1), abs=1e-6)


def content(row: Any) -> bytes:
    """The bytes of one blob."""
    return bytes(np.ravel(row).astype(np.uint8))


@pytest.mark.parametrize("source", ["reference/tuned", "mujoco/tuned", "truth"])
def test_colours_are_srgb_pictures_of_each_engine_and_of_the_truth(read: Read, source: str) -> None:
    blobs = read.column(f"/sensors/camera/camera/{source}/colour", "EncodedImage:blob")
    assert len(blobs) == 10
    with Image.open(io.BytesIO(content(blobs[0]))) as picture:
        assert np.array_equal(np.asarray(picture), srgb(sensing(1).streams["camera/colour"][0]))


def depths(read: Read, source: str) -> Any:
    rows = read.column(f"/sensors/depth/camera/{source}/depth", "DepthImage:buffer")
    return np.array([np.frombuffer(content(row), dtype=np.float32) for row in rows]).reshape(-1, *PIXELS)


def test_depth_is_in_metres_with_nothing_where_nothing_was_measured(read: Read) -> None:
    assert read.column("/sensors/depth/camera/reference/tuned/depth", "DepthImage:meter")[0] == [1.0]
    expected = sensing(1).streams["depth/depth"].astype(np.float32)
    assert np.isnan(expected).any()
    assert np.array_equal(depths(read, "reference/tuned"), np.where(np.isnan(expected), 0.0, expected))
    assert depths(read, "truth")[0, 0, :3] == pytest.approx([2.0, 2.2, 2.4])


def test_points_are_those_of_the_sensor_and_brighter_where_more_light_came_back(read: Read) -> None:
    where = "/sensors/lidar/points/reference/tuned"
    points = read.column(where, "Points3D:positions")
    streams = sensing(1).streams
    assert [len(cloud) for cloud in points] == np.isfinite(streams["lidar/range"]).sum(axis=(1, 2)).tolist()
    # At time 0 the carrier is not turned: the planted cloud lies along +x of the place of the sensor.
    hit = np.isfinite(streams["lidar/range"][0]).ravel()
    assert np.array(points[0])[:, 0] == pytest.approx(1.0 + streams["lidar/range"][0].ravel()[hit], abs=1e-5)
    assert [len(shades) for shades in read.column(where, "Points3D:colors")] == [len(cloud) for cloud in points]


def test_light_goes_from_dark_over_the_colour_of_the_run_to_white() -> None:
    shades = lit((200, 100, 40, 255), np.array([0.0, 0.5, 1.0, 2.0, np.nan]), 1.0)
    assert shades.tolist() == [[50, 25, 10, 255], [200, 100, 40, 255], [255] * 4, [255] * 4, [50, 25, 10, 255]]
    assert lit((200, 100, 40, 255), np.zeros(1), 0.0).tolist() == [[200, 100, 40, 255]]


def test_beams_have_their_own_elevations_where_these_are_given() -> None:
    plain: dict[str, Any] = {"elevation_low": -0.1, "elevation_high": 0.3, "channels": 3, "columns": 4}
    assert np.arcsin(beams(plain)[:, 0, 2]) == pytest.approx([-0.1, 0.1, 0.3])
    assert np.arcsin(beams(plain | {"elevations": [-0.2, 0.0, 0.5]})[:, 0, 2]) == pytest.approx([-0.2, 0.0, 0.5])


def test_pictures_beyond_the_room_are_thinned_evenly_and_that_is_told() -> None:
    large = {"width": 1000, "height": 1000}
    kept = shown_frames(large, 100)
    assert len(kept) == MOST_PIXELS // 1_000_000
    assert (kept[0], kept[-1]) == (0, 99)
    assert shown_frames({"width": 10, "height": 10}, 100).tolist() == list(range(100))


def test_every_camera_has_a_view_of_its_own_with_all_who_tell_of_it(folder: Path) -> None:
    stage = stage_of(Store(folder), CASE)
    found = sensed(stage)
    assert [view.title for view in found.views] == ["depth depth", "camera colour", "camera depth"]
    assert list(found.views[0].paths) == ["reference tuned", "mujoco tuned", "truth"]
    assert found.channels == ["sensors/imu/accelerometer", "sensors/imu/gyroscope"]
    assert found.clouds == ["sensors/lidar/points"]
    made = layout(stage, framing(stage), [], found)
    names = [child.name for child in made.root_container.contents[0].contents if isinstance(child, rrb.Grid)]
    assert names == ["Side by side", "depth depth", "camera colour", "camera depth"]
