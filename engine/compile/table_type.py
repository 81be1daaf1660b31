"""What a table of numbers is to compiled code: where it lies, how many rows and columns it has, and nothing else.

An array is nine words to Numba, which hands them all on in every call and takes them apart for every number that is read: most
of what it wrote for a step. A table is three. Kernels take tables wherever they are given arrays, which whoever calls them
keeps: so no kernel may return a table of an array that its caller makes for the call alone.
"""

import operator
from collections.abc import Sequence
from functools import cache
from typing import Any

import llvmlite.ir
import numba
import numpy as np
from numba import extending

types: Any = numba.types
extend: Any = extending
llvm: Any = llvmlite.ir


class Table(types.Type):
    """A table of numbers in rows, or one row of them. Args: dtype: of a number; ndim: 1 or 2."""

    def __init__(self, dtype: Any, ndim: int) -> None:
        self.dtype, self.ndim = dtype, ndim
        super().__init__(name=f"{dtype}s{ndim}")


@extend.register_model(Table)
class TableModel(extend.models.StructModel):
    """Where the first number lies, and the lengths."""

    def __init__(self, manager: Any, kind: Table) -> None:
        super().__init__(
            manager, kind, [("data", types.CPointer(kind.dtype)), ("shape", types.UniTuple(types.intp, kind.ndim))]
        )


@cache
def as_given(kinds: tuple[Any, ...]) -> tuple[Any, ...]:
    """The types by which kernels know arguments: tables for arrays, within tuples too, and numbers for constants."""
    return tuple(_as_table(types.unliteral(one)) for one in kinds)


def _as_table(kind: Any) -> Any:
    if isinstance(kind, types.Array):
        return Table(kind.dtype, kind.ndim) if kind.layout == "C" and kind.ndim < 3 else kind
    if isinstance(kind, types.BaseTuple):
        members = tuple(_as_table(one) for one in kind.types)
        if members != tuple(kind.types):
            return types.BaseTuple.from_types(members, getattr(kind, "instance_class", None))
    return kind


def _is_place(kind: Table, index: Any) -> bool:
    """Whether an index names one number."""
    if isinstance(index, types.Integer):
        return kind.ndim == 1
    return (
        isinstance(index, types.BaseTuple) and len(index) == kind.ndim and all(isinstance(one, types.Integer) for one in index)
    )


@extend.type_callable(operator.getitem)
def _type_of_item(_: Any) -> Any:
    def typed(kind: Any, index: Any) -> Any:
        if not isinstance(kind, Table):
            return None
        if _is_place(kind, index):
            return kind.dtype
        if isinstance(index, types.SliceType):
            return kind
        return Table(kind.dtype, 1) if isinstance(index, types.Integer) else None

    return typed


@extend.type_callable(operator.setitem)
def _type_of_store(_: Any) -> Any:
    def typed(kind: Any, index: Any, value: Any) -> Any:  # noqa: ARG001
        known = isinstance(kind, Table) and _is_place(kind, index)
        return types.none(kind, index, kind.dtype) if known else None

    return typed


@extend.type_callable(len)
def _type_of_length(_: Any) -> Any:
    return lambda kind: types.intp if isinstance(kind, Table) else None


extend.make_attribute_wrapper(Table, "shape", "shape")


@extend.overload_attribute(Table, "size")
def _size(table: Any) -> Any:
    def of_row(table: Any) -> Any:
        return table.shape[0]

    def of_rows(table: Any) -> Any:
        return table.shape[0] * table.shape[1]

    return of_row if table.ndim == 1 else of_rows


def _parts(builder: Any, kind: Table, value: Any) -> tuple[Any, list[Any]]:
    """Where a table lies, and its lengths."""
    shape = builder.extract_value(value, 1)
    return builder.extract_value(value, 0), [builder.extract_value(shape, k) for k in range(kind.ndim)]


def _table(context: Any, builder: Any, kind: Table, data: Any, lengths: Sequence[Any]) -> Any:
    """A table from where it lies and its lengths."""
    value = builder.insert_value(llvm.Constant(context.get_value_type(kind), llvm.Undefined), data, 0)
    for k, length in enumerate(lengths):
        value = builder.insert_value(value, length, (1, k))
    return value


def _from_start(context: Any, builder: Any, kind: Any, index: Any, length: Any) -> Any:
    """An index from the start; of those below zero only constants count from the end, and no other may be below zero."""
    number = context.cast(builder, index, kind, types.intp)
    if isinstance(kind, types.IntegerLiteral):
        return number if kind.literal_value >= 0 else builder.add(number, length)
    return number


def _address(context: Any, builder: Any, kind: Table, value: Any, index_kind: Any, index: Any) -> Any:
    """Where a number lies."""
    data, lengths = _parts(builder, kind, value)
    several = isinstance(index_kind, types.BaseTuple)
    kinds = tuple(index_kind) if several else (index_kind,)
    given = [builder.extract_value(index, k) for k in range(kind.ndim)] if several else [index]
    place = [_from_start(context, builder, *one) for one in zip(kinds, given, lengths, strict=True)]
    at = place[0] if kind.ndim == 1 else builder.add(builder.mul(place[0], lengths[1]), place[1])
    return builder.gep(data, [at], inbounds=True)


@extend.lower_builtin(operator.getitem, Table, types.Any)
def get_item(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """A number, a row or a run of rows."""
    kind, index = sig.args
    if _is_place(kind, index):
        return context.unpack_value(builder, kind.dtype, _address(context, builder, kind, args[0], index, args[1]))
    data, lengths = _parts(builder, kind, args[0])
    if isinstance(index, types.Integer):
        row = _from_start(context, builder, index, args[1], lengths[0])
        return _table(context, builder, sig.return_type, builder.gep(data, [builder.mul(row, lengths[1])]), lengths[1:])
    from numba.cpython import slicing

    part, slices = context.make_helper(builder, index, args[1]), slicing
    _guard_slice(slices, context, builder, index, part)
    slices.fix_slice(builder, part, lengths[0])
    start = builder.mul(part.start, lengths[1]) if kind.ndim == 2 else part.start
    count = slices.get_slice_length(builder, part)
    return _table(context, builder, kind, builder.gep(data, [start]), [count, *lengths[1:]])


def _guard_slice(slices: Any, context: Any, builder: Any, kind: Any, part: Any) -> None:
    """Refuse a slice that leaves rows out: a table has all rows from its first to its last."""
    if kind.has_step:
        raise TypeError("a table is sliced without a step")
    slices.guard_invalid_slice(context, builder, kind, part)


@extend.lower_builtin(operator.setitem, Table, types.Any, types.Any)
def set_item(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Put a number in its place."""
    kind, index = sig.args[:2]
    context.pack_value(builder, kind.dtype, args[2], _address(context, builder, kind, args[0], index, args[1]))
    return context.get_dummy_value()


@extend.lower_builtin(len, Table)
def _length(_context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _parts(builder, sig.args[0], args[0])[1][0]


@extend.overload_method(Table, "copy")
def _copy(table: Any) -> Any:
    number = table.dtype

    def copy_row(table: Any) -> Any:
        made = np.empty(table.shape[0], number)
        for k in range(table.shape[0]):
            made[k] = table[k]
        return made

    def copy_rows(table: Any) -> Any:
        made = np.empty(table.shape, number)
        for i in range(table.shape[0]):
            for j in range(table.shape[1]):
                made[i, j] = table[i, j]
        return made

    return copy_row if table.ndim == 1 else copy_rows


@extend.intrinsic
def table_within(_: Any, numbers: Any, _start: Any, _rows: Any, _columns: Any) -> Any:
    """The table that starts at one of numbers in a row: (numbers, start, rows, columns)."""
    source, kind = Table(numbers.dtype, 1), Table(numbers.dtype, 2)

    def code(context: Any, builder: Any, _: Any, values: Any) -> Any:
        data = builder.extract_value(values[0], 0)
        return _table(context, builder, kind, builder.gep(data, [values[1]], inbounds=True), values[2:])

    return kind(source, types.intp, types.intp, types.intp), code


@extend.lower_cast(types.Array, Table)
def _array_to_table(context: Any, builder: Any, source: Any, kind: Any, value: Any) -> Any:
    array = context.make_array(source)(context, builder, value)
    return _table(context, builder, kind, array.data, [builder.extract_value(array.shape, k) for k in range(kind.ndim)])


@extend.lower_cast(Table, types.Array)
def _table_to_array(context: Any, builder: Any, source: Any, kind: Any, value: Any) -> Any:
    """For code that knows arrays alone: one that nothing counts the users of."""
    from numba.np.arrayobj import populate_array

    data, lengths = _parts(builder, source, value)
    array = context.make_array(kind)(context, builder)
    size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    strides = [size] if kind.ndim == 1 else [builder.mul(size, lengths[1]), size]
    populate_array(array, data=data, shape=lengths, strides=strides, itemsize=size, meminfo=None)
    return array._getvalue()


@extend.lower_cast(types.BaseNamedTuple, types.BaseNamedTuple)
def _named_to_named(context: Any, builder: Any, source: Any, kind: Any, value: Any) -> Any:
    members = [context.cast(builder, builder.extract_value(value, k), source[k], kind[k]) for k in range(len(source))]
    return context.make_tuple(builder, kind, members)
