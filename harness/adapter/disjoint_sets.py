"""Disjoint sets: what has been united, and by which member a set is known."""

from collections.abc import Hashable
from typing import Generic, TypeVar

Member = TypeVar("Member", bound=Hashable)


class DisjointSets(Generic[Member]):
    """Sets of hashable members, each alone until it is united with another.

    Not SciPy's: its module of hierarchies takes half a second to import, and a command pays for that before it does anything.

    Source: Tarjan, Efficiency of a good but not linear set union algorithm, J. ACM 22 (1975) 215 (path halving).
    """

    def __init__(self) -> None:
        self._above: dict[Member, Member] = {}

    def root(self, member: Member) -> Member:
        """The member that stands for the set."""
        above = self._above
        while (over := above.setdefault(member, member)) != member:
            above[member] = member = above[over]
        return member

    def unite(self, a: Member, b: Member) -> bool:
        """Make one set of two; False where they are one already."""
        a, b = self.root(a), self.root(b)
        self._above[b] = a
        return a != b
