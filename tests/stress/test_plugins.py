"""Plug-ins of third parties that cannot be loaded: each is named with the reason, and costs nobody else anything."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from plumbline.harness.intake import strangers
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from tests.stress.ledger import Page

PLUGINS = Path(__file__).parent / "dying_plugins"
STUDY = """
name = "plugins"
recordings = false
[[experiments]]
name = "plugins"
cases = ["flight_projectile"]
tracks = ["tuned"]
dt = [0.01]
timing = false
"""
Call = Callable[..., subprocess.CompletedProcess[str]]


BOTH = """
from plumbline.harness.cli.main import main
main(["engines", "--json"], standalone_mode=False)
print("as text:")
main(["engines"])
"""
"""Both listings of engines, in one process: each plug-in is tried once for them."""


@pytest.fixture(scope="module")
def python() -> Call:
    """An interpreter with the plug-ins installed; those that have loaded here before, as they stand, are not tried again."""
    environment = os.environ | {"PYTHONPATH": str(PLUGINS)}

    def called(*arguments: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, *map(str, arguments)]
        return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=280, check=False)

    return called


@pytest.fixture(scope="module")
def call(python: Call) -> Call:
    """The command line in such an interpreter."""
    return partial(python, "-m", "plumbline")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, call: Call) -> Path:
    made = tmp_path_factory.mktemp("plugins")
    (made / "plugins.toml").write_text(STUDY)
    engines = [word for name in ("reference", "leaves", "well") for word in ("--engine", name)]
    done = call("run", made / "plugins.toml", *engines, "--out", made / "out")
    assert done.returncode == 1, done.stderr
    for title, reason in (
        ("leaves_page", "dying_leaves:PAGE: ended with exit code 0"),
        ("Raising", "LookupError: nothing to draw"),
    ):
        assert f"page '{title}' could not be made: {reason}" in done.stderr
    assert "case 'leaves_case' is left out: dying_leaves:CASE: ended with exit code 0 and no answer" in done.stderr
    return made / "out"


REASONS = {
    "leaves": "dying_leaves:ADAPTER: ended with exit code 0 and no answer",
    "quits": "dying_quits:ADAPTER: SystemExit: 0",
    "raises": "dying_raises:ADAPTER: RuntimeError: no licence",
    "missing": "dying_nowhere:ADAPTER: ModuleNotFoundError: No module named 'dying_nowhere'",
    "no_version": "KeyError: 'version'",
    "version_none": "version() gave None, expected up to 100 printable characters",
    "version_number": "version() gave 3, expected",
    "version_bytes": "version() gave b'1.0', expected",
    "version_colour": "version() gave '\\x1b[31m1.0', expected",
    "version_long": "version() gave '1111",
    "version_empty": "version() gave '', expected",
    "title_number": "title is int, expected text",
    "features_number": "features is int, expected Feature",
    "tracks_none": "tracks, expected Settings for 'default' and 'tuned'",
    "tracks_one": "tracks, expected Settings for 'default' and 'tuned'",
    "tracks_text": "tracks, expected Settings for 'default' and 'tuned'",
    "name_other": "dying_shape:NAME_OTHER: ADAPTER.name is 'another_name', expected 'name_other'",
    "no_adapter": "dying_shape:NO_ADAPTER: ADAPTER is int, expected Adapter",
    "ends_at_version": "dying_version:ENDS: ended with exit code 0 and no answer",
}


def test_listings_say_why_an_engine_is_unavailable_and_list_the_others(python: Call, ledger: Page) -> None:
    done = python("-c", BOTH)
    assert done.returncode == 0, done.stderr
    listed, _, text = done.stdout.partition("as text:\n")
    rows = {row["name"]: row for row in json.loads(listed)}
    for name, reason in REASONS.items():
        assert not rows[name]["available"]
        assert reason in rows[name]["unavailable"]
        ledger.survived("plug-ins: engines", name.replace("_", " "), "unavailable with its reason, others lost 0")
    assert rows["reference"]["available"]
    assert rows["well"]["version"] == "1.0"
    assert all(name in text for name in (*REASONS, "reference", "well"))
    assert "\x1b" not in text


@pytest.mark.slow
def test_cases_are_listed_without_one_that_cannot_be_loaded_which_is_named(call: Call) -> None:
    done = call("cases", "--json")
    assert done.returncode == 0, done.stderr
    names = [row["name"] for row in json.loads(done.stdout)]
    assert "flight_projectile" in names
    assert "leaves_case" not in names
    assert "case 'leaves_case' is left out" in done.stderr


@pytest.mark.slow
def test_a_run_has_the_cells_of_all_engines_that_were_asked_for(folder: Path) -> None:
    told = Store(folder).trials.set_index("engine")
    assert told["status"].to_dict() == {"leaves": "unavailable", "reference": "passed", "well": "unsupported"}
    assert REASONS["leaves"] in told.loc["leaves", "reason"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("leaves_page", "dying_leaves:PAGE: ended with exit code 0 and no answer"),
        ("raising", "LookupError: nothing to draw"),
        ("doubting", "LookupError: is it there?"),
        ("outward", "expected a plain name"),
        ("no_page", "expected a Page with a plain name"),
        ("index-2", "dying_page:INDEX: the name &#39;index&#39; is taken by another page; choose another"),
        ("leaving", "ended with exit code 0 and no answer"),
    ],
)
def test_a_page_that_fails_says_so_in_its_place(folder: Path, name: str, reason: str, ledger: Page) -> None:
    assert reason in (folder / "report" / f"{name}.html").read_text()
    ledger.survived("plug-ins: pages", name.replace("_", " "), "other pages lost 0")


@pytest.mark.slow
def test_the_other_pages_stand(folder: Path) -> None:
    report = folder / "report"
    assert (report / "good.html").read_text().endswith('">good')  # behind the policy that every page is given
    assert "Plumbline" in (report / "index.html").read_text()
    assert (report / "case-flight_projectile.html").is_file()
    assert not (report.parent / "outward.html").exists()
    assert (report / "charts" / "drawn.svg").read_text() == "drawn"
    assert (report / "pictures" / "bytes.webp").read_bytes() == b"\xff\x00"


BUILDS = {
    "leaves_build": "build ended with exit code 0 and no answer",
    "raises_build": "build LookupError: no licence",
    "none_build": "build gave None, expected a Simulation",
    "kills_build": "build was killed by SIGSEGV and no answer",
}


def test_an_engine_that_fails_at_building_is_a_row_of_scene_check_and_costs_no_other(call: Call, ledger: Page) -> None:
    done = call("scene", "check", Path(__file__).parent / "sound_files" / "ball.toml", "--json")
    assert done.returncode == 1, done.stderr
    rows = json.loads(done.stdout)
    assert [row["engine"] for row in rows] == list(dict.fromkeys(row["engine"] for row in rows))
    told = {row["engine"]: (row["verdict"], row["reason"]) for row in rows}
    assert told["reference"] == ("can", "")
    assert told["well"] == ("cannot", "everything: it can do nothing")
    for name, reason in BUILDS.items():
        assert told[name] == ("failed", reason)
        ledger.survived("plug-ins: build", name.replace("_", " "), "a row with its reason, others lost 0")


@pytest.mark.slow
def test_an_engine_that_ends_its_process_at_building_fails_the_checks_one_by_one(call: Call, ledger: Page) -> None:
    done = call("check", "leaves_build", "--track", "tuned", "--json")
    assert done.returncode == 1, done.stderr
    rows = json.loads(done.stdout)
    assert rows[0]["check"] == "imports_without_its_vendor" or len(rows) > 50
    assert "the process of the check ended with exit code 0" in {row["message"] for row in rows}
    ledger.survived("plug-ins: check", "leaves at build", "each check has its outcome, exit code 1")


def test_a_case_whose_scene_ends_the_process_is_left_out_and_the_others_are_listed(call: Call, ledger: Page) -> None:
    done = call("cases", "--json")
    assert done.returncode == 0, done.stderr
    assert "flight_projectile" in {row["name"] for row in json.loads(done.stdout)}
    assert "case 'leaves_scene' is left out: dying_build:CASE: ended with exit code 0 and no answer" in done.stderr
    ledger.survived("plug-ins: cases", "leaves at its scene", "left out with its reason, others lost 0")


def test_a_plug_in_is_tried_once_until_its_file_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "counted-1.0.dist-info").mkdir()
    (tmp_path / "counted-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: counted\nVersion: 1.0\n")
    (tmp_path / "counted-1.0.dist-info" / "entry_points.txt").write_text("[plumbline.cases]\ncounted = counted:CASE\n")
    code = f"open({str(tmp_path / 'log')!r}, 'a').write('x')\nCASE = 1\n"
    (tmp_path / "counted.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def ask() -> None:
        strangers._tried.cache_clear()  # a process keeps what it was told
        assert not plugins.left_out("cases")

    for _ in range(2):
        ask()
    assert (tmp_path / "log").read_text() == "x"
    (tmp_path / "counted.py").write_text(f"{code}# changed\n")
    ask()
    assert (tmp_path / "log").read_text() == "xx"
