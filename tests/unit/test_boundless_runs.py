"""Runs that would never end, and searches that lead to such: refused with their field before anything is kept or run."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from plumbline.harness.case.scene_file import own_case
from plumbline.harness.cli.main import main
from plumbline.harness.intake.allowance import allowing
from plumbline.harness.study.foreseen_cost import too_many_steps
from plumbline.harness.study.study import study_of

ARM = Path(__file__).parents[2] / "examples" / "arm.urdf"
HEAD = 'name = "s"\n[[experiments]]\nname = "e"\ncases = ["{case}"]\ntiming = false\n'
STEPS = "expected at most 100000000; --limit steps=VALUE allows more"
THINGS = "expected at most 10000; --limit things=VALUE allows more"


def refused(*command: object) -> str:
    """What is said of a command that is refused, and after which there is no run folder."""
    out = Path(str(command[-1]))
    done = CliRunner().invoke(main, ["run", *map(str, command[:-1]), "--engine", "mujoco", "--out", str(out)])
    assert done.exit_code == 2, done.output
    assert not out.exists()
    return str(done.stderr)


@pytest.mark.parametrize("option", ["command line", "companion file", "log of commands"])
def test_a_robot_of_too_many_steps_is_refused_with_both_numbers(option: str, tmp_path: Path) -> None:
    robot = tmp_path / "arm.urdf"
    robot.write_bytes(ARM.read_bytes())
    options: list[object] = ["--root", "fixed"]
    if option == "companion file":
        (tmp_path / "arm.plumb.toml").write_text("duration = 1e6\ndt = 1e-9\n")
    elif option == "log of commands":
        (tmp_path / "log.csv").write_text("time,shoulder,elbow\n0,0,0\n500000,0.1,0.1\n1000000,0.2,0.1\n")
        options += ["--commands", tmp_path / "log.csv", "--gains", "10,1", "--dt", "1e-9"]
    else:
        options += ["--duration", "1e6", "--dt", "1e-9"]
    said = refused(robot, *options, tmp_path / "out")
    assert f"{robot}: duration 1e+06 s at dt 1e-09 s: 1e+15 steps, {STEPS}" in said


@pytest.mark.parametrize(
    ("case", "asked", "said"),
    [
        ("flight_box", "dt = [1e-12]", rf"duration 1 s at dt 1e-12 s: 1e\+12 steps, {STEPS}"),
        ("flight_box", "refine = {finest = 1e-12}", rf"refine\.finest: .*at dt 1e-12 s: 1e\+12 steps, {STEPS}"),
        ("flight_box", 'limit = {along = "dt", extreme = 1e-12}', rf"limit\.extreme: .*at dt 1e-12 s: 1e\+12 steps, {STEPS}"),
        ("flight_box", 'limit = {along = "dt", easy = -1.0}', r"limit\.easy: .*-1, expected a time step above 0 s"),
        (
            "stack_pile",
            'limit = {along = "worlds", easy = 1, extreme = 1e9}',
            rf"limit\.extreme: .*'worlds': 1000000000 .*{THINGS}",
        ),
        ("stack_pile", "parameters = {worlds = [1000000000]}", rf"'worlds': 1000000000 things, {THINGS}"),
    ],
)
def test_a_study_of_too_much_is_refused_with_its_field(case: str, asked: str, said: str, tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(f"{HEAD.format(case=case)}{asked}\n")
    found = refused(study, tmp_path / "out")
    assert re.search(rf"{re.escape(str(study))}: experiment 'e': .*{said}", found), found


def test_the_ladder_of_a_scene_of_ones_own_ends_where_a_run_would_take_more_steps_than_are_allowed(tmp_path: Path) -> None:
    """It goes down to a sixteenth of the first step otherwise, and nobody is refused a run for a search's sake."""
    (tmp_path / "s.toml").write_text('[[bodies]]\nname = "a"\n')
    (tmp_path / "s.plumb.toml").write_text("duration = 4.0\ndt = 0.01\n")
    case = own_case(tmp_path / "s.toml", "scene:")
    refinements = [study_of(case).experiments[0].refine]
    with allowing(["steps=1000"], "here"):
        refinements.append(study_of(case).experiments[0].refine)
        assert refinements[1] is not None
        assert not too_many_steps(case.duration, refinements[1].finest)
    assert [refine.finest if refine else None for refine in refinements] == [0.01 / 16, 4.0 / 999]
