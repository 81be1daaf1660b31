"""Tables that are worked out from a run folder's rows: one file a table, found by walking the folder.

A table is a module with

* `COLUMNS`, and `rows(store)`, its flat rows as dictionaries with those keys;
* `BRIEF`, and `brief(row)`, the cells of one row that a terminal has room for;
* where there is something to say below it, `sentences(rows)`.
"""

import pkgutil
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, cast

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store


class Table(Protocol):
    """What a module of this folder offers."""

    COLUMNS: Sequence[str]
    BRIEF: Sequence[str]

    def rows(self, store: "Store") -> list[dict[str, Any]]:
        """Flat rows with the keys COLUMNS."""

    def brief(self, row: Mapping[str, Any]) -> Sequence[object]:
        """The cells of one row under BRIEF."""


def names() -> list[str]:
    """The tables of this folder, without importing them."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__))


def table(name: str) -> Table:
    """A table by its name, one of `names()`."""
    return cast(Table, import_module(f"{__name__}.{name}"))


def sentences(of: Table, rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the table says below its rows."""
    say: Callable[[Sequence[Mapping[str, Any]]], list[str]] | None = getattr(of, "sentences", None)
    return [] if say is None else say(rows)
