"""The commands on robots and scenes of one's own: what they print, keep, refuse, and what a run folder says of an import."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from plumbline.harness.cli.main import main
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import DROPPABLE
from plumbline.harness.scene.file import load, parse
from plumbline.harness.scene.importers.companion import load_companion
from plumbline.harness.store.imported_scenes import fidelity_of, keep, unsound
from plumbline.reports.html import report as html
from plumbline.reports.page import pages
from tests.in_process import clocked_by, in_this_process
from tests.robot_files import INERTIAL, LIMIT, imported, urdf

SHAPED = f'{INERTIAL}<collision><geometry><sphere radius="0.1"/></geometry></collision>'


def command(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robot.urdf"
    path.write_text(urdf(arm=SHAPED, joint=f'{LIMIT}<dynamics friction="0.1"/>'))
    (tmp_path / "robot.plumb.toml").write_text('root = "fixed"\nduration = 0.1\n')
    return path


def test_show_lists_bodies_joints_and_what_became_of_each_element(robot: Path) -> None:
    done = command("scene", "show", robot, "--drop", "friction_loss", "--json")
    assert done.exit_code == 0
    rows = json.loads(done.stdout)
    assert {row["kind"] for row in rows} == {"body", "joint", "fidelity"}
    lost = next(row for row in rows if row.get("element") == "friction loss")
    assert (lost["outcome"], lost["value"], lost["unit"]) == ("left_out", 0.1, "N m")
    text = command("scene", "show", robot, "--drop", "friction_loss")
    assert "1 bodies move, with 2 kg in all; 1 joints" in text.stdout


def test_what_is_refused_ends_in_one_line_and_code_2(robot: Path) -> None:
    robot.write_text(robot.read_text().replace("</joint>", '<mimic joint="j" multiplier="0"/></joint>'))
    done = command("scene", "check", robot)
    assert done.exit_code == 2
    assert "--drop mimic leaves it out" in done.stderr
    assert "Traceback" not in done.output
    assert command("scene", "check", robot.with_name("gone.urdf")).exit_code == 2


def test_check_says_which_engines_can_express_the_scene(robot: Path) -> None:
    done = command("scene", "check", robot, "--drop", "friction_loss", "--json")
    rows = {row["engine"]: row for row in json.loads(done.stdout)}
    assert rows["reference"]["verdict"] == "can"


def test_convert_writes_our_own_words_for_the_same_scene(robot: Path, tmp_path: Path) -> None:
    done = command("scene", "convert", robot, "--drop", "friction_loss")
    assert parse(done.stdout, "x.toml").body("arm").mass == 2
    out = tmp_path / "out.json"
    assert command("scene", "convert", robot, "--drop", "friction_loss", "--out", out).exit_code == 0
    assert load(out) == parse(done.stdout, "x.toml")
    assert command("scene", "convert", robot, "--drop", "friction_loss", "--out", "x.txt").exit_code == 2


def test_schema_is_that_of_scene_files() -> None:
    assert "bodies" in json.loads(command("scene", "schema").stdout)["properties"]


def test_a_new_scene_is_one_and_takes_the_place_of_nothing(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    assert command("scene", "new", path).exit_code == 0
    assert {body.name for body in load(path).bodies} == {"ground", "ball", "bob"}
    path.write_text("mine")
    assert command("scene", "new", path).exit_code == 2
    assert path.read_text() == "mine"
    assert command("scene", "new", tmp_path / "mine.urdf").exit_code == 2


def test_every_kind_that_can_be_dropped_is_offered(robot: Path) -> None:
    said = " ".join(command("scene", "show", "--help").stdout.split())
    assert all(kind in said.replace("- ", "-") or kind[:6] in said for kind in DROPPABLE)
    assert command("scene", "show", robot, "--drop", "armor").exit_code == 2


def test_an_import_is_kept_once_sealed_and_named_by_what_it_says(tmp_path: Path) -> None:
    got = imported(tmp_path, urdf(arm=SHAPED))
    path = keep(tmp_path / "run", got)
    assert keep(tmp_path / "run", got) == path
    assert load(path) == got.scene
    rows = fidelity_of(tmp_path / "run")
    assert [row["robot"] for row in rows] == ["r"] * len(got.fidelity)
    assert list(unsound(tmp_path / "run")) == []
    path.write_text(path.read_text().replace("mass = 2.0", "mass = 3.0"))
    (tmp_path / "run" / "scenes" / "stray.txt").write_text("")
    ((broken, what),) = unsound(tmp_path / "run")
    assert (broken, "checksum differs" in what) == (path, True)


def test_a_robot_runs_and_its_folder_says_what_became_of_it(
    robot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In this process: a scene of one's own that runs in processes of its own is in `test_scene_files.py`."""
    in_this_process(monkeypatch)
    clocked_by(monkeypatch, lambda _: [1e-6] * 3)
    monkeypatch.setattr(html, "pages", lambda: tuple(page for page in pages() if page.name == "index"))
    out = tmp_path / "out"
    of_run = ("--dt", "4ms", "--duration", "0.1", "--budget", "1s")
    done = command("run", robot, "--drop", "friction_loss", "--engine", "mujoco", *of_run, "--out", out)
    assert done.exit_code == 0, done.output
    assert "dropped by the user: friction_loss" in done.stderr
    table = command("show", out, "--table", "fidelity", "--format", "json")
    assert any(row["element"] == "friction loss" for row in json.loads(table.stdout))
    trials = json.loads(command("show", out, "--format", "json").stdout)
    assert {row["engine"] for row in trials} == {"mujoco"}
    assert all(row["case"].endswith("/r.toml") for row in trials)
    assert max(row["dt"] for row in trials) == 0.004
    (companion,) = out.glob("scenes/*/r.plumb.toml")
    assert (load_companion(companion).duration, load_companion(companion).dt) == (0.1, 0.004)
    assert "budget = 1.0" in (out / "study.toml").read_text()
    assert command("verify", out).exit_code == 0


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [
        ("--dt", "0", "'0', expected seconds from 1e-09 to 1"),
        ("--dt", "nan", "'nan', expected seconds"),
        ("--duration", "-1", "'-1', expected seconds from 1e-06 to 1e+06"),
        ("--budget", "soon", "'soon', expected seconds from 0 to 1e+07, like 0.002, 2ms, 90s or 5m"),
        ("--scenaro", "drop", "no option '--scenaro', expected some of --budget, --case, --commands, --convex, --drop, --dt"),
    ],
)
def test_an_option_that_is_none_is_refused_by_name(robot: Path, tmp_path: Path, option: str, value: str, said: str) -> None:
    done = command("run", robot, option, value, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert said in done.stderr
    assert option in done.stderr


def test_static_friction_above_kinetic_friction_is_found_before_anything_runs(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(urdf(base=SHAPED, arm=SHAPED))
    (tmp_path / "robot.plumb.toml").write_text(
        'root = "floating"\n[ground]\n[[surfaces]]\nbetween = ["robot", "ground"]\n'
        "static_friction = 0.9\nkinetic_friction = 0.6\n"
    )
    out = tmp_path / "out"
    done = command("run", path, "--out", out)
    assert done.exit_code == 2
    assert "--one-friction takes the kinetic one for both, or --engine reference" in done.stderr
    assert not (out / "journal.jsonl").exists()


def test_options_of_robots_are_refused_for_studies(tmp_path: Path) -> None:
    done = command("run", "quick", "--root", "fixed", "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "for scene and robot files alone" in done.stderr


def test_a_package_that_is_no_folder_is_refused_before_anything_is_read(robot: Path) -> None:
    done = command("scene", "show", robot, "--package", "a=/gone/away")
    assert (done.exit_code, "expected a folder that is there" in done.stderr) == (2, True)


def test_an_error_of_a_robot_is_one_that_people_can_mend() -> None:
    assert RobotError.lies_in == "usage"
