"""The pictures that other pages show: thumbnails and strips of every case, each in a file of its own."""

from collections.abc import Mapping

from plumbline.harness.store.store import Store
from plumbline.reports.page import Page, Rendered
from plumbline.reports.pictures.case_pictures import sights


def render(store: Store) -> Mapping[str, Rendered]:
    """One WebP each."""
    return {still.path: still for seen in sights(store).values() for still in seen.stills}


PAGE = Page(name="pictures", title="Pictures", order=90, render=render, listed=False)
