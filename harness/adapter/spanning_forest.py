"""Disjoint sets, and a spanning forest of joints: what makes trees, what closes loops, and a tree's bodies from its root."""

from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Generic, TypeVar

Node = TypeVar("Node", bound=Hashable)
Edge = TypeVar("Edge")


class DisjointSets(Generic[Node]):
    """Sets of hashable members, each alone until it is united with another.

    Not SciPy's: its module of hierarchies takes half a second to import, and a command pays for that before it does anything.

    Source: Tarjan, Efficiency of a good but not linear set union algorithm, J. ACM 22 (1975) 215 (path halving).
    """

    def __init__(self) -> None:
        self._above: dict[Node, Node] = {}

    def root(self, member: Node) -> Node:
        """The member that stands for the set."""
        above = self._above
        while (over := above.setdefault(member, member)) != member:
            above[member] = member = above[over]
        return member

    def unite(self, a: Node, b: Node) -> bool:
        """Make one set of two; False where they are one already."""
        a, b = self.root(a), self.root(b)
        self._above[b] = a
        return a != b


@dataclass(frozen=True, slots=True)
class Branch(Generic[Node, Edge]):
    """A node of a tree, the one above it and the edge between them."""

    node: Node
    above: Node
    edge: Edge


@dataclass(frozen=True, slots=True)
class Forest(Generic[Node, Edge]):
    """Trees. Terms: beside: of each node its neighbours, by which edge; closing: the edges that are in no tree."""

    beside: Mapping[Node, Sequence[tuple[Node, Edge]]]
    closing: tuple[Edge, ...]

    def breadth_first(self, root: Node) -> Iterator[Branch[Node, Edge]]:
        """The branches of the tree from a root on, level by level, neighbours in the order of the edges."""
        queue = deque(self._from(root, None))
        while queue:
            branch = queue.popleft()
            yield branch
            queue.extend(self._from(branch.node, branch))

    def depth_first(self, root: Node) -> Iterator[Branch[Node, Edge]]:
        """The branches of the tree from a root on, each with all that hangs on it before the next."""
        stack = self._from(root, None)[::-1]
        while stack:
            branch = stack.pop()
            yield branch
            stack += self._from(branch.node, branch)[::-1]

    def _from(self, node: Node, by: Branch[Node, Edge] | None) -> list[Branch[Node, Edge]]:
        """The branches that leave a node which was reached by one of its own."""
        return [Branch(other, node, edge) for other, edge in self.beside.get(node, ()) if by is None or other != by.above]


def spanning_forest(
    edges: Iterable[Edge], ends: Callable[[Edge], tuple[Node, Node]], ground: Sequence[Node] = ()
) -> Forest[Node, Edge]:
    """The forest of the edges in their order: one that closes a loop with those before it is in no tree.

    Args: ground: nodes that hold together without an edge, so that no tree has two of them.
    Source: Kruskal, On the shortest spanning subtree of a graph, Proc. AMS 7 (1956) 48.
    """
    sets = DisjointSets[Node]()
    for node, other in pairwise(ground):
        sets.unite(node, other)
    beside: dict[Node, list[tuple[Node, Edge]]] = {}
    closing: list[Edge] = []
    for edge in edges:
        a, b = ends(edge)
        if not sets.unite(a, b):
            closing.append(edge)
            continue
        beside.setdefault(a, []).append((b, edge))
        beside.setdefault(b, []).append((a, edge))
    return Forest(beside, tuple(closing))
