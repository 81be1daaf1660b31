"""Findings: their heads are whole, their scripts are the vendor's alone, and they tell what is there from what is gone."""

import ast
import re
import site
import subprocess
import sys
import sysconfig
import venv
from functools import cache
from pathlib import Path

import pytest

from plumbline.harness.findings.vendor_findings import (
    FOLDER,
    Finding,
    FindingError,
    ScriptAnswer,
    ask,
    ask_all,
    ask_mended,
    chosen,
    issue_text,
    read_finding,
    shelf,
)
from plumbline.harness.study.plugins import names
from tests.conftest import Command
from tests.needs import BULLET

PACKAGE = {"bullet": "pybullet", "dart": "dartpy", "mujoco": "mujoco"}
EVERY = shelf()
OTHER = "dart/urdf_frame_weighs_a_kilogram"
DAMPED = next(finding for finding in EVERY if finding.name == "bullet/damping_by_default")


@cache
def damped() -> ScriptAnswer:
    """What is said of one that is still there, and of its mend."""
    return next(ask_all([DAMPED]))


def test_each_of_three_engines_has_five_findings_and_more() -> None:
    counts = {engine: sum(finding.engine == engine for finding in EVERY) for engine in PACKAGE}
    assert min(counts.values()) >= 5, counts
    assert sum(counts.values()) == len(EVERY)


def test_the_cases_that_they_show_in_are_in_the_catalogue() -> None:
    known = set(names("cases"))
    assert {case for finding in EVERY for case in finding.cases} <= known


@pytest.mark.parametrize("finding", EVERY, ids=lambda finding: finding.name)
def test_a_script_needs_its_vendor_numpy_and_python_alone(finding: Finding) -> None:
    tree = ast.parse(finding.text)
    nodes = list(ast.walk(tree))
    imported = {alias.name.partition(".")[0] for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    imported |= {str(node.module).partition(".")[0] for node in nodes if isinstance(node, ast.ImportFrom)}
    allowed = {PACKAGE[finding.engine], "numpy"}
    assert imported - set(sys.stdlib_module_names) <= allowed
    assert {need.partition("=")[0] for need in finding.requires} == imported & allowed
    assert any(need == f"{PACKAGE[finding.engine]}=={finding.seen[-1]}" for need in finding.requires)


@BULLET
def test_a_trap_is_still_there_and_a_planted_mended_version_is_told_as_gone(tmp_path: Path) -> None:
    """The planted pybullet makes bodies without damping; an environment of its own finds it first."""
    assert damped().verdict == "still there"
    venv.create(tmp_path / "env", with_pip=False, symlinks=True)
    python = tmp_path / "env" / "bin" / "python"
    inside = sysconfig.get_path("purelib", vars={"base": str(tmp_path / "env"), "platbase": str(tmp_path / "env")})
    mended = tmp_path / "mended"
    mended.mkdir()
    (mended / "pybullet.py").write_text(
        "import importlib.machinery, importlib.util, pathlib\n"
        f"path = next(pathlib.Path({site.getsitepackages()[0]!r}).glob('pybullet.*'))\n"
        "loader = importlib.machinery.ExtensionFileLoader('vendor.pybullet', str(path))\n"
        "real = importlib.util.module_from_spec(importlib.util.spec_from_loader('vendor.pybullet', loader))\n"
        "globals().update(vars(real))\n"
        "def createMultiBody(*arguments, **named):\n"
        "    body = real.createMultiBody(*arguments, **named)\n"
        "    real.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0)\n"
        "    return body\n"
    )
    Path(inside, "mended.pth").write_text(f"{mended}\n{site.getsitepackages()[0]}\n")
    standing = ask(DAMPED, str(python))
    assert (standing.verdict, standing.figure.split(" after")[0]) == ("gone", "0.041 m from the parabola")


@BULLET
def test_a_script_whose_engine_is_missing_or_that_ends_otherwise_has_a_reason(tmp_path: Path) -> None:
    folder = tmp_path / "bullet"
    folder.mkdir()
    text = DAMPED.text.replace("import pybullet as p", "import no_such_engine as p")
    for name, body, verdict, reason in (
        ("missing", text, "unavailable", "ModuleNotFoundError: No module named 'no_such_engine'"),
        ("silent", DAMPED.text.partition("print(")[0], "failed", "pybullet build time"),
        ("dying", DAMPED.text + "\nimport os\nos.abort()\n", "failed", "ended by signal 6"),
    ):
        (folder / f"{name}.py").write_text(body)
        standing = ask(read_finding(folder / f"{name}.py"))
        assert standing.verdict == verdict
        assert standing.figure.startswith(reason)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('kind = "trap"', 'kind = "sin"', "tool.finding.kind"),
        ("# mend =", "# mends =", "tool.finding.mend"),
        ('engine = "bullet"', 'engine = "dart"', "in the folder of 'bullet'"),
        ("# /// script", "# script", "no block"),
        ('kind = "trap"', "kind = trap", "head: "),
    ],
)
def test_a_head_that_is_wrong_is_refused_by_file_and_field(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = tmp_path / "bullet" / "f.py"
    path.parent.mkdir()
    path.write_text(DAMPED.text.replace(old, new))
    with pytest.raises(FindingError, match=words) as caught:
        read_finding(path)
    assert str(path) in str(caught.value)


@BULLET
def test_the_text_for_the_vendor_has_the_figure_the_law_the_documentation_and_the_mend_with_its_price() -> None:
    text = issue_text(damped())
    law = "A ball thrown at 8.6 m/s lands elsewhere than its parabola says"
    for words in (
        DAMPED.title,
        "1.449 m from the parabola",
        law,
        DAMPED.documented,
        DAMPED.mend,
        "With it: gone: 0.041 m",
        "3.2.7",
    ):
        assert words in text
    assert re.search(r"Time of a step with it, over that without: \d+\.\d\d\.", text)


@pytest.mark.parametrize("finding", EVERY, ids=lambda finding: finding.name)
def test_the_script_in_the_text_is_whole_and_names_nothing_of_ours(finding: Finding) -> None:
    text = issue_text(ScriptAnswer(finding, "still there", "1 m", "1", 0.1))
    script = text.partition("```python\n")[2].partition("\n```")[0]
    assert ast.dump(ast.parse(script)) == ast.dump(ast.parse(finding.text))
    assert script.startswith("# /// script\n# requires-python")
    assert "tool.finding" not in text
    assert "plumbline" not in text.lower()


def test_the_command_writes_a_text_a_finding_whose_script_runs_alone(printed: Command, tmp_path: Path) -> None:
    assert printed("findings", "--report", "drat", "--out", str(tmp_path)).returncode == 2
    assert printed("findings", "dart", "--report", "dart", "--out", str(tmp_path)).returncode == 2
    written = printed("findings", "--report", OTHER, "--out", str(tmp_path / "r"))
    assert written.returncode == 0, written.stderr
    path = tmp_path / "r" / f"{OTHER}.md"
    assert written.stdout.split() == [str(path)]
    script = tmp_path / "pasted.py"
    script.write_text(path.read_text().partition("```python\n")[2].partition("\n```")[0])
    done = subprocess.run([sys.executable, "-I", str(script)], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.rstrip().rpartition("\n")[2].startswith("still there: ")


UNIVERSAL = re.compile(r"\b(every|never|always|silent(ly)?|in silence|no body|any)\b", re.IGNORECASE)


@pytest.mark.parametrize("finding", EVERY, ids=lambda finding: finding.name)
def test_a_title_says_no_universal_word_and_a_source_is_no_moving_branch(finding: Finding) -> None:
    """One counter-example makes such a title false: damping was said of every body, and maximal ones have none."""
    assert not UNIVERSAL.search(finding.title)
    assert [source for source in finding.sources if "/master/" in source or "/main/" in source] == []


@BULLET
def test_a_mend_that_leaves_a_finding_standing_is_red(tmp_path: Path) -> None:
    """The planted mend is that of the published finding with another value: a hundredth more of damping than the default."""
    path = tmp_path / "bullet" / "f.py"
    path.parent.mkdir()
    path.write_text(DAMPED.text.replace("linearDamping=0.0, angularDamping=0.0)", "linearDamping=0.05)"))
    standing = next(ask_all([read_finding(path)]))
    assert standing.mended is not None
    assert (standing.verdict, standing.mended.verdict) == ("still there", "stands")
    assert standing.broken
    path.write_text(DAMPED.text.replace("price:", "prize:"))
    dear = ask_mended(read_finding(path))
    assert (dear.verdict, dear.figure.partition(",")[0]) == ("failed", "no price of the mend")
    assert not damped().broken


def test_findings_are_chosen_by_engine_or_by_name() -> None:
    assert {finding.engine for finding in chosen(EVERY, "dart")} == {"dart"}
    assert [finding.name for finding in chosen(EVERY, OTHER)] == [OTHER]
    with pytest.raises(FindingError, match="no finding is called 'drat'; there are bullet, dart, mujoco, bullet/"):
        chosen(EVERY, "drat")


def test_the_command_lists_them_and_prints_the_text_of_one(printed: Command) -> None:
    listed = printed("findings", "mujoco")
    assert listed.returncode == 0
    assert "mujoco/no_restitution" in listed.stdout
    assert "bullet/" not in listed.stdout
    assert printed("findings", "mujoco", "--issue").returncode == 2
    assert f"{len(chosen(EVERY, 'mujoco'))} findings" in listed.stdout
    assert printed("findings", "drat").returncode == 2


@pytest.mark.slow
@pytest.mark.parametrize("finding", EVERY, ids=lambda finding: finding.name)
def test_it_is_still_there_in_the_version_that_it_was_seen_in_and_its_mend_cures_it(finding: Finding) -> None:
    standing = next(ask_all([finding]))
    if standing.version not in finding.seen:
        pytest.skip(f"seen in {', '.join(finding.seen)}, installed is {standing.version or 'nothing'}")
    assert standing.verdict == "still there", standing.figure
    assert standing.mended is not None
    assert standing.mended.cures, standing.mended.figure


def test_readme_names_every_field_of_a_head() -> None:
    text = (FOLDER / "README.md").read_text()
    for field in ("engine", "kind", "title", "seen", "documented", "sources", "mend", "cases"):
        assert f"| `{field}` |" in text


def test_a_script_runs_by_hand_as_the_readme_says() -> None:
    path = FOLDER / f"{OTHER}.py"
    done = subprocess.run([sys.executable, str(path)], capture_output=True, text=True, check=True)
    assert done.stdout.rstrip().rpartition("\n")[2].startswith("still there: ")
