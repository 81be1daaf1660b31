"""What people expect of a repository: a citation, a way to report a flaw, forms for issues, a changelog, hooks of commits."""

import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from plumbline.harness.cli.main import main

ROOT = Path(__file__).parents[2]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("[0-9]*.yml"))
PAGES = [*FORMS, ROOT / "SECURITY.md"]


def read(name: str) -> Any:
    return yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))


def test_the_citation_is_of_the_version_and_licence_of_the_package() -> None:
    """Fields that the format demands: cff-version, message, title, authors (Druskat et al., Citation File Format 1.2.0)."""
    citation = read("CITATION.cff")
    assert citation["cff-version"] == "1.2.0"
    assert all(citation[field] for field in ("message", "title", "authors"))
    assert str(citation["version"]) == PROJECT["version"]
    assert citation["license"] == PROJECT["license"]


def test_there_is_a_form_for_a_wrong_claim_a_new_engine_and_a_bug() -> None:
    assert [path.stem.partition("-")[2] for path in FORMS] == ["wrong-claim", "new-engine", "bug"]
    for path in FORMS:
        form = yaml.safe_load(path.read_text(encoding="utf-8"))
        assert form["name"], path
        assert form["description"], path
        fields = [part for part in form["body"] if part["type"] != "markdown"]
        names = [field["id"] for field in fields]
        assert len(set(names)) == len(names), path
        assert all(field["attributes"]["label"] for field in fields)
        assert any(field.get("validations", {}).get("required") for field in fields)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_commands_and_pages_that_forms_name_are_there(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    for words in map(shlex.split, re.findall(r"`plumbline ([a-z][^`]*)`", text)):
        command = main.commands.get(words[0])
        assert command is not None, words
        options = {option for parameter in command.params for option in parameter.opts}
        assert {word for word in words if word.startswith("--")} <= options, words
    for name in re.findall(r"docs/[\w.-]+\.md|CONTRIBUTING", text):
        assert (ROOT / name).exists() or (ROOT / f"{name}.md").exists(), name


def test_the_changelog_has_the_version_with_what_breaks_first() -> None:
    sections = re.split(r"^## ", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    assert PROJECT["version"] in [section.partition("\n")[0].split()[0] for section in sections]
    for section in sections:
        headings = re.findall(r"^### (.+)$", section, flags=re.MULTILINE)
        lines = section.split("\n", 1)[1].lstrip()
        assert headings[:1] in ([], ["Breaking"]), "what breaks stands first"
        assert not headings or lines.startswith("### Breaking"), "a line stands above what breaks"


def test_the_hooks_call_what_lint_calls() -> None:
    hooks = {hook["id"]: hook for repository in read(".pre-commit-config.yaml")["repos"] for hook in repository["hooks"]}
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for name, words in (("ruff-check", "ruff check"), ("ruff-format", "ruff format --check")):
        assert f".venv/bin/{words}" in hooks[name]["entry"]
        assert f"$(BIN)/{words} ." in makefile
    assert hooks["lint"]["entry"] == "make lint"
    assert all(hook["language"] == "system" for hook in hooks.values()), "tools are those of requirements.lock"


def test_the_set_up_names_targets_that_are_there() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## Set-up")[2].partition("\n## ")[0]
    targets = set(re.findall(r"`make ([\w./-]+)", text))
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert {"lint", "test"} <= targets
    for target in targets - {".venv/.installed"}:
        assert re.search(rf"^{re.escape(target)}:", makefile, flags=re.MULTILINE), target
