"""The arena's tables, carved inside compiled code: one by its number, or all that the fields of a kind are annotated with.

Nothing counts who uses them (`compile.table_type`): the arrays belong to the caller of the entry, who keeps them while it runs,
and no kernel hands a table back to Python.

Carved in place, and not in a function of its own, a table is known when the optimiser looks through all calls, which it does
once, before it puts functions in place of calls: what is the same wherever a kernel is called is then not handed to it.
"""

from collections.abc import Callable
from typing import Any, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.compile.jit import inlined, kernel, linker
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.layout import FLOATS, INTS

Kind = TypeVar("Kind")

OPEN = 0
"""In place of a number of columns that the world decides."""

FLOAT_COLUMNS = np.array([table.columns if isinstance(table.columns, int) else OPEN for table in FLOATS])
INT_COLUMNS = np.array([table.columns if isinstance(table.columns, int) else OPEN for table in INTS])
"""The columns of each table, by its number: known where compiled, so that they are not among the words handed on either."""


def _view(numbers: NDArray[Any], start: int, rows: int, columns: int) -> Any:
    """A table (rows, columns) from one of numbers in a row on, without a copy."""
    return numbers[start : start + rows * columns].reshape((rows, columns))


table_within: Any = linker().table_within if linker() else kernel(_view)


@inlined
def floats_of(floats: Floats, ints: Ints, k: int) -> Floats:
    """Table k of floats, as `arena.float_table`."""
    columns = FLOAT_COLUMNS[k] if FLOAT_COLUMNS[k] != OPEN else ints[3 * k + 2]
    table: Floats = table_within(floats, ints[3 * k], ints[3 * k + 1], columns)
    return table


@inlined
def ints_of(ints: Ints, k: int) -> Ints:
    """Table k of integers, as `arena.int_table`."""
    d = 3 * (at.FLOAT_TABLES + k)
    columns = INT_COLUMNS[k] if INT_COLUMNS[k] != OPEN else ints[d + 2]
    table: Ints = table_within(ints, ints[d], ints[d + 1], columns)
    return table


def carved(kind: type[Kind]) -> Callable[[Floats, Ints], Kind]:
    """What carves the tables of a kind from (floats, ints).

    Args: kind: a NamedTuple whose fields are Annotated[Floats or Ints, number of the table], with what carves it in between
    unless that is `floats_of` or `ints_of`; Annotated[int, column of COUNT]; or of such a kind themselves. Written out as text,
    since compiled code has no loop over tables of two types.
    """
    names: dict[str, Any] = {"_kind": kind, "_ints_of": ints_of}  # no field begins so
    parts = []
    for name, field in kind.__annotations__.items():
        of, *by, k = get_args(field) or (field, None)
        names[name] = carved(of) if k is None else by[0] if by else ints_of if of == Ints else floats_of
        words = "floats, ints" if k is None else f"ints, {k}" if of == Ints else f"floats, ints, {k}"
        parts.append(f"_ints_of(ints, {at.COUNT})[0, {k}]" if of is int else f"{name}({words})")
    exec(f"def carve(floats, ints):\n    return _kind({', '.join(parts)})", names)
    made: Callable[[Floats, Ints], Kind] = inlined(names["carve"])
    return made
