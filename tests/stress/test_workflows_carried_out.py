"""The workflows of GitHub, carried out step by step: a history that nights hand on, an issue once, a comment that fits."""

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.stress.test_planted_nights import FAULTY, PACKAGES, ROOT
from tests.study_texts import ONE_CASE
from tests.workflows import Job, Runner, jobs

LONGEST = 65_536
"""Characters of a comment or an issue. Source: GitHub's own refusal of longer ones."""
LARGEST = 100 * 2**20
"""Bytes of a file that GitHub takes. Source: GitHub Docs, About large files on GitHub."""
BUDGET = "10m"
"""Of a night that takes seconds of CPU time; on a machine that others load too."""

pytestmark = pytest.mark.slow


def git(folder: Path, *words: str) -> str:
    person = {f"GIT_{role}_{what}": "nobody" for role in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}
    done = subprocess.run(["git", *words], cwd=folder, env=os.environ | person, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def commit(folder: Path, text: str, branch: str = "main") -> str:
    git(folder, "add", "-A")
    git(folder, "commit", "-qm", text)
    git(folder, "push", "-q", "origin", f"HEAD:refs/heads/{branch}")
    return git(folder, "rev-parse", "HEAD")


@pytest.fixture(scope="module")
def origin(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, str]:
    """A bare repository of these sources; its sound commit, and one with three per cent more friction in our adapter."""
    folder = tmp_path_factory.mktemp("github")
    bare, tree = folder / "origin.git", folder / "tree"
    git(folder, "init", "-q", "--bare", str(bare))
    git(bare, "config", "uploadpack.allowAnySHA1InWant", "true")
    git(folder, "init", "-q", str(tree))
    git(tree, "remote", "add", "origin", str(bare))
    for name in PACKAGES:
        shutil.copytree(ROOT / name, tree / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("Makefile", "pyproject.toml", "requirements.lock", ".gitignore"):
        shutil.copy(ROOT / name, tree / name)
    (tree / "docs").mkdir()
    shutil.copy(ROOT / "docs" / "book.md", tree / "docs" / "book.md")
    (tree / "few.toml").write_text(ONE_CASE)
    sound = commit(tree, "sound")
    path = tree / "adapters" / "reference" / "surfaces.py"
    text = path.read_text()
    for exchange in FAULTY["surfaces.py"]:
        assert text.count(exchange[0]) == 1
        text = text.replace(*exchange)
    path.write_text(text)
    return bare, sound, commit(tree, "more friction")


def job(file: str, name: str) -> Job:
    return next(job for job in jobs() if (job.file, job.name) == (file, name))


def options(study: str) -> str:
    return f"--study {study} --engine reference --engine mujoco"


def test_a_history_is_handed_on_by_its_branch_and_what_is_worse_opens_one_issue(
    tmp_path: Path, origin: tuple[Path, str, str]
) -> None:
    """Four nights by the inputs of the workflow: sound, sound, with the fault, with the fault; and one whose study is wrong."""
    bare, sound, faulty = origin

    def night(number: int, sha: str, study: str = "few.toml") -> Runner:
        contexts: dict[str, Any] = {"inputs": {"budget": BUDGET, "options": options(study)}}
        runner = Runner(tmp_path / str(number), bare, contexts, sha)
        runner.carry_out(job("nightly.yml", "history"))
        print(runner.log)
        return runner

    def kept() -> tuple[str, list[str]]:
        tip = git(bare, "rev-parse", "refs/heads/history")
        files = git(bare, "ls-tree", "-r", "--name-only", tip).splitlines()
        return tip, sorted({name.split("/")[2] for name in files if name.startswith("plumbline/nights/")})

    nights = [night(0, sound), night(1, sound)]
    assert [runner.failed for runner in nights] == [False, False]
    assert [runner.calls for runner in nights] == [[], []]
    tip, stamps = kept()
    assert len(stamps) == 2
    plan = json.loads(git(bare, "show", f"{tip}:plumbline/nights/{stamps[1]}/night.json"))
    assert plan["recalled"] > 0
    assert plan["recalled"] + plan["again"] == plan["answers"]
    assert "Nothing of this night was seen before" in nights[0].summary
    assert "changes/summary.md" in nights[1].artefacts["night"]
    assert "report/index.html" in nights[1].artefacts["night"]

    worse, again = night(2, faulty), night(3, faulty)
    assert (worse.failed, again.failed) == (False, False)
    ((words, body),) = worse.calls
    assert words[:3] == ["issue", "create", "--title"]
    assert "--body-file" in words
    assert "friction_stop on reference" in body
    assert body == worse.summary
    assert 0 < len(body) <= LONGEST
    assert again.calls == []
    assert "Still worse since an earlier night" in again.summary

    before = kept()
    assert len(before[1]) == 4
    wrong = night(4, sound, study="nowhere.toml")
    assert (wrong.failed, wrong.codes["night"], wrong.calls, wrong.summary) == (True, 2, [], "")
    assert kept() == before
    sizes = git(bare, "cat-file", "--batch-all-objects", "--batch-check=%(objectsize)").splitlines()
    assert max(map(int, sizes)) < LARGEST
    files = git(bare, "ls-tree", "-r", "--name-only", before[0]).splitlines()
    assert git(bare, "rev-list", "--count", before[0]) == "1"
    assert not [name for name in files if "/report/" in name or "/recordings/" in name or name == "plumbline/lock"]


@pytest.mark.parametrize("fork", [False, True], ids=["of this repository", "of a fork"])
def test_a_pull_request_that_makes_ours_worse_fails_and_says_so_below(
    tmp_path: Path, origin: tuple[Path, str, str], fork: bool
) -> None:
    bare, sound, faulty = origin
    asked = {"number": 7, "base": {"sha": sound}, "head": {"repo": {"full_name": "stranger/name" if fork else "owner/name"}}}
    contexts = {
        "github": {"event": {"pull_request": asked}},
        "vars": {
            "PLUMBLINE_PULL_REQUEST_BUDGET": BUDGET,
            "PLUMBLINE_PULL_REQUEST_OPTIONS": options("base/few.toml"),
        },
    }
    runner = Runner(tmp_path / "runner", bare, contexts, faulty).carry_out(job("pull-request.yml", "what-changed"))
    print(runner.log)
    assert (runner.failed, runner.codes["head"], runner.codes["a comment"]) == (True, 1, 0)
    assert "friction_stop on reference" in runner.summary
    assert 0 < len(runner.summary) <= LONGEST
    if fork:
        assert runner.calls == []
    else:
        ((words, body),) = runner.calls
        assert words[:5] == ["pr", "comment", "7", "-R", "owner/name"]
        assert body == runner.summary


@pytest.mark.parametrize(("study", "code"), [("nowhere.toml", None), ("base/few.toml", 3)], ids=["of the base", "of the head"])
def test_a_pull_request_whose_night_does_not_begin_posts_nothing(
    tmp_path: Path, origin: tuple[Path, str, str], study: str, code: int | None
) -> None:
    """The base stops all; where the head does not begin, the night of the base is no summary of it."""
    bare, sound, _ = origin
    git(tmp_path, "clone", "-q", "-b", "main", str(bare), "tree")
    (tmp_path / "tree" / "harness" / "cli" / "__main__.py").write_text("raise SystemExit(3)\n")
    broken = commit(tmp_path / "tree", "broken", f"broken-{code}")
    asked = {"number": 7, "base": {"sha": sound}, "head": {"repo": {"full_name": "owner/name"}}}
    contexts = {
        "github": {"event": {"pull_request": asked}},
        "vars": {"PLUMBLINE_PULL_REQUEST_BUDGET": BUDGET, "PLUMBLINE_PULL_REQUEST_OPTIONS": options(study)},
    }
    runner = Runner(tmp_path / "runner", bare, contexts, broken)
    runner.carry_out(job("pull-request.yml", "what-changed"))
    print(runner.log)
    assert runner.failed
    assert runner.codes.get("head") == code
    assert (runner.calls, runner.summary) == ([], "")
