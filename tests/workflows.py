"""Workflows of GitHub without GitHub: read by a YAML parser, their steps carried out here, in order, as a runner does.

What a step of commands sees is what a runner gives it: bash with `-eo pipefail`, files for outputs, environment and summary,
expressions resolved from contexts. What an action does is emulated as far as a later step needs it: a checkout is a shallow
fetch from a local repository, an artefact is looked at. `gh` is a script that keeps what it was called with. A name that no
context has is an error here, where GitHub would take it for ''.
"""

import os
import re
import stat
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

__all__ = ["ACTIONS", "ROOT", "Job", "Runner", "evaluated", "filled", "jobs"]

ROOT = Path(__file__).parents[1]
ACTIONS: Mapping[str, tuple[frozenset[str], frozenset[str]]] = {
    "actions/checkout": (frozenset(), frozenset({"repository", "ref", "token", "path", "persist-credentials", "fetch-depth"})),
    "actions/setup-python": (frozenset(), frozenset({"python-version", "cache", "cache-dependency-path", "check-latest"})),
    "actions/cache": (frozenset({"path", "key"}), frozenset({"restore-keys", "fail-on-cache-miss", "lookup-only"})),
    "actions/upload-artifact": (frozenset({"path"}), frozenset({"name", "if-no-files-found", "retention-days"})),
}
"""By action: inputs that it needs, others that it has. Source: action.yml of each, at the major version that is pinned."""
_EXPRESSION = re.compile(r"\$\{\{(.*?)\}\}", re.DOTALL)
_NOT_IN_AN_ARTEFACT = set('":<>|*?\r\n')
"""Source: the documentation of actions/upload-artifact: characters that file systems refuse."""
_GH = """#!/bin/sh
# What gh needs: a token, and a repository, named or that of the folder.
[ -n "$GH_TOKEN" ] || { echo 'gh: set GH_TOKEN' >&2; exit 4; }
case " $* " in *' -R '*) ;; *) git remote get-url origin > /dev/null || exit 1 ;; esac
call="$GH_CALLS/$(ls "$GH_CALLS" | wc -l)"
printf '%s\\n' "$@" > "$call.words"
while [ $# -gt 0 ]; do
  if [ "$1" = --body-file ]; then cp "$2" "$call.body" || exit 1; fi
  shift
done
"""


class _Context(dict[str, Any]):
    """A part of a context: `a.b` is a key."""

    def __getattr__(self, name: str) -> Any:
        value = self[name]
        return _Context(value) if type(value) is dict else value


class _Optional(_Context):
    """A part of a context in which what is not set is '': inputs, variables, outputs."""

    def __getattr__(self, name: str) -> Any:
        return self.get(name, "")


def evaluated(expression: str, contexts: Mapping[str, Any]) -> Any:
    """The value of an expression of `&&`, `||`, `==`, `!=`, words and names. Raises: NameError, KeyError: an unknown name."""
    words = expression.strip().replace("&&", " and ").replace("||", " or ")
    return eval(words, {"__builtins__": {}, "format": lambda text, *values: text.format(*values)}, dict(contexts))


def filled(text: str, contexts: Mapping[str, Any]) -> str:
    """A text with every `${{ ... }}` resolved."""
    return _EXPRESSION.sub(lambda match: str(evaluated(match[1], contexts)), text)


@dataclass(frozen=True, slots=True)
class Job:
    """A job of a workflow. Terms: said: its mapping; workflow: that of the whole file, `file` its name."""

    file: str
    name: str
    said: Mapping[str, Any]
    workflow: Mapping[str, Any]

    @property
    def steps(self) -> list[Mapping[str, Any]]:
        """In order."""
        return list(self.said["steps"])

    @property
    def permissions(self) -> Mapping[str, str]:
        """Its own, else the workflow's."""
        granted: Mapping[str, str] = self.said.get("permissions", self.workflow["permissions"])
        return granted

    @property
    def commands(self) -> str:
        """All its shell text."""
        return "\n".join(str(step["run"]) for step in self.steps if "run" in step)

    @property
    def shell(self) -> str:
        """What its steps are given to. A runner calls 'bash' with `-eo pipefail`; where none is named, without pipefail."""
        return str(self.workflow.get("defaults", {}).get("run", {}).get("shell", ""))

    def environment(self, contexts: Mapping[str, Any]) -> dict[str, str]:
        """What workflow and job set, resolved."""
        said = {**self.workflow.get("env", {}), **self.said.get("env", {})}
        return {name: filled(str(value), contexts) for name, value in said.items()}


def jobs(folder: Path = ROOT / ".github" / "workflows") -> Iterator[Job]:
    """Of all workflows."""
    for path in sorted(folder.glob("*.y*ml")):
        workflow = yaml.safe_load(path.read_text(encoding="utf-8"))
        for name, said in workflow["jobs"].items():
            yield Job(path.name, name, said, workflow)


@dataclass(slots=True)
class Runner:
    """A machine that carries out one job.

    Terms:
        folder: its own, fresh. origin: a bare repository. contexts: `github`, `inputs`, `vars`. sha: what is checked out where
        no ref is named.
        failed: did a step fail? codes: of the steps of commands, by id or name. summary: what the job's page shows. calls:
        words and body of each call of gh. artefacts: files by name. log: what steps printed.
    """

    folder: Path
    origin: Path
    contexts: dict[str, Any]
    sha: str
    failed: bool = False
    codes: dict[str, int] = field(default_factory=dict)
    artefacts: dict[str, list[str]] = field(default_factory=dict)
    log: str = ""
    _outputs: dict[str, _Optional] = field(default_factory=dict)
    _added: dict[str, str] = field(default_factory=dict)

    @property
    def workspace(self) -> Path:
        """Where steps begin."""
        return self.folder / "workspace"

    @property
    def summary(self) -> str:
        """GITHUB_STEP_SUMMARY of all steps."""
        path = self.folder / "summary"
        return path.read_text(encoding="utf-8") if path.is_file() else ""

    @property
    def calls(self) -> list[tuple[list[str], str]]:
        """Of gh."""
        words = sorted((self.folder / "calls").glob("*.words"))
        bodies = [path.with_suffix(".body") for path in words]
        return [
            (path.read_text().splitlines(), body.read_text(encoding="utf-8") if body.is_file() else "")
            for path, body in zip(words, bodies, strict=True)
        ]

    def carry_out(self, job: Job) -> "Runner":
        """Step after step; what comes behind a failure runs only where it says `always()`. Returns: this runner."""
        assert job.shell == "bash"
        self._outputs = {step["id"]: _Optional() for step in job.steps if "id" in step}  # a step that is left out has none
        for name in ("workspace", "calls", "bin"):
            (self.folder / name).mkdir(parents=True)
        gh = self.folder / "bin" / "gh"
        gh.write_text(_GH)
        gh.chmod(gh.stat().st_mode | stat.S_IXUSR)
        for number, step in enumerate(job.steps):
            known = self._known()
            condition = str(step.get("if", "success()"))
            if not re.search(r"\b(always|success|failure|cancelled)\(\)", condition):
                condition = f"success() && ({condition})"
            if not evaluated(condition, known):
                continue
            if "run" in step:
                self._run(number, step, job)
            else:
                self._act(step["uses"].partition("@")[0], {k: filled(str(v), known) for k, v in step.get("with", {}).items()})
        return self

    def _known(self) -> dict[str, Any]:
        failed = self.failed
        github = {"token": "a-token", "repository": "owner/name", "workspace": str(self.workspace)}
        return {
            "github": _Context(github | self.contexts.get("github", {})),
            "inputs": _Optional(self.contexts.get("inputs", {})),
            "vars": _Optional(self.contexts.get("vars", {})),
            "steps": _Context({name: {"outputs": outputs} for name, outputs in self._outputs.items()}),
            "always": lambda: True,
            "success": lambda: not failed,
            "failure": lambda: failed,
        }

    def _run(self, number: int, step: Mapping[str, Any], job: Job) -> None:
        known, name = self._known(), str(step.get("id", step.get("name", step["run"])))
        script, said = self.folder / f"step-{number}.sh", {"GITHUB_OUTPUT": "", "GITHUB_ENV": ""}
        script.write_text(filled(step["run"], known), encoding="utf-8")
        for file in said:
            path = self.folder / f"{file.lower()}-{number}"
            path.touch()
            said[file] = str(path)
        own = {key: filled(str(value), known) for key, value in step.get("env", {}).items()}
        done = subprocess.run(
            ["bash", "--noprofile", "--norc", "-eo", "pipefail", str(script)],
            cwd=self.workspace,
            env=self._environment() | said | job.environment(known) | self._added | own,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        self.log += f"--- {name}: {done.returncode}\n{done.stdout}"
        self.codes[name] = done.returncode
        self.failed |= done.returncode != 0 and not step.get("continue-on-error", False)
        if "id" in step:
            self._outputs[step["id"]] = _Optional(_pairs(Path(said["GITHUB_OUTPUT"])))
        self._added |= _pairs(Path(said["GITHUB_ENV"]))

    def _environment(self) -> dict[str, str]:
        """Of a runner's shell: no settings of git but those that a step makes, nothing that Python would be led by."""
        kept = {key: value for key, value in os.environ.items() if key in ("HOME", "PATH", "LANG", "TMPDIR", "XDG_CACHE_HOME")}
        return kept | {
            "PATH": f"{self.folder / 'bin'}:{kept['PATH']}",
            "CI": "true",
            "GH_CALLS": str(self.folder / "calls"),
            "GITHUB_REPOSITORY": "owner/name",
            "GITHUB_STEP_SUMMARY": str(self.folder / "summary"),
            "GITHUB_WORKSPACE": str(self.workspace),
            "GIT_CONFIG_GLOBAL": os.devnull,
            "GIT_CONFIG_SYSTEM": os.devnull,
        }

    def _act(self, action: str, given: Mapping[str, str]) -> None:
        if action == "actions/checkout":
            self._check_out(self.workspace / given.get("path", "."), given.get("ref", self.sha))
        elif action == "actions/upload-artifact":
            root = self.workspace / given["path"]
            files = sorted(str(path.relative_to(root)) for path in root.rglob("*") if path.is_file())
            assert not any(set(name) & _NOT_IN_AN_ARTEFACT for name in files)
            self.artefacts[given["name"]] = files
        else:
            assert action in ACTIONS

    def _check_out(self, folder: Path, ref: str) -> None:
        """As the action does: one commit, a detached head, `origin` with the right to push. Python and packages are at hand."""
        folder.mkdir(parents=True, exist_ok=True)
        for words in (
            ["init", "-q"],
            ["remote", "add", "origin", self.origin.as_uri()],
            ["fetch", "-q", "--depth", "1", "origin", ref],
            ["checkout", "-q", "--detach", "FETCH_HEAD"],
        ):
            subprocess.run(["git", *words], cwd=folder, env=self._environment(), check=True)
        program = folder / ".venv" / "bin" / "plumbline"
        program.parent.mkdir(parents=True)
        program.write_text(f'#!/bin/sh\nPYTHONPATH="{folder}/src" exec "{sys.executable}" -m plumbline "$@"\n')
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        (folder / ".venv" / ".installed").touch()


def _pairs(path: Path) -> dict[str, str]:
    """What a step wrote, `name=value` a line."""
    lines = path.read_text(encoding="utf-8").splitlines()
    assert all("=" in line and "<<" not in line for line in lines), lines
    return dict(line.split("=", 1) for line in lines)
