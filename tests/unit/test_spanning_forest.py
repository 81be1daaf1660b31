"""Disjoint sets and spanning forests: what several adapters make of the joints of a scene."""

from hypothesis import given
from hypothesis import strategies as st

from plumbline.harness.adapter.spanning_forest import Branch, DisjointSets, spanning_forest

NODES = 8
EDGES = st.lists(st.tuples(st.integers(0, NODES - 1), st.integers(0, NODES - 1)), max_size=14)


def reachable(pairs: list[tuple[int, int]], start: int) -> set[int]:
    """All that pairs lead to from a node, by walking until nothing new comes."""
    reached = {start}
    while new := {b for pair in pairs for a, b in (pair, pair[::-1]) if a in reached} - reached:
        reached |= new
    return reached


@given(EDGES)
def test_members_have_one_root_just_where_a_chain_of_unions_links_them(pairs: list[tuple[int, int]]) -> None:
    sets = DisjointSets[int]()
    for done, (a, b) in enumerate(pairs):
        assert sets.unite(a, b) == (b not in reachable(pairs[:done], a))
    for a in range(NODES):
        assert {b for b in range(NODES) if sets.root(b) == sets.root(a)} == reachable(pairs, a)


@given(EDGES)
def test_trees_reach_what_the_edges_reach_and_each_left_out_closes_a_loop(pairs: list[tuple[int, int]]) -> None:
    forest = spanning_forest(range(len(pairs)), lambda k: pairs[k])
    kept = [pairs[k] for k in range(len(pairs)) if k not in forest.closing]
    for k in forest.closing:
        assert pairs[k][1] in reachable([pairs[j] for j in range(k) if j not in forest.closing], pairs[k][0])
    for root in range(NODES):
        for walk in (forest.breadth_first(root), forest.depth_first(root)):
            branches = list(walk)
            # A tree has one branch for each node but its root, and none is walked before the node above it.
            assert {root, *(branch.node for branch in branches)} == reachable(kept, root) == reachable(pairs, root)
            assert len(branches) == len(reachable(pairs, root)) - 1
            walked = {root}
            for branch in branches:
                assert branch.above in walked
                assert {branch.above, branch.node} == set(pairs[branch.edge])
                walked.add(branch.node)


def test_no_tree_has_two_nodes_of_the_ground() -> None:
    ends = {"left": ("wall", "a"), "link": ("a", "b"), "right": ("floor", "b")}
    forest = spanning_forest(ends, ends.__getitem__, ground=("wall", "floor"))
    assert forest.closing == ("right",)
    assert list(forest.breadth_first("floor")) == []


def test_breadth_first_goes_level_by_level_and_depth_first_branch_by_branch() -> None:
    pairs = [(0, 1), (0, 2), (1, 3), (2, 4)]
    forest = spanning_forest(pairs, lambda pair: pair)
    assert [branch.node for branch in forest.breadth_first(0)] == [1, 2, 3, 4]
    assert [branch.node for branch in forest.depth_first(0)] == [1, 3, 2, 4]
    assert next(forest.breadth_first(3)) == Branch(1, 3, (1, 3))
