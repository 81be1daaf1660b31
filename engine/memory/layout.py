"""How a table of a world's memory is declared: of what it has a row, how wide it is; which of them grow with the pairs."""

from collections.abc import Mapping
from enum import Enum, auto
from typing import NamedTuple

import numpy as np

from plumbline.engine.maths.types import Ints


class Per(Enum):
    """Of what a table has a row."""

    WORLD = auto()
    BODY = auto()  # the last row is the world itself
    SHAPE = auto()
    JOINT = auto()
    ROW = auto()  # of the joints' constraints
    ROW_OR_TRIAL = auto()  # twice as many rows, and two
    VECTOR = auto()
    EXCLUDED = auto()
    LAW = auto()
    CLIP_POINT = auto()
    VERTEX = auto()
    FACE = auto()
    FACE_CORNER = auto()
    SIMPLEX_CORNER = auto()
    POLYGON_CORNER = auto()
    PRINCIPAL_BODY = auto()  # bodies where the integrator turns them about their principal axes, or no rows
    MOVER = auto()  # bodies in a world of spheres alone, or no rows
    MEMBER = auto()  # bodies where islands are wanted, or no rows
    SPAN = auto()
    SLEEPER = auto()  # bodies where any may sleep, or no rows
    NEAR = auto()  # pairs whose bounds overlap
    PAIR = auto()
    POINT = auto()
    OLD_POINT = auto()
    CONVEX_PAIR = auto()
    CONVEX_POINT = auto()
    TOUCH = auto()  # pairs in a world of spheres alone
    COLOURED = auto()  # pairs whose contacts are swept by colours, or no rows
    BAND = auto()  # bands of a world whose contacts are swept by colours, and one, or no rows
    BANDED_WORLD = auto()
    ANSWERING_PAIR = auto()  # pairs whose contacts are swept at once, or no rows
    COLOURED_MOVER = auto()  # bodies in such a world of spheres alone, or no rows
    RESTING_PAIR = auto()
    RESTING_POINT = auto()

    @property
    def grows(self) -> bool:
        """Whether there are twice as many rows once an arena has no room for all pairs."""
        return self in _GROWING


_GROWING = frozenset(
    {
        Per.NEAR, Per.PAIR, Per.POINT, Per.OLD_POINT, Per.CONVEX_PAIR, Per.CONVEX_POINT, Per.TOUCH,
        Per.COLOURED, Per.ANSWERING_PAIR, Per.RESTING_PAIR, Per.RESTING_POINT,
    }
)  # fmt: skip


class Table(NamedTuple):
    """A table: of what it has a row, and its columns, as many as there are rows of something where that decides."""

    rows: Per
    columns: int | Per


FLOATS: list[Table] = []
INTS: list[Table] = []
"""The tables by their numbers."""


def float_columns(rows: Per, columns: int | Per) -> int:
    """Declare a table of floats. Returns: its number."""
    FLOATS.append(Table(rows, columns))
    return len(FLOATS) - 1


def int_columns(rows: Per, columns: int | Per) -> int:
    """Declare a table of integers. Returns: its number."""
    INTS.append(Table(rows, columns))
    return len(INTS) - 1


def shapes_of(sizes: Mapping[Per, int]) -> Ints:
    """Rows and columns (k, 2) of all tables for these sizes, those of floats first."""
    return np.array([(sizes[t.rows], t.columns if isinstance(t.columns, int) else sizes[t.columns]) for t in FLOATS + INTS])
