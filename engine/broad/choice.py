"""Which broad phase a world uses, and the compiled search of one by its name."""

from collections.abc import Callable
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from engine.options import BROAD_PHASES

__all__ = ["FEW", "FindPairs", "choose_broad_phase", "load_broad_phase"]

FindPairs = Callable[[NDArray[np.float64], NDArray[np.int64]], int]

FEW = 24
"""Shapes up to which all pairs are tested inside the step, which is then cheaper than any search before it."""


def choose_broad_phase(wanted: str | None, shapes: int) -> str:
    """The wanted one, or the fastest for this number of shapes.

    Measured on spheres in a loose lattice, a search from scratch against the grid's: up to 100 all five within a quarter of
    each other; at 1000 the tree 1.6, octree, sorted axis and all pairs 2 times as long; at 10 000 the tree 1.9, octree 2.6,
    sorted axis 6. With sizes spread thirtyfold, 1000 of them, the sorted axis takes half as long as the grid.
    """
    if wanted is not None:
        return wanted
    return "brute_force" if shapes <= FEW else "uniform_grid"


def load_broad_phase(name: str, shapes: int) -> FindPairs | None:
    """The search to run before each step, or None where the step tests all pairs itself. Raises: ValueError for other names."""
    if name not in BROAD_PHASES:
        raise ValueError(f"broad phase '{name}', expected one of {', '.join(BROAD_PHASES)}")
    if name == "brute_force" and shapes <= FEW:
        return None
    found: FindPairs = import_module(f"engine.broad.{name}").find_pairs
    return found
