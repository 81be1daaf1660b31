"""What workflows, cron lines and timers ask for exists: commands, options, targets, folders, inputs; rights are the least."""

import re
import shlex
import subprocess
from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path

import click
import pytest

from plumbline.harness.cli.main import main
from tests.workflows import ACTIONS, ROOT, Job, evaluated, filled, jobs

JOBS = tuple(jobs())
NEEDS = {"git push": "contents", "gh issue create": "issues", "gh pr comment": "pull-requests"}
"""Commands of steps, and what GitHub's token has to be allowed to write for them."""
PROGRAM = re.compile(r"(?:^|(?<=[\s=/`]))plumbline\s+(?=[a-z])(.*)")
UNSET = {"inputs": "", "vars": "", "steps": ""}
DOCS = tuple(sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md")]))


class Anything(str):
    """A context in which every name is set to nothing."""

    def __getattr__(self, name: str) -> "Anything":
        if name.startswith("__"):
            raise AttributeError(name)
        return self


def ids(job: Job) -> str:
    return f"{job.file}:{job.name}"


def contexts(matrix: dict[str, str] | None = None) -> dict[str, object]:
    """Every context with nothing set, but the matrix."""

    class Matrix(Anything):
        def __getattr__(self, name: str) -> str:  # type: ignore[override]
            return (matrix or {}).get(name, "")

    return {name: Anything() for name in ("github", "inputs", "vars", "steps")} | {"matrix": Matrix()}


def said_in_blocks(path: Path) -> Iterator[str]:
    """The lines of blocks of commands in a page, whose remarks stand behind two blanks."""
    inside, commands = False, False
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("```"):
            inside, commands = not inside, line != "```python"
        elif inside and commands:
            yield re.split(r"\s{2,}", line.strip())[0]


def said_by(job: Job) -> Iterator[str]:
    """The lines of shell of a job, its own variables put in."""
    known = job.environment(contexts())
    for line in job.commands.replace("\\\n", " ").splitlines():
        text = filled(line, contexts()).partition("  #")[0]
        yield re.sub(r"\$(\w+)", lambda name: known[name[1]] if name[1] in known else name[0], text)


def asked(line: str) -> list[str] | None:
    """The words behind `plumbline` in a line; None where it is not called there."""
    found = PROGRAM.search(line)
    if found is None or line.lstrip().startswith("#"):
        return None
    lexer = shlex.shlex(found[1], posix=True, punctuation_chars=True)
    lexer.whitespace_split = True
    return list(takewhile(lambda word: not set(word) <= set(";&|<>()"), lexer))


def parse(words: list[str]) -> None:
    """Raises: click.UsageError, where a command or an option is not there, or the value of an option is none of it."""
    command: click.Command = main
    context = click.Context(command, info_name="plumbline")
    while isinstance(command, click.Group):
        inner = command.get_command(context, words[0])
        if inner is None and command.name == "history":  # `history DIR` lists
            inner, words = command.commands["nights"], ["nights", *words]
        if inner is None:
            raise click.UsageError(f"no command {words[0]!r}")
        command, words = inner, words[1:]
        context = click.Context(command, info_name=words[0] if words else command.name, parent=context)
    values, _, _ = command.make_parser(context).parse_args(args=list(words))
    for option in command.params:
        if isinstance(option, click.Option) and option.name in values:
            option.type_cast_value(context, values[option.name])


CALLED = [
    *((ids(job), words) for job in JOBS for line in said_by(job) if (words := asked(line))),
    *((path.name, words) for path in DOCS for line in said_in_blocks(path) if (words := asked(line))),
]


def test_calls_are_found_where_they_stand() -> None:
    """Two nights of a pull request, the night with its pruning, the cron line and the timer, and what the pages show."""
    places = [place for place, _ in CALLED]
    assert places.count("pull-request.yml:what-changed") == 2
    assert places.count("nightly.yml:history") == 2
    assert places.count("nightly.md") >= 3
    assert places.count("cli.md") > 30
    nightly = next(words for place, words in CALLED if place == "nightly.yml:history")
    assert nightly == ["nightly", "--history", "history/plumbline", "--budget", "2h", "--keep", "none"]


@pytest.mark.parametrize(
    ("place", "words"), CALLED, ids=lambda value: value if isinstance(value, str) else " ".join(value)[:60]
)
def test_a_command_that_is_written_down_exists_with_its_options(place: str, words: list[str]) -> None:
    parse(words)


@pytest.mark.parametrize("words", ["nightly --histroy h", "nigthly", "nightly --budget 2y", "history h --keep-night 3"])
def test_a_misspelt_one_is_seen(words: str) -> None:
    with pytest.raises(click.UsageError):
        parse(words.split())


@pytest.mark.parametrize("job", JOBS, ids=ids)
def test_a_job_may_write_what_its_commands_write_and_no_more(job: Job) -> None:
    assert set(job.permissions.values()) <= {"read", "write"}
    allowed = {name for name, right in job.permissions.items() if right == "write"}
    assert allowed == {right for command, right in NEEDS.items() if command in job.commands}
    assert job.workflow["permissions"]["contents"] == "read"
    assert ("gh " in job.commands) == ("GH_TOKEN" in job.said.get("env", {}))
    assert isinstance(job.said["timeout-minutes"], int)


@pytest.mark.parametrize("job", JOBS, ids=ids)
def test_actions_are_known_and_given_what_they_take(job: Job) -> None:
    for step in job.steps:
        assert ("uses" in step) != ("run" in step)
        if "uses" in step:
            needed, others = ACTIONS[step["uses"].partition("@")[0]]
            assert needed <= set(step.get("with", {})) <= needed | others


@pytest.mark.parametrize("job", JOBS, ids=ids)
def test_what_strangers_write_never_becomes_part_of_a_script(job: Job) -> None:
    """A title or a branch that is put into shell text is run; through a variable it is a word. A matrix is our own text."""
    assert job.shell == "bash"  # with pipefail, which a runner's own default leaves out
    assert not re.findall(r"\$\{\{(?!\s*matrix\.)", job.commands)


@pytest.mark.parametrize("job", JOBS, ids=ids)
def test_targets_and_folders_of_make_are_there(job: Job) -> None:
    for matrix in job.said.get("strategy", {}).get("matrix", {}).get("include", [{}]):
        for line in filled(job.commands, contexts(matrix)).splitlines():
            words = shlex.split(line, comments=True)
            if words[:1] != ["make"]:
                continue
            words = [word for pair in zip(["", *words], words, strict=False) for word in pair[1:] if "-C" not in pair]
            done = subprocess.run(
                ["make", "-n", "-o", ".venv/.installed", *words[1:]], cwd=ROOT, capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, done.stderr
            given = dict(word.split("=", 1) for word in words if "=" in word)
            for folder in given.get("TESTS", "").split():
                assert (ROOT / folder).is_dir()
            if given.get("MARKED"):
                assert f'-m "{given["MARKED"]}" {given["TESTS"]}' in done.stdout
                marks = set(given["MARKED"].split()) - {"and", "not"}
                assert all(f'"{mark}: ' in (ROOT / "pyproject.toml").read_text() for mark in marks)


def test_all_folders_of_tests_are_run_by_a_job() -> None:
    (test,) = (job for job in JOBS if (job.file, job.name) == ("ci.yml", "test"))
    named = {word for row in test.said["strategy"]["matrix"]["include"] for word in row["tests"].split()}
    assert named == {f"tests/{path.parent.name}" for path in (ROOT / "tests").glob("*/test_*.py")}


def test_conditions_can_be_read() -> None:
    known = contexts() | {"always": lambda: True, "success": lambda: True, "failure": lambda: False}
    for job in JOBS:
        for step in job.steps:
            evaluated(str(step.get("if", "success()")), known)
