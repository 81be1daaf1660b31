"""Hostile text on every way out, and hostile pages: what engines and files say stays text, wherever it is shown."""

import csv
import io
import re
import subprocess
import sys
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast
from xml.etree import ElementTree

import pandas as pd
import pytest
from click.testing import CliRunner
from markdown_it import MarkdownIt

from plumbline.harness.cli.listing import print_csv, print_json, print_markdown, print_table
from plumbline.harness.cli.main import main
from plumbline.harness.findings.summary import write_summary
from plumbline.harness.store.store import Store
from tests.run_folder import BAD_CASE, write_run_folder
from tests.stress.ledger import Page

HIDDEN = {
    "null byte": "\x00",
    "bell": "\x07",
    "backspaces over the verdict": "failed\x08\x08\x08\x08\x08\x08passed",
    "carriage return over the verdict": "failed\rpassed",
    "line feed that forges a row": "sound\n999 | passed",
    "vertical tab and form feed": "a\x0bb\x0cc",
    "escape that clears the screen": "\x1b[2J\x1b[H",
    "escape that colours": "\x1b[31mred",
    "escape that writes the clipboard": "\x1b]52;c;cm0gLXJm\x07",
    "escape that makes a link": "\x1b]8;;file:///etc/passwd\x1b\\here\x1b]8;;\x1b\\",
    "escape that titles the window": "\x1b]0;owned\x07",
    "control sequence of one byte": "\x9b2J",
    "string command of one byte": "\x90payload\x9c",
    "delete": "a\x7fb",
    "next line": "a\x85b",
    "right-to-left override": "\u202egnp.exe",
    "right-to-left isolate": "\u2067abc\u2069",
    "left-to-right mark": "a\u200eb",
    "space without width": "pas\u200bsed",
    "joiner without width": "pas\u200dsed",
    "line separator": "a\u2028b",
    "paragraph separator": "a\u2029b",
    "mark of byte order": "\ufeffa",
    "tag letters that nobody sees": "a\U000e0041\U000e0042",
    "half a character": "a\udc80b",
    "number that is no character": "a\uffffb",
}
SHOWN = re.compile("[\x20-\x7e\xa0-\xac\xae-\u200a\u2010-\u2027\u2030-\u205f\u2070-\ud7ff\ue000-\ufefe\uff00-\ufff8\ufffd]*")
"""What may stand on a line: nothing that acts, nothing that hides and nothing that turns the direction."""

FORMULAS = {
    "equals": "=cmd|' /C calc'!A0",
    "plus": "+1+cmd|' /C calc'!A0",
    "minus": "-cmd|' /C calc'!A0",
    "minus and a digit": "-2+3+cmd|' /C calc'!A0",
    "minus and a number with a tail": "-1.5e3*HYPERLINK(A1)",
    "at": "@SUM(1+1)*cmd|' /C calc'!A0",
    "tab before": "\t=1+1",
    "carriage return before": "\r=1+1",
    "line feed before": "\n=1+1",
    "space before": " =1+1",
    "wide equals": "\uff1d1+1",
    "wide plus": "\uff0b1+1",
    "wide minus": "\uff0d1+1",
    "wide at": "\uff20SUM(1)",
    "after a semicolon": "a;=1+1",
    "after a semicolon and a space": "a; +1+1",
    "after a line feed": 'a"\n"=1+1',
    "after a tab": "a\t=1+1",
    "behind a mark without width": "\u200b=1+1",
}
FORMULA = re.compile(r"\s*[=+\-@\uff1d\uff0b\uff0d\uff20\t\r\n]")
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?([eE][+-]?\d+)?|inf)")

MARKUP = {
    "link that runs a script": "[x](javascript:window.attacked=1)",
    "link that runs a script, spelled with capitals": "[x](JaVaScRiPt:window.attacked=1)",
    "link to data": "[x](data:text/html;base64,PHNjcmlwdD4=)",
    "link to a file": "[x](file:///etc/passwd)",
    "picture that reports the reader": "![x](https://example.org/seen.png)",
    "link by reference": "[x][y] [y]: javascript:x",
    "address in angles": "<javascript:window.attacked=1>",
    "address of mail in angles": "<a@example.org>",
    "script": "<script>window.attacked=1</script>",
    "picture with a handler": "<img src=x onerror=window.attacked=1>",
    "comment that hides the rest": "<!-- ",
    "entity": "&lt;b&gt; &#106;avascript:",
    "code that swallows the row": "`code",
    "pipe that forges a cell": "a|b",
    "escaped pipe that forges a cell": "a\\|b",
    "twice escaped pipe": "a\\\\|b",
    "strong and emphasised": "**passed** *passed* _passed_ __passed__",
    "struck out": "~~failed~~",
    "line feed that ends the table": "a\n\n# Everything passed\n",
    "carriage return that ends the row": "a\r# Everything passed",
    "tenth of a megabyte": "x" * 100_000,
    "megabyte": "x" * 1_000_000,
}
TEMPLATE = {
    "closing mark of nothing": "[/]",
    "link of the terminal": "[link=file:///etc/passwd]here[/link]",
    "colour": "[red]failed",
    "little picture": ":skull:",
}
Printed = Callable[[str], str]


@pytest.fixture
def printed(capsys: pytest.CaptureFixture[str]) -> dict[str, Printed]:
    """Every listing of a text: as one of the cells, and as the name of a column."""

    def through(call: Callable[[str], None]) -> Printed:
        def show(text: str) -> str:
            call(text)
            return capsys.readouterr().out

        return show

    def row(text: str) -> list[dict[str, Any]]:
        return [{"name": text, "value": -1.5}]

    return {
        "terminal": through(lambda text: print_table(text, (text, "value"), [(text, -1.5)])),
        "CSV": through(lambda text: print_csv(("name", "value"), row(text))),
        "CSV heading": through(lambda text: print_csv((text,), [{text: 1}])),
        "Markdown": through(lambda text: print_markdown(("name", "value"), [(text, -1.5)])),
        "JSON": through(lambda text: print_json(row(text))),
    }


@pytest.mark.parametrize("name", HIDDEN)
def test_no_hidden_character_leaves_a_listing(name: str, printed: dict[str, Printed], ledger: Page) -> None:
    plain = {where: len(show("plain").splitlines()) for where, show in printed.items()}
    for where, show in printed.items():
        lines = show(HIDDEN[name]).split("\n")
        assert not [line for line in lines if not SHOWN.fullmatch(line.removesuffix("\r"))], where
        assert "\r" not in "".join(line.removesuffix("\r") for line in lines), where
        if where != "terminal":  # which folds
            assert len("\n".join(lines).splitlines()) == plain[where], f"{where}: a row that is none"
        ledger.survived("output", f"{where}: {name}", "hidden characters 0, rows forged 0")


@pytest.fixture
def summaries(tmp_path: Path) -> Callable[[str], tuple[str, ElementTree.Element]]:
    """summary.md and junit.xml of a run whose texts are all one text."""

    def write(text: str) -> tuple[str, ElementTree.Element]:
        texts = dict.fromkeys(("study", "experiment", "case", "engine", "track", "remedy", "reason"), text)
        others = {"dt": 0.01, "status": "crashed", "parameters": "{}", "resolved": "{}", "alteration": "{}", "seed": 0}
        trials = pd.DataFrame([texts | others], dtype=object)
        store = SimpleNamespace(folder=tmp_path, trials=trials, catalogue={"cases": {}, "engines": {}})
        write_summary(cast(Store, store))
        return (tmp_path / "summary.md").read_text(encoding="utf-8"), ElementTree.parse(tmp_path / "junit.xml").getroot()

    return write


@pytest.mark.parametrize("name", [name for name in HIDDEN if name != "half a character"])  # which no table can hold
def test_no_hidden_character_leaves_the_short_answers(name: str, summaries: Any, ledger: Page) -> None:
    plain, _ = summaries("plain")
    text, junit = summaries(HIDDEN[name])
    assert all(SHOWN.fullmatch(line) for line in text.split("\n"))
    assert len(text.splitlines()) == len(plain.splitlines())
    for node in junit.iter():
        assert all(SHOWN.fullmatch(value.replace("\n", "")) for value in node.attrib.values())
    ledger.survived("output", f"summary.md and junit.xml: {name}", "hidden characters 0, rows forged 0")


@pytest.mark.parametrize("name", FORMULAS)
def test_no_spreadsheet_finds_a_formula(name: str, printed: dict[str, Printed], ledger: Page) -> None:
    for where in ("CSV", "CSV heading"):
        for delimiter in ",;\t":
            rows = list(csv.reader(io.StringIO(printed[where](FORMULAS[name]), newline=""), delimiter=delimiter))
            cells = [cell for row in rows for cell in row if not NUMBER.fullmatch(cell)]
            assert not [cell for cell in cells if FORMULA.match(cell)], f"{where}, split at {delimiter!r}"
    ledger.survived("output", f"formula: {name}", "cells that compute 0, split at comma, semicolon and tab")


@pytest.mark.parametrize("value", [-1.5, -2, -1e-300, "-1.5", "-2", "+1.5e-3", "-0", float("-inf"), 1e5])
def test_a_negative_number_stays_one(value: float | str, capsys: pytest.CaptureFixture[str], ledger: Page) -> None:
    print_csv(("value",), [{"value": value}])
    assert capsys.readouterr().out.splitlines() == ["value", str(value)]
    ledger.survived("output", f"a number taken for a formula: {type(value).__name__} {value}", "as it was")


class Elements(HTMLParser):
    """The elements of a page, in order, and the text of each cell of its tables."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.cells: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_data(self, data: str) -> None:
        if self.cells:
            self.cells[-1] += data


def read(markdown: str) -> Elements:
    """What a reader of Markdown makes of it, raw HTML let through."""
    return Elements(MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"]).render(markdown))


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "megabyte")) for name in MARKUP])
def test_a_cell_of_markdown_is_text(name: str, printed: dict[str, Printed], summaries: Any, ledger: Page) -> None:
    text = MARKUP[name]
    shown = " ".join(text[:2000].split())
    listed, (told, _) = read(printed["Markdown"](text)), summaries(text)
    summary = read(told)
    cells = [[" ".join(cell.split()).partition(" …")[0] for cell in seen.cells if cell.strip()] for seen in (listed, summary)]
    for seen in (listed, summary):
        assert {tag for tag, _ in seen.tags} <= {"table", "thead", "tbody", "tr", "th", "td", "h1"}
    assert [" ".join(cell.split()).partition(" …")[0] for cell in listed.cells if cell.strip()] == [
        "name",
        "value",
        shown,
        "-1.5",
    ]
    assert len(summary.cells) == 3 + 3 + 9 + 9
    assert cells[1].count(shown) == 2 + 5
    ledger.survived("output", f"Markdown: {name}", "elements made 0, the text as it was")


@pytest.mark.parametrize("name", TEMPLATE)
def test_what_styles_a_terminal_is_text_in_titles_headings_and_cells(
    name: str, printed: dict[str, Printed], ledger: Page
) -> None:
    assert printed["terminal"](TEMPLATE[name]).count(TEMPLATE[name]) == 3
    ledger.survived("output", f"marks of the terminal's library: {name}", "shown as they are, in 3 places of 3")


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run_folder(tmp_path_factory.mktemp("hostile") / "run", hostile=True, only=(BAD_CASE,))


FORMS = ("text", "csv")
SHOW = """
import sys
from plumbline.harness.cli.main import main
for form in sys.argv[2:]:
    main(["show", sys.argv[1], "--format", form], standalone_mode=False)
    print("that was", form)
"""


@pytest.fixture(scope="module")
def shown(hostile: Path) -> dict[str, bytes]:
    """What a terminal of ASCII shows of a hostile run, by form."""
    done = subprocess.run(
        [sys.executable, "-X", "utf8=0", "-c", SHOW, str(hostile), *FORMS],
        env={"PATH": "/usr/bin", "PYTHONIOENCODING": "ascii", "PYTHONPATH": ":".join(sys.path)},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode()[-500:]
    pieces = re.split("|".join(f"that was {form}\r?\n" for form in FORMS).encode(), done.stdout)
    assert pieces.pop() == b""
    return dict(zip(FORMS, pieces, strict=True))


@pytest.mark.parametrize("form", FORMS)
def test_a_terminal_that_knows_no_letter_beyond_ascii_shows_a_hostile_run(
    form: str, shown: dict[str, bytes], ledger: Page
) -> None:
    assert len(shown[form]) > 1000
    assert re.fullmatch(rb"[\x20-\x7e\r\n]*", shown[form])
    ledger.survived(
        "output", f"show --format {form} of hostile names on a terminal of ASCII", f"exit 0, {len(shown[form])} bytes"
    )


WRONG = {
    "a command": ("\x1b[2J\u202e",),
    "an option": ("engines", "--\x1b[2J\u202e"),
    "a study": ("run", "\x1b[2J\u202e"),
    "a study file": ("run", "\x1b[2J\u202e.toml"),
    "a case": ("run", "quick", "--case", "\x1b[2J\u202e"),
    "an engine": ("check", "\x1b[2J\u202e"),
    "a folder": ("show", "\x1b[2J\u202e"),
    "a table": ("show", ".", "--table", "\x1b[2J\u202e"),
    "a shard": ("run", "quick", "--shard", "\x1b[2J\u202e"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_asked_for_wrongly_is_named_without_acting_on_the_terminal(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "plumbline.harness.cli.guard.listen", lambda: None
    )  # it would take the signals of the test's own process
    told = CliRunner().invoke(main, WRONG[name])
    assert told.exit_code in (2, 3), told.output
    assert told.exception is None or isinstance(told.exception, SystemExit)
    assert "\\u202e" in told.output
    assert all(SHOWN.fullmatch(line) for line in told.output.split("\n"))
    ledger.survived("output", f"wrong usage: {name} with an escape sequence", f"exit {told.exit_code}, spelled out")


@pytest.mark.parametrize(
    "address",
    [
        *("javascript:window.attacked=1", "JAVASCRIPT:x", "data:text/html,x", "vbscript:x", "file:///etc/passwd"),
        *("//example.org/x", "ftp://example.org/x", "java\tscript:x", "blob:https://example.org", "ssh://example.org"),
    ],
)
def test_a_source_links_to_the_web_alone(address: str, ledger: Page) -> None:
    from plumbline.reports.html.template import cite

    links = [attributes["href"] or "" for tag, attributes in Elements(cite(f"see {address} there")).tags if tag == "a"]
    assert all(link.startswith(("http://", "https://")) for link in links)
    assert not [link for link in links if not address.startswith("blob:")]
    ledger.survived(
        "output", f"page: source {address.encode('unicode_escape').decode()}", f"links made {len(links)}, to the web"
    )


PAGES = {
    "bare": "<script>window.attacked=1</script>",
    "with a type alone": "<!doctype html><script>window.attacked=1</script>",
    "with a head": '<!DOCTYPE html>\n<html lang="en">\n<head>\n<script>window.attacked=1</script></head>',
    "with a comment first": "<!-- <head> -->\n<!doctype html><html><head><script>window.attacked=1</script>",
    "with a policy in a comment": '<!doctype html><!-- <meta http-equiv="Content-Security-Policy"> --><script></script>',
    "with a mark of byte order": "\ufeff<!doctype html><html><script>window.attacked=1</script>",
    "with a policy of its own that allows all": (
        '<!doctype html><meta http-equiv="Content-Security-Policy" content="script-src *"><script>window.attacked=1</script>'
    ),
    "with a head behind the script": "<script>window.attacked=1</script><html><head></head>",
}


@pytest.mark.parametrize("name", PAGES)
def test_a_page_of_a_third_party_has_the_policy_before_its_first_script(name: str, ledger: Page) -> None:
    from plumbline.reports.html.policy import guarded

    tags = Elements(guarded(PAGES[name])).tags
    first = next(k for k, (tag, a) in enumerate(tags) if tag == "meta" and a.get("http-equiv") == "Content-Security-Policy")
    rules = dict(rule.strip().split(" ", 1) for rule in (tags[first][1]["content"] or "").split(";"))
    assert rules["script-src"] == "'self'"
    assert rules["default-src"] == "'none'"
    assert first < next(k for k, (tag, _) in enumerate(tags) if tag == "script")
    assert {tag for tag, _ in tags[:first]} <= {"html", "head"}
    ledger.survived("output", f"page of a third party: {name}", "policy before the first script")
