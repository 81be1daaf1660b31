"""The report of a run folder: every page rendered, and the assets that they share, as files that need no network."""

import os
import re
import shutil
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from harness.store import Store
from reports.figure import VEGA_LITE
from reports.page import pages

__all__ = ["write_report"]

ASSETS = ("report.css", "report.js")
FILE_NAME = re.compile(r"([A-Za-z0-9_-]+/)?[A-Za-z0-9_-]+\.(html|svg|csv|json|css|js)")


@cache
def vega_bundle() -> str:
    """Vega, Vega-Lite and the embedding, in one script without imports."""
    import vl_convert  # late: it brings a JavaScript engine

    title = "/* Vega, Vega-Lite and Vega-Embed: University of Washington Interactive Data Lab, BSD-3-Clause */\n"
    return title + str(vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;", vl_version=VEGA_LITE))


def rendered(store: Store) -> Mapping[str, str]:
    """The texts of all pages by file name.

    Raises:
        ValueError: a page names a file outside the report, of an unknown kind, or one that another page has written.
    """
    texts: dict[str, str] = {}
    for page in pages():
        if not page.concerns(store):
            continue
        for name, text in page.render(store).items():
            if not FILE_NAME.fullmatch(name):
                raise ValueError(f"page {page.name!r}: file {name!r}, expected a plain name, at most one folder deep")
            if name in texts:
                raise ValueError(f"page {page.name!r}: file {name!r} is written twice")
            texts[name] = text
    return texts


def write_report(folder: Path) -> Path:
    """Write `folder/report/` and give back its first page.

    All is rendered before the old report is touched, and the new one takes its place by renaming: a reader never meets half.
    """
    texts = dict(rendered(Store(folder)))
    report, draft, old = (Path(folder) / name for name in ("report", f".report.{os.getpid()}", f".report.{os.getpid()}.old"))
    style = Path(__file__).parent / "style"
    texts |= {f"style/{name}": (style / name).read_text(encoding="utf-8") for name in ASSETS}
    texts["style/vega.js"] = vega_bundle()
    try:
        for name, text in texts.items():
            path = draft / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", errors="backslashreplace", newline="\n")
        if report.exists():
            report.rename(old)
        draft.rename(report)
    finally:
        for leftover in (draft, old):
            shutil.rmtree(leftover, ignore_errors=True)
    return report / "index.html"
