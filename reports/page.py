"""The page protocol: a page turns a store into files, and is found by walking `reports/pages`."""

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import entry_points
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from harness.store import Store

__all__ = ["Page", "navigation", "pages"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """One kind of page.

    Terms:
        name: unique; its main file is `<name>.html`. title: in the navigation. order: place there, smallest first.
        render: the store to texts by file name relative to the report's folder: the page itself, and whatever it links to.
        listed: does it stand in the navigation? concerns: has it anything to say of this store? Without, it is left out.
    """

    name: str
    title: str
    order: int
    render: Callable[["Store"], Mapping[str, str]]
    listed: bool = True
    concerns: Callable[["Store"], bool] = lambda _: True


def pages() -> tuple[Page, ...]:
    """All pages, in order: each module in `reports/pages` ends in `PAGE`; others come by entry point `plumbline.pages`.

    Raises:
        ImportError, AttributeError: a page that cannot be loaded is an error, never left out.
        ValueError: two pages of one name.
    """
    import reports.pages as package

    found: list[Page] = [
        importlib.import_module(f"reports.pages.{module.name}").PAGE for module in pkgutil.iter_modules(package.__path__)
    ]
    found += [entry.load() for entry in entry_points(group="plumbline.pages")]
    names = [page.name for page in found]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"pages: name {twice[0]!r} is taken twice, expected each name once")
    return tuple(sorted(found, key=lambda page: (page.order, page.name)))


@lru_cache(maxsize=1)
def navigation(store: "Store") -> tuple[Page, ...]:
    """The pages that stand in the navigation of a report; asked once for a report, since every page of it shows them."""
    return tuple(page for page in pages() if page.listed and page.concerns(store))
