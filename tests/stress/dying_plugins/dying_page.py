"""Pages that fail in a way of their own each, and one that does not."""

import os
from collections.abc import Mapping
from pathlib import Path

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


class Drawn:
    """A picture of its own kind."""

    def __init__(self, file: str | bytes) -> None:
        self._file = file

    def kept(self, _: Path) -> str | bytes:
        return self._file


INDEX = Page(name="index", title="Another index", order=1, render=lambda _: {"index.html": "stolen"})
LEAVING = Page(name="leaving", title="Leaving", order=3, render=lambda _: os._exit(0))
DRAWING = Page(
    name="drawing",
    title="Drawing",
    order=4,
    render=lambda _: [
        ("charts/drawn.svg", Drawn("drawn")),
        ("pictures/bytes.webp", Drawn(b"\xff\x00")),
        ("drawing.html", "pictures"),
    ],
)
