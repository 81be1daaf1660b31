"""The report of a run folder: every page rendered, and the assets that they share, as files that need no network."""

import os
import re
import shutil
from collections.abc import Collection, Iterator, Mapping
from concurrent.futures import Future
from pathlib import Path

from plumbline.harness.store.disk import put_in_place
from plumbline.harness.store.store import Store
from plumbline.harness.store.stored_tables import COLUMNS
from plumbline.reports.html.drawing import Drawing
from plumbline.reports.html.policy import STYLE, guarded
from plumbline.reports.html.template import environment, fill
from plumbline.reports.html.written import SCRIPT, NotWritten, WrittenReport, picture_file, script_file
from plumbline.reports.page import NotLoaded, Page, Rendered, asked, pages

ASSETS = ("report.css", "frame.js", "report.js", "select.js", "vega-licences.txt")
FILE_NAME = re.compile(r"([A-Za-z0-9_-]+/)?[A-Za-z0-9_-]+\.(html|svg|csv|json|css|js|webp)")

FRONT = "index.html"
NOT_MADE = '<section class="card" id="not-made">'
"""What the first page has where others could not be made."""
MAIN = '<main id="content">\n'
"""Behind which the first page names the pages that could not be made."""

LARGE = 4_000_000
"""Bytes of a journal, those of a thousand trials, beyond which more than one process draws its pictures."""
MOST = 4
"""Processes that draw: each brings a JavaScript engine."""


def rendered(store: Store) -> Mapping[str, str | bytes]:
    """The texts and pictures of all pages by file name; a page that fails is one that says so."""
    return _rendered(store, {})


def _rendered(store: Store, failures: dict[str, NotWritten]) -> Mapping[str, str | bytes]:
    """The files of all pages by name; what fails is noted in `failures`, all of which the first page names.

    Pictures are drawn beside the pages that follow. Those that no menu lists are the pages of cases: they have nearly all
    pictures, and come first.
    """
    texts: dict[str, str | bytes] = {}
    registered = sorted(pages(), key=lambda page: page.listed)
    taken: set[str] = set()
    with Drawing(store.folder / "report", _processes(store)) as beside:
        made: list[tuple[Page, Mapping[str, _Waiting]]] = []
        for page in registered:
            if asked(page, store):
                others = {*taken, *(f"{other.name}.html" for other in registered if other is not page)}
                made.append((page, _made(page, store, others, beside, failures)))
                taken.update(made[-1][1])
        for _, files in made:
            for name, file in files.items():
                ready = picture_file(name, file, failures) if isinstance(file, Future) else file
                texts |= {} if ready is None else {name: ready}
    front = texts.get(FRONT)
    if failures and isinstance(front, str):
        before, main, after = front.partition(MAIN)
        named = environment().get_template("not_made.html").render(failed=failures.values())
        texts[FRONT] = f"{before}{main}{named}{after}"
    return texts


def _processes(store: Store) -> int:
    """How many draw the pictures of a store; its size is asked, since they start while it is read."""
    journal = store.folder / "journal.jsonl"
    large = journal.is_file() and journal.stat().st_size > LARGE
    return min(MOST, os.cpu_count() or 1) if large else 1


_Waiting = str | bytes | Future[str | bytes]


def _made(
    page: Page, store: Store, others: Collection[str], beside: Drawing, failures: dict[str, NotWritten]
) -> Mapping[str, _Waiting]:
    """The files of a page, pictures on their way."""
    made: dict[str, _Waiting] = {}
    try:
        for name, file in _files(page, store, others):
            made[name] = file if isinstance(file, str | bytes) else beside.ask(file)
    except Exception as error:
        return _instead(page, store, error, failures)
    return made


def _instead(page: Page, store: Store, error: Exception, failures: dict[str, NotWritten]) -> Mapping[str, str]:
    """In the place of a page that could not be made: why, which is noted in `failures` by the name of the page."""
    reason = str(error) if isinstance(error, NotLoaded) else f"{type(error).__name__}: {error}"
    failures[page.name] = NotWritten("page", page.title, reason)
    return {f"{page.name}.html": fill("failed.html", store, title=page.title, reason=reason, here=page.name)}


def _files(page: Page, store: Store, others: Collection[str]) -> Iterator[tuple[str, Rendered]]:
    """The files of a page as they come. Raises: ValueError, of one outside the report, of unknown kind, or another page's."""
    page.concerns(store)
    made = page.render(store)
    for name, file in made.items() if isinstance(made, Mapping) else made:
        if not FILE_NAME.fullmatch(name):
            raise ValueError(f"file {name!r}, expected a plain name, at most one folder deep")
        if name in others:
            raise ValueError(f"file {name!r} is another page's")
        yield name, file


def _clear(path: Path) -> None:
    """Take a folder away with what is in it; of a link, the link alone."""
    if path.is_symlink():
        path.unlink()
    shutil.rmtree(path, ignore_errors=True)


def standing_report(store: Store) -> WrittenReport | None:
    """The report that is there, where it is whole and younger than the tables that it was made of."""
    index = store.folder / "report" / FRONT
    try:
        of_page, page = index.stat().st_mtime_ns, index.read_text(encoding="utf-8")
        of_tables = max((store.folder / f"{name}.parquet").stat().st_mtime_ns for name in COLUMNS)
    except (OSError, UnicodeDecodeError):
        return None
    return WrittenReport(index, ()) if of_page > of_tables and NOT_MADE not in page else None


def write_report(run: Path | Store) -> WrittenReport:
    """Write `report/` in a run folder, or in that of a store that has been read.

    All is rendered before the old report is touched, and the new one takes its place by renaming: a reader never meets half.
    """
    failures: dict[str, NotWritten] = {}
    store = run if isinstance(run, Store) else Store(run)
    texts = {SCRIPT: script_file(failures), **_rendered(store, failures)}
    report, draft, old = (store.folder / name for name in ("report", f".report.{os.getpid()}", f".report.{os.getpid()}.old"))
    texts |= {f"style/{name}": (STYLE / name).read_text(encoding="utf-8") for name in ASSETS}
    _clear(draft)
    try:
        for name, text in texts.items():
            path = draft / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(text, str):
                page = guarded(text) if name.endswith(".html") else text
                text = page.encode("utf-8", errors="backslashreplace")
            path.write_bytes(text)
        if report.exists():
            report.rename(old)
        put_in_place(draft, report)
    finally:
        for leftover in (draft, old):
            _clear(leftover)
    return WrittenReport(report / FRONT, tuple(failures.values()))
