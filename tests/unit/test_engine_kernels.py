"""What kernels make of a text is what Python makes of it: tables, slices, loops, errors, and each operation rounded."""

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline.engine.compile.jit import kernel, linker
from plumbline.engine.maths.floats import fma

pytestmark = pytest.mark.compiler
linked = pytest.mark.skipif(linker() is None, reason="what Numba makes of it alone is its own")

Array = NDArray[np.float64]
njit: Any = numba.njit
NUMBERS = np.arange(12.0).reshape(4, 3)
SMALL = 2.0**-30
"""Its square is lost beside one where a product is rounded before it is added to."""


class Pair(NamedTuple):
    """Two tables."""

    one: Array
    two: Array


@kernel
def fill(table: Array, value: float) -> None:
    for i in range(table.shape[0]):
        for j in range(table.shape[1]):
            table[i, j] = value


@kernel
def total(row: Array) -> float:
    found = 0.0
    for k in range(len(row)):
        found += row[k]
    return found


@kernel
def weighed(table: Array) -> float:
    found = 1000.0 * table.shape[0] + 100.0 * table.shape[1] + table.size + 0.5 * table[-1, -2]
    for i in range(table.shape[0]):
        found += (i + 1) * total(table[i])
    return found


@kernel
def number_at(table: Array, i: int, j: int) -> float:
    return table[i, j]


@kernel
def cut(table: Array, start: int, end: int) -> Array:
    return table[start:end]


@kernel
def of_both(pair: Pair) -> float:
    return weighed(pair.one) - 2.0 * weighed(pair.two)


@kernel
def filled_copy(table: Array, value: float) -> Pair:
    made = table.copy()
    fill(made, value)
    return Pair(made, table.copy())


@kernel
def made_and_kept(n: int) -> float:
    """Room that is handed over for the last time long before it is read."""
    first = np.zeros((n, 3))
    fill(first, 2.0)
    for k in range(50):
        other = np.zeros((n, 3))
        fill(other, 7.0 + k)
    return first[n - 1, 2]


@kernel
def refused(x: float) -> float:
    if x < 0.0:
        raise ValueError("below zero")
    return x


@kernel
def refused_within(x: float) -> float:
    found = 0.0
    for k in range(3):
        found += refused(x - k)
    return found


@kernel
def counted(start: int, stop: int, step: int) -> tuple[int, int, int, int, int, int]:
    up, by_two, down, by_three, given, plain = 0, 0, 0, 0, 0, 0
    for k in range(start, stop):
        up = 10 * up + k
    for k in range(start, stop, 2):
        by_two = 10 * by_two + k
    for k in range(stop, start, -1):
        down = 10 * down + k
    for k in range(stop, start, -3):
        by_three = 10 * by_three + k
    for k in range(start, stop, step):
        given = 10 * given + k
    for k in range(stop):
        plain = 10 * plain + k
    return up, by_two, down, by_three, given, plain


@kernel
def sums(a: float, b: float, c: float) -> tuple[float, float, float, float, float, float]:
    """a b - 1 in six ways, where c is one."""
    grown, shrunk = -c, c
    grown += a * b
    shrunk -= a * b
    return a * b - c, -c + a * b, -(c - a * b), a * b + c * -c, grown, -shrunk


@kernel
def once(a: float, b: float, c: float) -> float:
    return fma(a, b, c)


number_from_python = njit(lambda table, i, j: number_at(table, i, j))
weighed_from_python = njit(lambda table: weighed(table))
cut_from_python = njit(lambda table, a, b: weighed(cut(table, a, b)))
both_from_python = njit(lambda one, two: of_both(Pair(one, two)))
copied_from_python = njit(lambda table, value: filled_copy(table, value))
fill_cut_from_python = njit(lambda table, a, b, value: fill(table[a:b], value))
counted_from_python = njit(lambda start, stop, step: counted(start, stop, step))


def plain(function: Any) -> Callable[..., Any]:
    """What was compiled, as Python."""
    found: Callable[..., Any] = function.py_func
    return found


@pytest.mark.parametrize(
    "table", [NUMBERS, NUMBERS[:, ::2], NUMBERS[::-1], NUMBERS.T.copy().T], ids=["whole", "wide", "back", "F"]
)
def test_a_kernel_reads_any_array_as_python_does(table: Array) -> None:
    expected = 1000.0 * len(table) + 100.0 * table.shape[1] + table.size + 0.5 * table[-1, -2]
    expected += (np.arange(1, len(table) + 1) * table.sum(axis=1)).sum()
    assert weighed_from_python(table) == expected
    assert both_from_python(table, NUMBERS) == expected - 2.0 * weighed_from_python(NUMBERS)


def test_every_row_and_column_is_counted_from_the_start() -> None:
    for i, j in itertools.product(range(4), range(3)):
        assert number_from_python(NUMBERS, i, j) == NUMBERS[i, j]


@pytest.mark.parametrize(("start", "end"), [*itertools.product((-9, -2, 0, 1, 3), (-1, 2, 4, 9)), (3, 3)])
def test_a_slice_holds_the_rows_that_it_holds_in_python(start: int, end: int) -> None:
    table, expected = NUMBERS.copy(), NUMBERS.copy()
    expected[start:end] = -1.0
    fill_cut_from_python(table, start, end, -1.0)
    assert np.array_equal(table, expected)
    if len(NUMBERS[start:end]):
        assert cut_from_python(NUMBERS, start, end) == weighed_from_python(NUMBERS[start:end].copy())


@linked
def test_a_slice_with_a_step_is_refused() -> None:
    @kernel
    def stepped(table: Array) -> float:
        return weighed(table[::2])

    with pytest.raises(Exception, match="sliced without a step"):
        njit(lambda table: stepped(table))(NUMBERS)


@linked
def test_a_table_of_an_array_that_a_kernel_makes_does_not_outlive_it() -> None:
    @kernel
    def outlived(n: int) -> float:
        rest = cut(np.zeros((n, 3)), 1, n)
        return weighed(rest)

    with pytest.raises(Exception, match="outlived: a table of an array that is made here may outlive it"):
        njit(lambda n: outlived(n))(3)


def test_a_copy_is_another_table_and_lives_on() -> None:
    made, kept = copied_from_python(NUMBERS, 5.0)
    assert (made == 5.0).all()
    assert np.array_equal(kept, NUMBERS)
    assert njit(lambda n: made_and_kept(n))(1000) == 2.0


def test_what_a_kernel_raises_comes_through_those_that_call_it() -> None:
    call = njit(lambda x: refused_within(x))
    assert call(5.0) == 12.0
    with pytest.raises(ValueError, match="below zero"):
        call(1.0)


@kernel
def is_above(limit: float | None, row: Array) -> bool:
    if limit is None:
        return False
    return bool(row[0] > limit)


@kernel
def count_up(row: Array) -> None:
    for i in range(row.shape[0]):
        row[i] += 1.0


@kernel
def count_twice(row: Array) -> None:
    count_up(row)
    count_up(row)


@kernel
def count_by(limit: float | None, row: Array) -> None:
    if is_above(limit, row):
        count_up(row)
    else:
        count_twice(row)


def test_a_kernel_that_a_dead_branch_calls_first_is_there_for_a_live_one() -> None:
    row = np.zeros(3)
    njit(lambda row: count_by(None, row))(row)
    assert row.tolist() == [2.0] * 3


@pytest.mark.parametrize(("start", "stop"), list(itertools.product((-2, 0, 3), (-1, 0, 1, 5))))
@pytest.mark.parametrize("step", [-2, 1, 3])
def test_loops_count_as_in_python(start: int, stop: int, step: int) -> None:
    assert counted_from_python(start, stop, step) == plain(counted)(start, stop, step)


def test_a_loop_without_a_step_is_refused() -> None:
    with pytest.raises(ValueError, match="must not be zero"):
        counted_from_python(0, 3, 0)


def test_a_product_is_rounded_before_it_is_added_to_but_where_the_text_says_so() -> None:
    """(1 + e) (1 - e) - 1 is -e^2; rounded before it is added to, the product is 1."""
    given = 1.0 + SMALL, 1.0 - SMALL, 1.0
    assert njit(lambda a, b, c: sums(a, b, c))(*given) == plain(sums)(*given) == (0.0,) * 6
    assert njit(lambda a, b, c: once(a, b, c))(1.0 + SMALL, 1.0 - SMALL, -1.0) == -(SMALL**2)
