"""What pages show of a case: pictures, rows for runs that look different, series, moments to watch, gaps in words."""

import dataclasses
import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from plumbline.harness.scene import Body, Distance, Joint, Plane, Revolute, Scene, Sphere, Surface
from plumbline.harness.store.record import Measurement
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Trajectory
from plumbline.reports.html import report as html
from plumbline.reports.html.report import write_report
from plumbline.reports.page import pages
from plumbline.reports.pictures.case_pictures import CaseSight, sight
from plumbline.reports.pictures.motion_chart import labelled
from plumbline.reports.recordings.camera import around_held
from plumbline.reports.recordings.runs import stage_of
from plumbline.reports.recordings.write import about, moment_recording
from tests.links import texts_of
from tests.recorded_folder import Folder, placed, record

TIMES = np.arange(101) / 100.0
BOUND = 0.125


def scene() -> Scene:
    ball = Body(name="ball", mass=2.0, collision=placed(Sphere(radius=0.1)), p_WB=(0.0, 0.0, 0.1))
    return Scene(bodies=(Body(name="ground", motion="static", collision=placed(Plane())), ball), surfaces=(Surface(),))


def sliding(speed: float) -> Trajectory:
    """The ball slides along x with this speed [m/s]."""
    answer = Trajectory.of(TIMES, 2)
    for k, body in enumerate(scene().bodies):
        answer.p_WB[:, k], answer.q_WB[:, k] = body.p_WB, body.q_WB
    answer.p_WB[:, 1, 0] += speed * TIMES
    answer.v_WB[:, 1, 0] = speed
    return answer


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = Folder(tmp_path_factory.mktemp("sights") / "run")
    bound = Measurement(metric="position_error_max", value=0.0, unit="m", at_most=BOUND, passed=True, because="made")
    for engine, speed in (("mujoco", 1.0), ("dart", 1.001), ("bullet", 1.5)):
        made.add(record("slide", engine, measurements=(bound,)), scene(), sliding(speed), sliding(1.0))
    made.add(record("away", "mujoco"), scene(), sliding(1.0), sliding(1.0))
    made.write(slide={"title": "A ball slides", "dt": 0.01, "headline": "position_error_max"})
    return made.path


@pytest.fixture(scope="module")
def seen(folder: Path) -> CaseSight:
    return sight(Store(folder), "slide")


def test_runs_that_look_alike_share_a_row_with_the_truth_and_others_have_their_own(seen: CaseSight) -> None:
    assert seen.film is not None
    told, other = seen.film.rows
    assert told.told
    assert {engine for engine, _ in told.runs} == {"mujoco", "dart"}
    assert {engine for engine, _ in other.runs} == {"bullet"}


def test_a_thumbnail_is_a_small_picture_with_the_page_shining_through_and_the_ball_in_it(seen: CaseSight) -> None:
    assert seen.thumb is not None
    pixels = np.asarray(Image.open(io.BytesIO(seen.thumb.content)).convert("RGBA")).astype(float)
    assert len(seen.thumb.content) < 30_000
    solid = pixels[..., 3] > 250
    assert 0.01 < solid.mean() < 0.5
    assert (pixels[~solid][:, 3] < 130).mean() > 0.95  # but for edges, the ground hides little of the page
    assert np.ptp(pixels[solid][:, :3], axis=0).max() > 40  # lit from one side


def test_the_series_is_the_place_that_changes_and_the_moment_is_where_the_bound_is_first_broken(seen: CaseSight) -> None:
    assert seen.motion is not None
    assert seen.motion.title == "Place of ball along x"
    assert seen.motion.band == BOUND
    lines = {line.engine: line for line in seen.motion.lines}
    # Bullet strays by 0.5 m/s t: beyond 0.125 m after 0.25 s, at the next of the stored hundredths.
    assert lines["bullet"].moment == pytest.approx(0.26)
    assert lines["bullet"].worst == pytest.approx(0.5)
    assert lines["dart"].moment == pytest.approx(1.0)
    assert len(seen.apart) == 3
    assert all(panel.limit is not None for panel in seen.apart)


def test_a_recording_of_a_moment_holds_the_stretch_about_it_alone(folder: Path) -> None:
    store = Store(folder)
    stage = about(stage_of(store, "slide"), 0.5)
    assert all(run.time[0] == pytest.approx(0.44) and run.time[-1] == pytest.approx(0.56) for run in stage.runs)
    assert stage.truth["time"][0] == pytest.approx(0.44)
    content = moment_recording(store, "slide.rrd", 0.5)
    assert content is not None
    assert content.startswith(b"RRF2")
    assert moment_recording(store, "nothing.rrd", 0.5) is None
    assert moment_recording(store, "slide.rrd", 77.0) is None


def test_pages_show_pictures_that_are_there_and_say_where_to_watch(folder: Path) -> None:
    texts = texts_of(Store(folder), "case", "pictures")
    page = str(texts["case-slide.html"])
    pictures = {name for name in texts if name.startswith("pictures/")}
    assert all(isinstance(texts[name].kept(folder / "report"), bytes) for name in pictures)
    named = {part.split('"')[0] for part in page.split('src="')[1:] if part.startswith("pictures/")}
    assert len(named) >= 3
    assert named <= pictures
    assert "Watch at 0.26 s" in page
    assert "first beyond the bound" in page
    assert "plumbline serve" in page


def test_a_second_report_takes_over_pictures_that_are_whole_and_draws_others_anew(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(html, "pages", lambda: tuple(page for page in pages() if page.name in ("case", "pictures")))
    report = write_report(folder).index.parent
    first, other, *_ = sorted((report / "pictures").iterdir())
    marked = first.read_bytes()[:-1] + b"\x00"  # as long as its head says
    first.write_bytes(marked)
    whole = other.read_bytes()
    other.write_bytes(whole[:-10])
    write_report(folder)
    assert first.read_bytes() == marked
    assert other.read_bytes() == whole


def test_what_was_kept_by_its_hash_alone_or_is_gone_is_said_in_a_line(folder: Path, tmp_path: Path) -> None:
    made = Folder(tmp_path / "run")
    answer = record("slide", "mujoco")
    made.add(dataclasses.replace(answer, trajectory_hash="0" * 64, trajectory_kept=False))
    made.add(dataclasses.replace(record("gone", "mujoco"), trajectory_hash="1" * 64))
    made.add(record("none", "mujoco", status="unsupported", reason="no"))
    made.write()
    store = Store(made.path)
    assert "kept by their hash alone: plumbline reproduce" in " ".join(sight(store, "slide").missing)
    assert "no longer in trajectories/" in " ".join(sight(store, "gone").missing)
    assert "left a trajectory" in " ".join(sight(store, "none").missing)
    assert sight(store, "slide").thumb is None


@pytest.mark.parametrize(
    ("steps", "labels"),
    [
        ([1.38, 1.385, 1.39], ["1.38", "1.385", "1.39"]),
        ([0.0, 2.5, 5.0], ["0", "2.5", "5"]),
        ([1000.1, 1000.15], ["1000.1", "1000.15"]),
        ([1e-5, 2e-5], ["10⁻⁵", "2\N{MULTIPLICATION SIGN}10⁻⁵"]),
    ],
)
def test_labels_of_an_axis_stand_for_their_ticks(steps: list[float], labels: list[str]) -> None:
    assert [label for _, label in labelled(steps)] == labels


@pytest.mark.parametrize(
    "joint",
    [
        Revolute(name="j", parent="world", child="arm", anchor_W=(0.0, 0.0, 1.5), axis_W=(0.0, 1.0, 0.0)),
        Revolute(name="j", parent="trunk", child="arm", anchor_W=(0.0, 0.0, 1.5), axis_W=(0.0, 1.0, 0.0)),
        Revolute(name="j", parent="arm", child="trunk", anchor_W=(0.0, 0.0, 1.5), axis_W=(0.0, 1.0, 0.0)),
        Distance(name="j", parent="arm", child="trunk", anchor_W=(0.0, 0.0, 1.0), child_anchor_W=(0.0, 0.0, 1.5)),
    ],
    ids=["world", "static_parent", "static_child", "rope"],
)
def test_what_holds_a_machine_is_in_the_frame_and_the_wall_behind_it_is_not(tmp_path: Path, joint: Joint) -> None:
    """A head on a fixed trunk, an arm that hangs on the world beside it or on the trunk itself, and a wall farther off."""
    trunk = (*placed(Sphere(radius=0.1), p_BS=(0.0, 0.0, 1.9)), *placed(Sphere(radius=0.05), p_BS=(0.0, 0.0, 9.0)))
    arm = Body(name="arm", collision=placed(Sphere(radius=0.5)), p_WB=(0.0, 0.0, 1.0))
    held = Scene(bodies=(Body(name="trunk", motion="static", collision=trunk), arm), joints=(joint,), surfaces=(Surface(),))
    low, high = np.array((-0.5, -0.5, 0.5)), np.array((0.5, 0.5, 1.5))
    answer = Trajectory.of(TIMES, 2)
    answer.p_WB[:, 1], answer.q_WB[:] = arm.p_WB, arm.q_WB
    folder = Folder(tmp_path)
    folder.add(record("held", "bullet"), held, answer)
    folder.write(held={"title": "Held"})
    stage = stage_of(Store(tmp_path), "held")
    assert around_held(stage, low, high)[0] == pytest.approx(low)
    assert around_held(stage, low, high)[1] == pytest.approx((0.5, 0.5, 2.0))
