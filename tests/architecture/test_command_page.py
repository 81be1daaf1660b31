"""`docs/cli.md` is what the code says, and help texts name all criteria, presets and families."""

import os
from pathlib import Path

import click
import pytest

from plumbline.harness.cli.command_page import page
from plumbline.harness.cli.main import main
from plumbline.harness.findings.selection import CRITERIA, preset_names
from plumbline.harness.study.plugins import names
from plumbline.reports.words.glossary import entries, glossary

FILE = Path(__file__).parents[2] / "docs" / "cli.md"


def test_the_page_is_what_the_code_says() -> None:
    written = page(main)
    if os.environ.get("PLUMBLINE_GOLDEN") == "write":
        FILE.write_text(written, encoding="utf-8")
    assert FILE.read_text(encoding="utf-8") == written


def test_every_command_has_a_part_and_an_example() -> None:
    text = FILE.read_text(encoding="utf-8")
    examples = text.partition("## Commands and options")[0]
    for name in main.list_commands(click.Context(main)):
        assert f"\n### plumbline {name}\n" in text
        assert f"plumbline {name}" in examples


@pytest.mark.parametrize(
    ("option", "expected"),
    [
        ("weight", tuple(CRITERIA)),
        ("preset", preset_names()),
        ("need", tuple(sorted({name.partition("_")[0] for name in names("cases")}))),
    ],
)
def test_help_names_each_criterion_preset_and_family(option: str, expected: tuple[str, ...]) -> None:
    select = main.commands["select"]
    (help_text,) = (each.help or "" for each in select.params if isinstance(each, click.Option) and each.name == option)
    assert [word for word in expected if word not in help_text] == []


def test_the_glossary_has_each_word_once_and_a_meaning() -> None:
    listed = [word.lower() for entry in glossary() for word in entry.words]
    assert len(listed) > 50
    assert sorted(listed) == sorted(set(listed))
    assert all(len(entry.meaning) > 10 for entry in glossary())
    assert len({entry.anchor for entry in glossary()}) == len(glossary())
    one = entries("## A\n\n| word | meaning |\n|---|---|\n| b, c d | Of `e`. |\n")
    assert [(entry.section, entry.words, entry.meaning, entry.anchor) for entry in one] == [("A", ("b", "c d"), "Of `e`.", "b")]
