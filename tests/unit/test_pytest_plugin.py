"""`pytest --plumbline ENGINE`, in a folder of the author of an engine: what is collected, how it is chosen, and what fails."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The adapter of the recipe as it is printed, and one with gravity that is a tenth too strong, both installed."""
    folder = tmp_path_factory.mktemp("engine")
    (text,) = re.findall(r"```python\n# adapters/flight\.py\n(.*?)```", CONTRIBUTING, flags=re.DOTALL)
    (folder / "flight.py").write_text(text, encoding="utf-8")
    heavy = text.replace("np.array(scene.gravity) *", "1.1 * np.array(scene.gravity) *").replace('"flight"', '"heavy"')
    assert heavy.count("1.1 *") == 1
    (folder / "heavy.py").write_text(heavy, encoding="utf-8")
    info = folder / "engine-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: engine\nVersion: 1\n", encoding="utf-8")
    points = "[plumbline.adapters]\nflight = flight:ADAPTER\nheavy = heavy:ADAPTER\n"
    (info / "entry_points.txt").write_text(points, encoding="utf-8")
    return folder


def asked(folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--strict-markers", *words]
    variables = os.environ | {"PYTHONPATH": str(folder), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "COLUMNS": "200"}
    plugin = ["-p", "plumbline.pytest_plugin"]
    return subprocess.run([*command, *plugin], cwd=folder, env=variables, capture_output=True, text=True, check=False)


def test_checks_and_cases_are_tests_with_marks_and_a_sound_engine_passes_them(folder: Path) -> None:
    done = asked(
        folder, "--plumbline", "flight", "-v", "-m", "tuned and not slow", "-k", "quaternion or flight_ or contact or imu_lag"
    )
    assert done.returncode == 0, done.stdout
    lines = dict(re.findall(r"^(plumbline::\S+) (\w+)", done.stdout, flags=re.MULTILINE))
    assert lines["plumbline::flight::tuned::quaternion_is_wxyz"] == "PASSED"
    assert lines["plumbline::flight::tuned::flight_projectile"] == "PASSED"
    assert lines["plumbline::flight::tuned::contact_forces_carry_the_weight"] == "SKIPPED", "it has no contacts"
    assert lines["plumbline::flight::tuned::sensor_imu_lag"] == "SKIPPED", "it is pushed, and takes no forces"
    assert not any("::default::" in name for name in lines)


def test_marks_choose_by_what_a_test_is_about(folder: Path) -> None:
    about = {"contact and case": "stack_tower", "contact and conformance": "box_rests_on_plane", "slow": "joint_long_run"}
    for marks, name in about.items():
        listed = asked(folder, "--plumbline", "flight", "--collect-only", "-q", "-m", marks).stdout.splitlines()
        names = {line.rpartition("::")[2] for line in listed if line.startswith("plumbline::")}
        assert name in names, marks
        assert "flight_projectile" not in names


def test_a_wrong_engine_fails_where_its_physics_is_wrong_and_its_known_failures_are_expected(folder: Path) -> None:
    words = ("--plumbline", "heavy", "-m", "tuned", "-k", "flight_projectile or spin_principal or size_and_sign_of_g")
    done = asked(folder, *words)
    assert done.returncode == 1
    failed = [line for line in done.stdout.splitlines() if line.startswith("FAILED ")]
    assert {line.split()[1].rpartition("::")[2] for line in failed} == {
        "flight_projectile",
        "free_fall_has_the_size_and_sign_of_g",
    }
    assert "position_error_max = " in done.stdout, "the reason"
    (folder / "known.txt").write_text("# gravity\n" + "\n".join(failed) + "\n", encoding="utf-8")
    known = asked(folder, *words, "--plumbline-known", "known.txt")
    assert known.returncode == 0, known.stdout
    assert "2 xfailed" in known.stdout
    written = asked(folder, *words, "--plumbline-write-known", "written.txt")
    assert written.returncode == 1
    assert "written.txt: 2 known failures written" in written.stdout
    lines = (folder / "written.txt").read_text(encoding="utf-8").splitlines()
    assert {line.split(" - ")[0] for line in lines} == {line.split()[1] for line in failed}
    assert "position_error_max = " in lines[0], "the reason"
    both = asked(folder, *words, "--plumbline-known", "written.txt", "--plumbline-write-known", "written.txt")
    assert both.returncode == 0, both.stdout
    assert (folder / "written.txt").read_text(encoding="utf-8").splitlines() == lines, "what fails again stays"
    cut = asked(folder, *words, "--plumbline-write-known", "cut.txt", "-x")
    assert "cut.txt: not written, the run did not end" in cut.stdout
    assert not (folder / "cut.txt").exists()
    (folder / "better.txt").write_text("plumbline::heavy::tuned::spin_principal - it turns too fast\n", encoding="utf-8")
    better = asked(folder, "--plumbline", "heavy", "-k", "tuned and spin_principal", "--plumbline-known", "better.txt")
    assert better.returncode == 1, "what improves is noticed"
    assert "[XPASS(strict)] known: it turns too fast" in better.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--plumbline", "fligth"), "'fligth': not found.*did you mean flight"),
        (("--plumbline", "flight", "--plumbline-known", "gone.txt"), "gone.txt: not readable"),
        (("--plumbline", "flight", "--plumbline-known", "strange.txt"), "strange.txt: line 1: 'x', expected plumbline::"),
        (("--plumbline", "flight", "--plumbline-known", "none.txt"), "plumbline::flight::tuned::gone: no such test"),
    ],
)
def test_a_wrong_option_is_a_usage_error(folder: Path, words: tuple[str, ...], said: str) -> None:
    (folder / "strange.txt").write_text("x\n", encoding="utf-8")
    (folder / "none.txt").write_text("plumbline::flight::tuned::gone\n", encoding="utf-8")
    done = asked(folder, *words)
    assert done.returncode == 4
    assert re.search(said, done.stderr), done.stderr


def test_without_the_option_nothing_is_added_and_nothing_is_loaded(folder: Path) -> None:
    (folder / "test_own.py").write_text(
        "import sys\n\ndef test_light():\n    assert not {'numpy', 'pydantic', 'click'} & set(sys.modules)\n", encoding="utf-8"
    )
    done = asked(folder, "test_own.py")
    assert "1 passed" in done.stdout, done.stdout


def test_the_sample_workflow_asks_for_checks_that_are_there(folder: Path) -> None:
    """Its command as it stands, but for how many run at a time, and that tests are listed and not run."""
    job = yaml.safe_load((ROOT / "docs" / "nightly-workflow.yml").read_text(encoding="utf-8"))["jobs"]["checks"]
    (command,) = (step["run"] for step in job["steps"] if step.get("name") == "checks")
    program, *words = shlex.split(command.replace("$ENGINE", job["env"]["ENGINE"]).replace(" -n auto", ""))
    assert program == "pytest"
    listed = asked(folder, *words, "--collect-only", "-q").stdout
    assert f"plumbline::{job['env']['ENGINE']}::tuned::friction_has_its_size" in listed
    assert "::default::" not in listed
