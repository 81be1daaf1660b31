"""The pictures that other pages show: thumbnails and strips of every case, each in a file of its own."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from reports.page import Page
from reports.sights import sights

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["PAGE"]


def render(store: "Store") -> Mapping[str, bytes]:
    """One WebP each, taken over from the last report where it is the same."""
    return {still.path: still.kept(store.folder / "report") for seen in sights(store).values() for still in seen.stills}


PAGE = Page(name="pictures", title="Pictures", order=90, render=render, listed=False)
