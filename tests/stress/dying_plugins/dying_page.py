"""Pages that fail in a way of their own each, and one that does not."""

from collections.abc import Mapping

from plumbline.harness.store.store import Store
from plumbline.reports.page import Page


def _raise(store: Store) -> Mapping[str, str]:
    raise LookupError("nothing to draw")


def _doubt(store: Store) -> bool:
    raise LookupError("is it there?")


RAISING = Page(name="raising", title="Raising", order=90, render=_raise)
DOUBTING = Page(name="doubting", title="Doubting", order=91, render=lambda _: {}, concerns=_doubt)
OUTWARD = Page(name="outward", title="Outward", order=92, render=lambda _: {"../outward.html": "", "index.html": "mine"})
NO_PAGE = "no page"
GOOD = Page(name="good", title="Good", order=93, render=lambda _: {"good.html": "good"})
