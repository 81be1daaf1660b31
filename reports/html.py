"""The report of a run folder: every page rendered, and the assets that they share, as files that need no network."""

import os
import re
import shutil
import sys
from collections.abc import Collection, Mapping
from pathlib import Path

from harness.intake.safe_text import LONGEST, one_line
from harness.store.disk import put_in_place
from harness.store.store import Store
from reports.page import Page, asked, failed, pages
from reports.policy import guarded
from reports.vega import vega_bundle

__all__ = ["write_report"]

ASSETS = ("report.css", "frame.js", "report.js", "select.js", "vega-licences.txt")
FILE_NAME = re.compile(r"([A-Za-z0-9_-]+/)?[A-Za-z0-9_-]+\.(html|svg|csv|json|css|js|webp)")


def rendered(store: Store) -> Mapping[str, str | bytes]:
    """The texts and pictures of all pages by file name; a page that fails is one that says so."""
    texts: dict[str, str | bytes] = {}
    registered = pages()
    for page in registered:
        if asked(page, store):
            try:
                texts |= _texts(page, store, {*texts, *(f"{other.name}.html" for other in registered if other is not page)})
            except Exception as error:
                print(one_line(f"page '{page.name}': {type(error).__name__}: {error}", LONGEST), file=sys.stderr)
                texts |= failed(page.name, page.title, f"{type(error).__name__}: {error}", store)
    return texts


def _texts(page: Page, store: Store, others: Collection[str]) -> Mapping[str, str] | Mapping[str, bytes]:
    """The texts of a page. Raises: ValueError, of a file outside the report, of an unknown kind, or of another page."""
    page.concerns(store)
    made = page.render(store)
    for name in made:
        if not FILE_NAME.fullmatch(name):
            raise ValueError(f"file {name!r}, expected a plain name, at most one folder deep")
        if name in others:
            raise ValueError(f"file {name!r} is another page's")
    return made


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
