"""The report of a run folder as one PDF, printed by a browser of this machine.

All pages of a report as one, for print: contents first, each page on a sheet of its own, links within it.

The charts of a case for a paper: the same as on its page.
"""

import os
import re
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from html.parser import HTMLParser
from pathlib import Path
from typing import ClassVar, Literal
from urllib.parse import unquote

from plumbline.harness.intake.bounded import bounded
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.store.disk import put_in_place
from plumbline.harness.store.store import Store
from plumbline.reports.charts.errors import error_by_step
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.work_precision import work_precision
from plumbline.reports.html.policy import guarded
from plumbline.reports.page import Picture, pages
from plumbline.reports.tables.price_list import scenes
from plumbline.reports.tables.trial_results import answers, in_order
from plumbline.reports.words.catalogue import cases, engines, tracks
from plumbline.reports.words.citation import citation
from plumbline.reports.words.text import slug

_VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}
_POINTING = ("id", "for", "aria-labelledby", "aria-describedby", "aria-controls")
_LEFT_OUT = {"script", "button", "form", "noscript"}


@dataclass(frozen=True, slots=True)
class Sheet:
    """A page of the report. name: its file without the ending. text: its HTML."""

    name: str
    text: str


class _Main(HTMLParser):
    """The content of a page's `main`, with addresses that hold on the joined page, and its first heading.

    Folds outside of tables are open. Scripts are left out, and so is what only works with them; an address outside of the
    report's pages stays as it is.
    """

    def __init__(self, name: str, names: frozenset[str]) -> None:
        super().__init__(convert_charrefs=False)
        self._name, self._names = name, names
        self.made: list[str] = []
        self.title = ""
        self._inside, self._skipped, self._heading, self._tables = False, 0, False, 0

    def _address(self, address: str) -> str:
        file, mark, place = address.partition("#")
        page = file.removesuffix(".html") if file.endswith(".html") else ""
        if not file and mark:
            return f"#{self._name}--{place}" if place else f"#{self._name}"
        if page not in self._names or page == "":
            return address
        return f"#{page}--{place}" if place else f"#{page}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "main":
            self._inside = True
        elif self._skipped or (self._inside and tag in _LEFT_OUT):
            self._skipped += tag not in _VOID
        elif self._inside:
            self._heading = self._heading or (tag == "h1" and not self.title)
            self._tables += tag == "table"
            if tag == "details" and not self._tables and ("open", None) not in attrs:
                attrs = [*attrs, ("open", None)]  # paper cannot be unfolded; the particulars of each trial stay in the report
            self.made.append(f"<{tag}{''.join(self._attribute(name, value) for name, value in attrs)}>")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if self._inside and not self._skipped:
            self.made.append(f"<{tag}{''.join(self._attribute(name, value) for name, value in attrs)}/>")

    def _attribute(self, name: str, value: str | None) -> str:
        if value is None:
            return f" {name}"
        if name in _POINTING:
            value = " ".join(f"{self._name}--{word}" for word in value.split())
        elif name == "href":
            value = self._address(unquote(value) if value.startswith("#") else value)
        return f' {name}="{escape(value)}"'

    def handle_endtag(self, tag: str) -> None:
        if tag == "main":
            self._inside = False
        elif self._skipped:
            self._skipped -= 1
        elif self._inside:
            self._heading = self._heading and tag != "h1"
            self._tables -= tag == "table"
            self.made.append(f"</{tag}>")

    def handle_data(self, text: str) -> None:
        self._take(text, text)

    def handle_entityref(self, name: str) -> None:
        self._take(f"&{name};", f"&{name};")

    def handle_charref(self, name: str) -> None:
        self._take(f"&#{name};", f"&#{name};")

    def _take(self, text: str, heading: str) -> None:
        if self._inside and not self._skipped:
            self.made.append(text)
            self.title += heading if self._heading else ""


def joined(sheets: Sequence[Sheet], title: str, about: Sequence[tuple[str, str]]) -> str:
    """One page of these. Args: about: names and values of the title sheet, as text."""
    names = frozenset(sheet.name for sheet in sheets)
    contents, bodies = [], []
    for sheet in sheets:
        main = _Main(sheet.name, names)
        main.feed(sheet.text)
        heading = re.sub(r"\s+", " ", main.title).strip() or escape(sheet.name)
        contents.append(f'<li><a href="#{sheet.name}">{heading}</a></li>')
        bodies.append(f'<article class="sheet" id="{sheet.name}">{"".join(main.made)}</article>')
    facts = "".join(f"<tr><th scope='row'>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in about)
    return (
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>"
        f"<title>{escape(title)}</title><link rel='stylesheet' href='style/report.css'></head><body class='printed'><main>"
        f"<article class='sheet'><h1>{escape(title)}</h1><table class='plain'>{facts}</table>"
        f"<h2>Contents</h2><ol class='contents'>{''.join(contents)}</ol></article>{''.join(bodies)}</main></body></html>"
    )


VARIABLE = "PLUMBLINE_CHROMIUM"
NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
    "chromium-headless-shell",
)
LONGEST = 600.0
"""Seconds that a browser may take."""


class NotPrinted(PlumblineError):
    """There is no PDF: no browser, or one that failed; the message says what to do."""

    lies_in: ClassVar[Literal["usage", "machine"]] = "machine"


def browser() -> str:
    """The program that prints: `$PLUMBLINE_CHROMIUM`, else a browser of the Chromium family on the path. Raises: NotPrinted."""
    if named := os.environ.get(VARIABLE):
        if path := shutil.which(named):
            return path
        raise NotPrinted(f"${VARIABLE} is {named!r}, which is no program")
    for name in NAMES:
        if path := shutil.which(name):
            return path
    raise NotPrinted(
        f"no browser that prints to PDF: install Chromium, Chrome or Edge, or set {VARIABLE} to one; "
        "any browser prints a single page of the report"
    )


def _order(report: Path) -> list[Path]:
    """The pages as the navigation has them, then the others by name: those of cases and engines."""
    places = {f"{page.name}.html": place for place, page in enumerate(pages())}
    files = [path for path in report.glob("*.html") if not path.name.startswith(".")]
    return sorted(files, key=lambda path: (places.get(path.name, len(places)), path.name))


def _is_pdf(path: Path) -> bool:
    """Does it begin and end as one does? Source: ISO 32000-1, 7.5.2 and 7.5.5: the end stands in the last kilobyte."""
    content = path.read_bytes() if path.is_file() else b""
    return content.startswith(b"%PDF-") and b"%%EOF" in content[-1024:]


def print_report(folder: Path, out: Path | None = None) -> Path:
    """Write the PDF of the pages in `folder/report/`, there as `report.pdf` unless `out` says otherwise; returns its path.

    Raises: NotPrinted, OSError.
    """
    program, store = browser(), Store(folder)
    report = (folder / "report").resolve()  # a browser takes addresses from the root alone
    out = out or folder / "report" / "report.pdf"
    sheets = [Sheet(path.stem, path.read_text(encoding="utf-8")) for path in _order(report)]
    title = f"Plumbline: {store.study.get('title') or store.study.get('name') or 'report'}"
    page, profile = report / f".print.{os.getpid()}.html", report / f".print.{os.getpid()}"
    draft = report / f".print.{os.getpid()}.pdf"
    try:
        page.write_text(guarded(joined(sheets, title, citation(store))), encoding="utf-8", errors="backslashreplace")
        command = [program, "--headless", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
        command += [f"--user-data-dir={profile}", "--no-pdf-header-footer", "--generate-pdf-document-outline"]
        # A browser of the super-user, as in containers, starts without its sandbox alone; the page runs no script.
        command += ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        ended = bounded([*command, f"--print-to-pdf={draft}", page.as_uri()], LONGEST)
        if ended.code != 0 or not _is_pdf(draft):
            raise NotPrinted(f"{program} {ended.how} and no PDF: {ended.last_words or 'no word'}")
        out.parent.mkdir(parents=True, exist_ok=True)
        put_in_place(draft, out)
    finally:
        page.unlink(missing_ok=True)
        draft.unlink(missing_ok=True)
        shutil.rmtree(profile, ignore_errors=True)
    return out


@dataclass(frozen=True, slots=True)
class Printed(Picture):
    """A chart as a file of its own. Terms: form: svg, pdf or png. width: of the frame [px, or pt in a PDF]."""

    figure: Figure
    form: str
    width: int

    def kept(self, _report: Path) -> bytes:
        """Drawn each time."""
        return self.figure.drawn(self.form, self.width)


def figures_of(store: Store, case: str) -> list[tuple[str, Figure]]:
    """Each with its kind: 'step', error against time step; 'price', cost against error, one a scene."""
    rows = answers(store, store.trials)
    sides = [(engine, track) for engine in engines(store) for track in tracks(store)]
    mine = in_order(rows[rows["case"] == case], sides)
    unit = next((str(unit) for unit in mine["unit"].dropna()), "1")
    asked = mine[mine["trial"].isin(set(store.asked["trial"]))]
    by_step = error_by_step(store, asked, f"case-{slug(case)}", cases(store)[case]["headline"], unit)
    figures = [("step", by_step)] if by_step is not None else []
    return figures + [("price", work_precision(store, scene)) for scene in scenes(store) if scene.case == case]
