"""The workflow and the cron line of docs/nightly.md: their commands are read from these files and run by a plain shell."""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.study_texts import ONE_CASE

ROOT = Path(__file__).parents[2]
WORKFLOW = ROOT / "docs" / "nightly-workflow.yml"
FEW = "--engine mujoco --no-report --study"
"""What makes a night of it one of seconds."""


def program(folder: Path) -> Path:
    """A folder with a command `plumbline` of these sources, whose nights are short."""
    (folder / "few.toml").write_text(ONE_CASE)
    path = folder / "bin" / "plumbline"
    path.parent.mkdir()
    words = f'exec "{sys.executable}" -m plumbline "$@"'
    path.write_text(
        f'#!/bin/sh\nexport PYTHONPATH="{ROOT / "src"}"\n[ "$1" != nightly ] || {words} {FEW} {folder}/few.toml\n{words}\n'
    )
    path.chmod(0o755)
    return path.parent


def carried_out(workspace: Path, commands: Path, files: Path, options: str) -> dict[str, int]:
    """The commands of the job `night`, in order, but for the installation: the exit code of each, until one fails."""
    said: Mapping[str, Any] = yaml.safe_load(WORKFLOW.read_text())
    job = said["jobs"]["night"]
    outputs: dict[str, dict[str, str]] = {}
    codes: dict[str, int] = {}
    for step in job["steps"]:
        if "run" not in step or step["name"] == "install":
            continue

        def filled(text: str) -> str:
            return re.sub(r"\$\{\{ steps\.(\w+)\.outputs\.(\w+) \}\}", lambda found: outputs[found[1]].get(found[2], ""), text)

        output = files / "output"
        output.write_text("")
        own = {name: filled(str(value)) for name, value in {**said["env"], **step.get("env", {})}.items()}
        done = subprocess.run(
            [said["defaults"]["run"]["shell"], "--noprofile", "--norc", "-eo", "pipefail", "-c", filled(step["run"])],
            cwd=workspace,
            env=os.environ
            | own
            | {"PATH": f"{commands}:{os.environ['PATH']}", "OPTIONS": options}
            | {"GITHUB_OUTPUT": str(output), "GITHUB_STEP_SUMMARY": str(files / "summary")},
            check=False,
        )
        codes[step["name"]] = done.returncode
        outputs[step.get("id", "")] = dict(line.split("=", 1) for line in output.read_text().splitlines())
        if done.returncode:
            break
    return codes


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_the_workflow_keeps_a_history_shows_the_summary_and_fails_with_its_gate(tmp_path: Path) -> None:
    bare, workspace, files = tmp_path / "origin.git", tmp_path / "workspace", tmp_path / "files"
    files.mkdir()
    subprocess.run(["git", "init", "-q", "--bare", str(bare)], check=True)
    subprocess.run(["git", "clone", "-q", str(bare), str(workspace)], check=True)
    commands = program(tmp_path)
    sound = ["the night", "what is old goes", "the badge", "the gate"]
    for _ in range(2):
        assert carried_out(workspace, commands, files, "--gate mujoco") == dict.fromkeys(sound, 0)
    assert len([*(workspace / "history" / "nights").iterdir()]) == 2
    summary = (files / "summary").read_text()
    assert "Nothing of this night was seen before" in summary
    assert "Gate (mujoco): no regression" in summary
    badge = subprocess.run(["git", "show", "badges:plumbline.svg"], cwd=bare, capture_output=True, text=True, check=True).stdout
    assert "no change" in badge
    # No price was clocked and all is recalled; but a share of what nobody can reach fails the gate, and what was kept stays.
    (tmp_path / "few.toml").write_text(ONE_CASE.replace("friction_stop", "flight_projectile"))
    codes = carried_out(workspace, commands, files, "--gate mujoco --judged 1")
    assert codes == {**dict.fromkeys(sound, 0), "the gate": 1}
    assert len([*(workspace / "history" / "nights").iterdir()]) == 3


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_cron_line_is_run_by_a_shell(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "nightly.md").read_text()
    (line,) = re.findall(r"^30 1 \* \* \* (.*)$", text, re.MULTILINE)
    mail = tmp_path / "mail"
    line = line.replace("/srv/plumbline", str(tmp_path / "h")).replace("cd /srv", f"cd {shlex.quote(str(tmp_path))}")
    line = re.sub(r'mail -s "plumbline" \S+(?=\')', f"cat > {mail}", line)
    path = {"PATH": f"{program(tmp_path)}:{os.environ['PATH']}"}
    done = subprocess.run(["sh", "-c", line], env=os.environ | path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].endswith("changes/summary.md")
    assert "Nothing of this night was seen before" in mail.read_text()
