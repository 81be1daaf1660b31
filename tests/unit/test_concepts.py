"""The index of concepts: all rows of the page of chapters, and no link that leads nowhere."""

import re
from pathlib import Path

import pytest

from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.study import load_study
from plumbline.reports.pages import case, concepts
from plumbline.reports.words.glossary import PLACES, book, chapters, indexed
from tests.run_folder import write_run_folder

SOURCE = (PLACES[1] / "book.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(write_run_folder(tmp_path_factory.mktemp("concepts") / "run", only=("stack_tower", "joint_pendulum")))


def test_every_row_of_the_chapters_is_a_concept_with_a_case_or_a_reason() -> None:
    rows = [line for line in SOURCE.splitlines() if line.startswith("| ") and not line.startswith("| concept |")]
    made = [concept for chapter in book() for concept in chapter.concepts]
    assert [f"| {concept.name} |" for concept in made] == [re.match(r"\| [^|]+ \|", row)[0] for row in rows]  # type: ignore[index]
    assert all((concept.case in plugins.names("cases")) != bool(concept.without) for concept in made)
    assert all((PLACES[1].parent / concept.file).is_file() for concept in made)


def test_a_link_leads_to_a_page_and_a_chart_of_the_report_and_else_the_command_is_said(store: Store) -> None:
    (page,) = concepts.PAGE.render(store).values()
    files = dict(case.PAGE.render(store))
    links = re.findall(r'href="(case-[\w-]+\.html)(?:#([\w-]+))?"', page)
    assert ("case-stack_tower.html", "") in links
    assert ("case-joint_pendulum.html", "case-joint_pendulum-step") in links
    for file, place in links:
        assert file in files
        assert not place or f'id="{place}"' in files[file]
    for place in re.findall(r'href="#([\w-]+)"', page):
        assert place == "content" or f'id="{place}"' in page
    assert "plumbline run accuracy --case flight_projectile" in page


def test_the_study_that_is_named_asks_about_every_case_of_the_chapters() -> None:
    asked = load_study("accuracy").experiments
    for chapter in book():
        for concept in chapter.concepts:
            assert not concept.case or any(experiment.asks(concept.case) for experiment in asked)


def test_a_run_without_a_case_of_the_chapters_has_no_index(tmp_path: Path) -> None:
    assert not indexed(Store(write_run_folder(tmp_path / "run", only=("rest_table",))))


def test_a_chapter_without_a_table_is_left_out() -> None:
    row = "| x | `y` | [f.py](../f.py) | none: why |"
    text = f"# T\n\n## Empty\n\nwords\n\n## One two\n\n| a | b | c | d |\n|---|---|---|---|\n{row}\n"
    (chapter,) = chapters(text)
    assert (chapter.title, chapter.anchor) == ("One two", "one-two")
    assert (chapter.concepts[0].formula, chapter.concepts[0].file, chapter.concepts[0].without) == ("y", "f.py", "why")
