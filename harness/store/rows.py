"""The rows of a table as mappings: what reports take out of tables by the ten thousand."""

from collections.abc import Callable, Hashable, Iterable
from functools import wraps
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar

import pandas as pd
from pandas.api.extensions import ExtensionDtype

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store

Item = TypeVar("Item")
Key = TypeVar("Key", bound=Hashable)


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    """What has one key in one list; keys, and what has them, in the order in which they come."""
    groups: dict[Key, list[Item]] = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    return groups


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Each row by the names of its columns, in Python's own numbers, None where a yes or no is not known.

    As `DataFrame.to_dict` has them, which asks each cell what it is and not each column.
    """
    names = [str(name) for name in frame.columns]
    return [
        dict(zip(names, row, strict=True)) for row in zip(*map(_cells, (frame[name] for name in frame.columns)), strict=True)
    ]


def _cells(column: "pd.Series[Any]") -> list[Any]:
    cells = column.tolist()
    return [None if cell is pd.NA else cell for cell in cells] if isinstance(column.dtype, ExtensionDtype) else cells


T = TypeVar("T")
P = ParamSpec("P")


def once(read: Callable[Concatenate["Store", P], T]) -> Callable[Concatenate["Store", P], T]:
    """A function of a store, and of what else tells its answers apart, that works each out once.

    Answers live as long as their store: two stores that are compared do not drive out each other's, and a store that nobody
    holds any more takes its own along.
    """

    @wraps(read)
    def kept(store: "Store", /, *question: P.args, **named: P.kwargs) -> T:
        answers: dict[Any, T] = vars(store).setdefault("_worked_out", {})
        key = read, question, *named.items()
        if key not in answers:
            answers[key] = read(store, *question, **named)
        return answers[key]

    return kept


def all_once(read: Callable[["Store"], Iterable[T]]) -> Callable[["Store"], tuple[T, ...]]:
    """The same of a function that yields what it finds, as a tuple."""
    return once(wraps(read)(lambda store: tuple(read(store))))
