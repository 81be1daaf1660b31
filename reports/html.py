"""The report of a run folder: every page rendered, and the assets that they share, as files that need no network."""

import os
import re
import shutil
import sys
from collections.abc import Collection, Iterator, Mapping
from concurrent.futures import Future
from pathlib import Path

from harness.intake.safe_text import LONGEST, one_line
from harness.store.disk import put_in_place
from harness.store.store import Store
from reports.drawing import Drawing
from reports.page import Page, Rendered, asked, failed, pages
from reports.policy import guarded
from reports.vega import vega_bundle

__all__ = ["write_report"]

ASSETS = ("report.css", "frame.js", "report.js", "select.js", "vega-licences.txt")
FILE_NAME = re.compile(r"([A-Za-z0-9_-]+/)?[A-Za-z0-9_-]+\.(html|svg|csv|json|css|js|webp)")

LARGE = 4_000_000
"""Bytes of a journal, those of a thousand trials, beyond which processes of their own draw its pictures."""
MOST = 4
"""Processes that draw: each brings a JavaScript engine."""


def rendered(store: Store) -> Mapping[str, str | bytes]:
    """The texts and pictures of all pages by file name; a page that fails is one that says so.

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
                made.append((page, _made(page, store, others, beside)))
                taken.update(made[-1][1])
        for page, files in made:
            try:
                texts |= {name: file.result() if isinstance(file, Future) else file for name, file in files.items()}
            except Exception as error:
                texts |= _instead(page, store, error)
    return texts


def _processes(store: Store) -> int:
    """How many draw the pictures of a store; its size is asked, since they start while it is read."""
    journal = store.folder / "journal.jsonl"
    large = journal.is_file() and journal.stat().st_size > LARGE
    return min(MOST, os.cpu_count() or 1) if large else 0


_Waiting = str | bytes | Future[str | bytes]


def _made(page: Page, store: Store, others: Collection[str], beside: Drawing) -> Mapping[str, _Waiting]:
    """The files of a page, pictures on their way."""
    made: dict[str, _Waiting] = {}
    try:
        for name, file in _files(page, store, others):
            made[name] = file if isinstance(file, str | bytes) else beside.ask(file)
    except Exception as error:
        return _instead(page, store, error)
    return made


def _instead(page: Page, store: Store, error: Exception) -> Mapping[str, str]:
    print(one_line(f"page '{page.name}': {type(error).__name__}: {error}", LONGEST), file=sys.stderr)
    return failed(page.name, page.title, f"{type(error).__name__}: {error}", store)


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


def write_report(folder: Path) -> Path:
    """Write `folder/report/` and give back its first page.

    All is rendered before the old report is touched, and the new one takes its place by renaming: a reader never meets half.
    """
    texts = dict(rendered(Store(folder)))
    report, draft, old = (Path(folder) / name for name in ("report", f".report.{os.getpid()}", f".report.{os.getpid()}.old"))
    style = Path(__file__).parent / "style"
    texts |= {f"style/{name}": (style / name).read_text(encoding="utf-8") for name in ASSETS}
    texts["style/vega.js"] = vega_bundle()
    texts |= {name: guarded(text) for name, text in texts.items() if isinstance(text, str) and name.endswith(".html")}
    try:
        for name, text in texts.items():
            path = draft / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8", errors="backslashreplace"))
        if report.exists():
            report.rename(old)
        put_in_place(draft, report)
    finally:
        for leftover in (draft, old):
            shutil.rmtree(leftover, ignore_errors=True)
    return report / "index.html"
