"""The rows of a table as mappings: what reports take out of tables by the ten thousand."""

from collections.abc import Callable, Hashable, Iterable
from typing import Any, TypeVar

import pandas as pd
from pandas.api.extensions import ExtensionDtype

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
