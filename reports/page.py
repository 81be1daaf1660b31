"""The page protocol: a page turns a store into files, and is found by walking `reports/pages`."""

import importlib
import pkgutil
import re
from base64 import b64decode, b64encode
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import EntryPoint
from itertools import chain, count
from pathlib import Path
from typing import Protocol

from plumbline.harness.intake.apart import NoAnswer, apart
from plumbline.harness.intake.strangers import facts, points, trouble
from plumbline.harness.store.store import Store

LAST = 1000
"""The place in the navigation of a page that cannot be loaded."""


class Picture(Protocol):
    """A picture that is still to be drawn: a chart or a scene, which takes longer than the page that shows it."""

    def standing(self, _report: Path) -> str | bytes | None:
        """Its file in an earlier report of the folder, where that is whole and shows the same."""
        return None

    def kept(self, report: Path) -> str | bytes:
        """Its file: the standing one where there is one, else drawn now."""


PATIENCE = 60.0
"""Seconds that a third party's page may take, as a trial of a study."""
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
        ValueError: two pages of ours have one name; a third party's that takes a name says so in its place.
    """
    folder = str(Path(__file__).with_name("pages"))
    loaded: list[Page] = [
        importlib.import_module(f"plumbline.reports.pages.{module.name}").PAGE for module in pkgutil.iter_modules([folder])
    ]
    names = [page.name for page in loaded]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"pages: name {twice[0]!r} is taken twice, expected each name once")
    for point in points("plumbline.pages").values():
        loaded.append(_outside(point, {page.name for page in loaded}))
    return tuple(sorted(loaded, key=lambda page: (page.order, page.name)))


PLAIN = re.compile(r"[A-Za-z0-9_-]{1,40}")


class NotLoaded(Exception):
    """A third party's page cannot be loaded or made; the message says why."""


def _outside(point: EntryPoint, taken: Collection[str]) -> Page:
    """A third party's page, made in a process of its own, or one in its place that fails and says why."""
    reason, about = trouble(point), facts(point)
    if not reason and not PLAIN.fullmatch(about.name):
        reason = f"{point.value}: got {about.name!r:.100}, expected a Page with a plain name"
    if not reason and about.name in taken:
        reason = f"{point.value}: the name '{about.name}' is taken by another page; choose another"
    if reason:

        def fail(_: Store) -> Mapping[str, Rendered]:
            raise NotLoaded(reason)

        plain = re.sub(r"[^A-Za-z0-9_-]", "-", point.name)[:40]
        free = next(name for name in chain([plain], (f"{plain}-{number}" for number in count(2))) if name not in taken)
        return Page(name=free, title=point.name, order=LAST, render=fail)

    @lru_cache(maxsize=1)
    def made(folder: Path) -> dict[str, tuple[bool, str]] | NotLoaded | None:
        try:
            form = dict[str, tuple[bool, str]]
            return apart(form, PATIENCE, stranger_files, point.name, point.value, point.group, folder) or None
        except NoAnswer as error:
            return NotLoaded(str(error))

    def concerns(store: Store) -> bool:
        return made(store.folder) is not None

    def render(store: Store) -> Mapping[str, Rendered]:
        files = made(store.folder)
        if isinstance(files, NotLoaded):
            raise files
        return {path: b64decode(text) if binary else text for path, (binary, text) in (files or {}).items()}

    return Page(name=about.name, title=about.title, order=about.order, listed=about.listed, render=render, concerns=concerns)


def stranger_files(name: str, value: str, group: str, folder: Path) -> dict[str, tuple[bool, str]]:
    """The files of a third party's page by name, in the process that is given up to it; none where it has nothing to say.

    Returns: text, and with True the base 64 of bytes; pictures are drawn. Raises: TypeError, of what is no page.
    """
    page, store = EntryPoint(name, value, group).load(), Store(folder)
    if not isinstance(page, Page):
        raise TypeError(f"got {page!r:.100}, expected a Page with a plain name")
    if not page.concerns(store):
        return {}
    rendered = page.render(store)
    files: dict[str, tuple[bool, str]] = {}
    for path, file in rendered.items() if isinstance(rendered, Mapping) else rendered:
        content = file if isinstance(file, str | bytes) else file.kept(folder / "report")
        files[path] = (False, content) if isinstance(content, str) else (True, b64encode(content).decode())
    return files


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
