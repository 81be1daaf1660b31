"""The report on paper: one page of all pages whose links stay within it, and a word where no browser prints it."""

import re
import sys
from pathlib import Path

import pytest

from plumbline.harness.store.store import Store
from plumbline.reports.html import report as html
from plumbline.reports.html.report import write_report
from plumbline.reports.page import pages as registered
from plumbline.reports.paper.printing import NotPrinted, Sheet, browser, joined, print_report
from tests.conftest import Command
from tests.links import texts_of
from tests.run_folder import BAD_CASE, write_run_folder


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = write_run_folder(tmp_path_factory.mktemp("paper") / "run", hostile=True, only=(BAD_CASE,))
    pages = {name: str(text) for name, text in texts_of(Store(folder)).items() if name.endswith(".html")}
    return joined([Sheet(name.removesuffix(".html"), text) for name, text in pages.items()], "A <title>", [("a", "<b>")])


def test_every_link_within_the_report_leads_to_a_place_on_the_page(whole: str) -> None:
    places = re.findall(r' id="([^"]*)"', whole)
    assert len(places) == len(set(places))
    inside = set(re.findall(r' href="#([^"]*)"', whole))
    assert inside
    assert inside <= set(places)
    assert not re.findall(r' href="[\w-]+\.html', whole)


def test_contents_come_first_and_nothing_on_the_page_can_run(whole: str) -> None:
    contents = whole[: whole.index("</ol>")]
    assert contents.count("<li>") == whole.count('<article class="sheet" id=')
    assert "<script" not in whole
    assert "<img src=x" not in whole
    assert "A &lt;title&gt;" in contents


def test_addresses_of_other_pages_and_of_places_are_told_apart() -> None:
    first = Sheet(
        "one", '<main><h1 id="top">One &amp; all</h1><a href="two.html#x">a</a><a href="#top">b</a></main><p>foot</p>'
    )
    second = Sheet(
        "two", '<main><h1>Two</h1><p id="x"><a href="https://example.org/two.html">c</a><script>no()</script></p></main>'
    )
    page = joined([first, second], "t", [])
    assert '<li><a href="#one">One &amp; all</a></li>' in page
    assert 'href="#two--x"' in page
    assert 'href="#one--top"' in page
    assert 'href="https://example.org/two.html"' in page
    assert "foot" not in page
    assert "no()" not in page


@pytest.fixture
def only_index(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports have their first page alone: one is printed as many are."""
    monkeypatch.setattr(html, "pages", lambda: tuple(page for page in registered() if page.name == "index"))


@pytest.mark.usefixtures("only_index")
def test_where_no_browser_prints_the_command_says_what_to_do(
    tmp_path: Path, printed: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLUMBLINE_CHROMIUM", "no-such-browser")
    with pytest.raises(NotPrinted, match="'no-such-browser', which is no program"):
        browser()
    monkeypatch.delenv("PLUMBLINE_CHROMIUM")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(NotPrinted, match="install Chromium, Chrome or Edge"):
        browser()
    folder = write_run_folder(tmp_path / "run", only=("stack_tower",))
    done = printed("report", folder, "--pdf")
    assert done.returncode == 3
    assert done.stdout.splitlines() == [str(folder / "report" / "index.html")]
    assert "install Chromium, Chrome or Edge" in done.stderr
    assert not (folder / "report" / "report.pdf").exists()


@pytest.mark.usefixtures("only_index")
def test_a_folder_named_from_here_is_printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By a stand-in that writes down what it was asked to print, and where."""
    program = tmp_path / "browser"
    program.write_text(
        f"#!{sys.executable}\nimport sys\n"
        "(out,) = (word.partition('=')[2] for word in sys.argv if word.startswith('--print-to-pdf='))\n"
        "open(out, 'w').write('%PDF-' + sys.argv[-1] + ' %%EOF')\n"
    )
    program.chmod(0o755)
    write_run_folder(tmp_path / "run", only=("stack_tower",))
    monkeypatch.setenv("PLUMBLINE_CHROMIUM", str(program))
    monkeypatch.chdir(tmp_path)
    write_report(Path("run"))
    printed_to = print_report(Path("run"))
    assert printed_to == Path("run/report/report.pdf")
    assert printed_to.read_text().startswith(f"%PDF-{(tmp_path / 'run' / 'report').as_uri()}/.print.")
