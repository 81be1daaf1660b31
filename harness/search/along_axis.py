"""The quantity that a limit is about, value by value: a bar that a constant crosses is no limit.

An axis makes a case harder. An error that has not doubled from the easy end to the extreme is what an engine does at every
value; where between them it crosses a bar says nothing of the axis.
"""

from collections.abc import Sequence
from dataclasses import dataclass

DOUBLED = 2.0
"""By what an error has to grow from the easy end to the extreme to be a matter of the axis. One of first order grows by extreme
over easy, which is six at least in the catalogue."""


@dataclass(frozen=True, slots=True)
class Point:
    """The largest headline error of the starts at one value of an axis, and the bar beyond which it is lost, in its unit."""

    value: float
    error: float
    bar: float


def unchanged(points: Sequence[Point], easy: float, extreme: float) -> bool:
    """Is the error at the extreme less than twice that at the easy end? False where one of them is unknown."""
    at = {point.value: point.error for point in points}
    return easy in at and extreme in at and at[extreme] < DOUBLED * at[easy]


def extreme_untried(points: Sequence[Point], easy: float, broke: float, extreme: float) -> bool:
    """Has the error where an engine first broke not doubled since the easy end, with the extreme still untried?"""
    return extreme not in {point.value for point in points} and unchanged(points, easy, broke)
