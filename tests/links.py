"""The pages of a report with no picture drawn, and where their links lead: every address resolved, without a browser."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from html import unescape
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from plumbline.harness.store.store import Store
from plumbline.reports.html.report import ASSETS
from plumbline.reports.page import Rendered, asked, pages

__all__ = ["anchors", "dangling", "files_of", "texts_of", "without_word_links"]

OUTSIDE = ("http", "https", "data")
"""What leads out of a report, or nowhere."""


TAG = re.compile(
    r"""<!--.*?-->|<(script|style)\b(?P<raw>(?:[^>"']+|"[^"]*"|'[^']*')*)>.*?</\1\s*>"""
    r"""|<[a-z][^\s/>]*(?P<plain>(?:[^>"']+|"[^"]*"|'[^']*')*)>""",
    re.DOTALL | re.IGNORECASE,
)
"""A comment, an element whose content is no markup, or the beginning of another one. Pages have many: a parser takes longer to
read them than it takes to make them."""
HELD = re.compile(r"""([^\s=>"'/]+)\s*=\s*(?:"([^"]*)"|'([^']*)'|([^\s>]+))""")
"""An attribute and its value."""
LEADING = ("href", "src")


@dataclass(frozen=True)
class _Read:
    """What a page names and where it leads."""

    named: frozenset[str]
    links: frozenset[str]


def _read(page: str) -> _Read:
    held = [
        (name.lower(), unescape(double or single or bare))
        for tag in TAG.finditer(page)
        for name, double, single, bare in HELD.findall(tag["raw"] or tag["plain"] or "")
    ]
    named = frozenset(value for name, value in held if name == "id" and value)
    return _Read(named, frozenset(value for name, value in held if name in LEADING and value))


def anchors(page: str) -> frozenset[str]:
    """The names that a link into a page may end in."""
    return _read(page).named


def files_of(folder: Path) -> dict[str, Rendered]:
    """The files of the report of a run folder by name, pictures not yet drawn. Raises: what a page raises."""
    return {f"style/{name}": "" for name in (*ASSETS, "vega.js")} | texts_of(Store(folder))


def texts_of(store: Store, *names: str) -> dict[str, Any]:
    """The files of the pages of a report by name, pictures not yet drawn; of these pages alone, where some are named.

    Raises: what a page raises.
    """
    files: dict[str, Any] = {}
    for page in pages():
        if page.name in (names or (page.name,)) and asked(page, store):
            files |= page.render(store)
    return files


def without_word_links(page: str) -> str:
    """A page whose house words are plain again, for sentences to be found in."""
    return re.sub(r'<a class="word"[^>]*>([^<]*)</a>', r"\1", page)


def dangling(folder: Path, files: Mapping[str, Rendered] | None = None) -> list[str]:
    """The links of all pages of a run's report whose file or whose place in it is not there: 'page.html: where it leads'.

    Args: files: those of the report, where they are made already.
    """
    files = files_of(folder) if files is None else files
    read = {name: _read(page) for name, page in files.items() if name.endswith(".html") and isinstance(page, str)}
    wrong = []
    for name, page in read.items():
        for link in sorted(page.links):
            address = urlsplit(link)
            target = unquote(address.path) or name
            place = unquote(address.fragment)
            if address.scheme in OUTSIDE:
                continue
            kept = target in files or (target.startswith("../") and (folder / target.removeprefix("../")).is_file())
            if address.scheme or not kept or (place and place not in read[target].named):
                wrong.append(f"{name}: {link}")
    return wrong
