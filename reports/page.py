"""The page protocol: a page turns a store into files, and is found by walking `reports/pages`."""

import importlib
import pkgutil
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Protocol

from plumbline.harness.intake.strangers import points, trouble
from plumbline.harness.store.store import Store

LAST = 1000
"""The place in the navigation of a page that cannot be loaded."""


class Picture(Protocol):
    """A picture that is still to be drawn: a chart or a scene, which takes longer than the page that shows it."""

    def kept(self, report: Path) -> str | bytes:
        """Its file: the one of an earlier report of the folder where that shows the same, else drawn now."""


Rendered = str | bytes | Picture
"""What a file of a page holds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """One kind of page.

    Terms:
        name: unique; its main file is `<name>.html`. title: in the navigation. order: place there, smallest first.
        render: the store to texts by file name relative to the report's folder, the page itself and whatever it links to;
        to bytes where these are pictures, and to a `Picture` where one is drawn while the next pages are made. Files may be
        handed on as they come, as pairs of name and file: pictures that come early are drawn while the page is still made.
        listed: does it stand in the navigation? concerns: has it anything to say of this store? Without, it is left out.
    """

    name: str
    title: str
    order: int
    render: Callable[[Store], Mapping[str, Rendered] | Iterable[tuple[str, Rendered]]]
    listed: bool = True
    concerns: Callable[[Store], bool] = lambda _: True


def pages() -> tuple[Page, ...]:
    """All pages, in order: each module in `reports/pages` ends in `PAGE`; others come by entry point `plumbline.pages`.

    Raises:
        ImportError, AttributeError: a page of ours that cannot be loaded is an error; a third party's says so in its place.
        ValueError: two pages of one name.
    """
    folder = str(Path(__file__).with_name("pages"))
    loaded: list[Page] = [
        importlib.import_module(f"plumbline.reports.pages.{module.name}").PAGE for module in pkgutil.iter_modules([folder])
    ]
    loaded += [_outside(name) for name in points("plumbline.pages")]
    names = [page.name for page in loaded]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"pages: name {twice[0]!r} is taken twice, expected each name once")
    return tuple(sorted(loaded, key=lambda page: (page.order, page.name)))


PLAIN = re.compile(r"[A-Za-z0-9_-]{1,40}")


class NotLoaded(Exception):
    """A third party's page cannot be loaded; the message says why."""


def _outside(name: str) -> Page:
    """A third party's page, or one in its place that fails and says why."""
    point = points("plumbline.pages")[name]
    reason = trouble(point)
    if not reason:
        page = point.load()
        if isinstance(page, Page) and PLAIN.fullmatch(page.name):
            return page
        reason = f"{point.value}: got {page!r:.100}, expected a Page with a plain name"

    def fail(_: Store) -> Mapping[str, Rendered]:
        raise NotLoaded(reason)

    return Page(name=re.sub(r"[^A-Za-z0-9_-]", "-", name)[:40], title=name, order=LAST, render=fail)


def asked(page: Page, store: Store) -> bool:
    """Does a page belong to the report of this store? One that fails at that question says so in its place."""
    try:
        return page.concerns(store)
    except Exception:
        return True


@lru_cache(maxsize=1)
def navigation(store: Store) -> tuple[Page, ...]:
    """The pages that stand in the navigation of a report; asked once for a report, since every page of it shows them."""
    return tuple(page for page in pages() if page.listed and asked(page, store))
