"""A spanning forest of joints: which of them make trees, which close loops, and the bodies of a tree from its root on."""

from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Generic, TypeVar

from plumbline.harness.adapter.disjoint_sets import DisjointSets

Node = TypeVar("Node", bound=Hashable)
Edge = TypeVar("Edge")


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
