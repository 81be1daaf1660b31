"""Which broad phase a world uses, and the compiled search of one by its name."""

from collections.abc import Callable
from importlib import import_module

from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory.status import DONE

FindPairs = Callable[[Floats, Ints], int]
DropApart = Callable[[Floats, Ints], None]

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


def load_search(broad_phase: str, volume: str, shapes: int, threads: int, coloured: bool) -> FindPairs | None:
    """The search to run before each step, or None where the step tests all pairs itself.

    Args: coloured: whether the pairs are to be sorted by colours then.
    """
    if broad_phase == "brute_force" and volume == "aabb" and shapes <= FEW and not coloured:
        return None
    name = "find_pairs" if threads == 1 else "find_pairs_parallel"
    found: FindPairs = getattr(import_module(f"plumbline.engine.broad.{broad_phase}"), name)
    return found


def load_volume(name: str) -> DropApart | None:
    """The test of the pairs that the axis-aligned boxes leave, or None where these alone decide."""
    if name == "aabb":
        return None
    tested: DropApart = import_module(f"plumbline.engine.broad.volumes.{name}").drop_apart
    return tested


def search_pairs(find_pairs: FindPairs, drop_apart: DropApart | None, floats: Floats, ints: Ints) -> int:
    """Find the pairs of the coming step. Returns: DONE, or FULL."""
    status = find_pairs(floats, ints)
    if status == DONE and drop_apart is not None:
        drop_apart(floats, ints)
    return status
