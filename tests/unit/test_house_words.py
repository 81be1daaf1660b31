"""House words lead to the glossary where a page of the report, or of `docs`, first has them."""

import re
from pathlib import Path

import pytest

from plumbline.reports.html.template import explained
from plumbline.reports.words.glossary import HOUSE_WORDS, WORD, glossary, house_word, linked
from tests.conftest import Command
from tests.links import dangling, files_of
from tests.run_folder import write_run_folder

ROOT = Path(__file__).parents[2]
DOCS = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").glob("*.md") if path.name != "glossary.md")
LEFT = re.compile(r"<(script|style|svg|code)\b.*?</\1>|<[^>]*>", re.DOTALL | re.IGNORECASE)
"""What of a page is no text."""


def page(content: str) -> str:
    return f'<title>A ladder</title><main id="content">\n{content}</main><footer>a track</footer>'


def links(text: str) -> list[tuple[str, str]]:
    """Anchor and words of each link, in their order."""
    return re.findall(r'<a class="word" href="glossary\.html#([^"]*)" title="[^"]+">([^<]*)</a>', text)


def test_each_house_word_is_an_entry_of_the_glossary() -> None:
    assert HOUSE_WORDS.keys() <= {word for entry in glossary() for word in entry.words}


def test_the_first_of_each_word_that_is_open_to_see_is_a_link_and_no_other() -> None:
    shown = explained(
        page(
            "<h1>Tracks</h1><details><summary>a knob</summary><p>A ladder, a knob.</p></details>"
            '<p class="track">Two <b>tracks</b>, a ladder-like thing, a <a href="x">truth</a>; Tracks of ladders.</p>'
            "<p>ladder</p>"
        )
    )
    assert links(shown) == [("knob", "knob"), ("track", "tracks"), ("ladder", "ladders"), ("truth", "truth")]
    assert '<a href="x">truth</a>' in shown
    assert shown.startswith("<title>A ladder</title>")
    assert shown.endswith("<footer>a track</footer>")


def test_a_word_in_tables_and_headings_alone_is_named_below() -> None:
    shown = explained(page('<h2>Prices</h2><table class="sortable"><tr><th>conformance</th></tr></table><p>None.</p>'))
    assert links(shown) == [("conformance", "conformance"), ("price", "price")]
    assert "<th>conformance</th>" in shown
    assert shown.index("Words in headings and tables") > shown.index("None.")


def test_a_page_without_a_house_word_is_left_as_it_is() -> None:
    text = page('<p class="price">A code: <code>--track</code>, a soundtrack.</p>')
    assert explained(text) == text


def test_every_page_of_a_report_links_each_house_word_once_to_what_it_means(tmp_path: Path) -> None:
    folder = write_run_folder(tmp_path / "run", hostile=True)
    files = files_of(folder)
    pages = {name: str(text) for name, text in files.items() if name.endswith(".html") and name != "glossary.html"}
    anchors = {entry.words[0]: entry.anchor for entry in glossary()}
    assert len(pages) > 10
    for name, text in pages.items():
        content = text.partition('<main id="content">')[2].rpartition("</main>")[0]
        met = {house_word(found) for found in WORD.finditer(LEFT.sub(" ", content))}
        assert sorted(anchor for anchor, _ in links(content)) == sorted(anchors[word] for word in met), name
    assert dangling(folder, files) == []
    assert "track" in {anchor for anchor, _ in links(pages["index.html"])}


def test_the_command_knows_a_word_as_pages_write_it(printed: Command) -> None:
    assert printed("glossary", "resamples").stdout.startswith("resample: ")
    assert printed("glossary", "remedies").stdout == printed("glossary", "remedy").stdout
    assert printed("glossary", "walruses").returncode == 2


def test_the_first_of_each_word_in_prose_leads_to_its_section() -> None:
    text = "# Tracks\n\n| track |\n\n`track`, [a track](x.md), Tracks and tracks.\n\n```\nladder\n```\nA ladder.\n"
    once = linked(text, "docs/glossary.md")
    section = "docs/glossary.md#what-is-asked"
    assert once == text.replace("Tracks and", f"[Tracks]({section}) and").replace("A ladder", f"A [ladder]({section})")
    assert linked(once, "docs/glossary.md") == once


@pytest.mark.parametrize("name", ["README.md", *DOCS])
def test_every_page_of_the_documents_links_the_first_of_each_house_word(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    assert linked(text, "docs/glossary.md" if name == "README.md" else "glossary.md") == text
