"""Islands: the connected components of bodies under contacts and joints, found by union-find.

Static and kinematic bodies end an island: what is done to them reaches no one else. The lower of two roots becomes the root of
both, so an island's root is its lowest body, and islands are numbered in the order of their lowest bodies. A body that nothing
touches is an island of its own.

Source: Tarjan, van Leeuwen, Worst-Case Analysis of Set Union Algorithms, J. ACM 31, 1984 (path halving); Catto, Iterative
Dynamics with Temporal Coherence, GDC 2005 (islands).
"""

from typing import NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import ints_of


class Links(NamedTuple):
    """Contacts, or joints: the two bodies of each, the first of them in column `first`; and their order by islands (k, 1)."""

    bodies: Ints
    order: Ints
    first: int


@kernel
def linked_by_contacts(ints: Ints) -> Links:
    """The contacts of this step."""
    key = ints_of(ints, at.MANIFOLD_KEY)[: ints_of(ints, at.COUNT)[0, at.MANIFOLDS]]
    return Links(key, ints_of(ints, at.MANIFOLD_ORDER), at.BODY_A)


@kernel
def linked_by_joints(ints: Ints) -> Links:
    """The joints."""
    return Links(ints_of(ints, at.JOINT_KIND), ints_of(ints, at.JOINT_ORDER), at.PARENT)


@kernel
def ends_of(links: Links, k: int) -> tuple[int, int]:
    """The two bodies of link k."""
    return links.bodies[k, links.first], links.bodies[k, links.first + 1]


@kernel
def root_of(island: Ints, b: int) -> int:
    """The root of body b; on the way every other body is hung one place higher."""
    while island[b, at.ROOT] != b:
        island[b, at.ROOT] = island[island[b, at.ROOT], at.ROOT]
        b = island[b, at.ROOT]
    return b


@kernel
def start_islands(island: Ints, bodies: int) -> None:
    """Every body alone."""
    for b in range(bodies):
        island[b, at.ROOT], island[b, at.NUMBER] = b, -1


@kernel
def connect(island: Ints, kind: Ints, a: int, b: int) -> None:
    """Join the islands of two bodies, if both are dynamic."""
    if kind[a, at.MOTION] == at.DYNAMIC and kind[b, at.MOTION] == at.DYNAMIC:
        one, two = root_of(island, a), root_of(island, b)
        island[max(one, two), at.ROOT] = min(one, two)


@kernel
def number_islands(island: Ints, kind: Ints, bodies: int) -> int:
    """Write the number of every dynamic body's island, -1 for the others. Returns: how many islands there are."""
    islands = 0
    for b in range(bodies):
        if kind[b, at.MOTION] != at.DYNAMIC:
            island[b, at.NUMBER] = -1
        elif root_of(island, b) == b:
            island[b, at.NUMBER] = islands
            islands += 1
        else:
            island[b, at.NUMBER] = island[root_of(island, b), at.NUMBER]
    return islands


@kernel
def begin_ranges(span: Ints, islands: int, first: int) -> None:
    """From how many of each island, in the row behind it, to where its range begins. Args: first: the column for that."""
    for i in range(islands):
        span[i + 1, first] += span[i, first]
        span[i, at.NEXT_FREE] = span[i, first]


@kernel
def put_next(order: Ints, span: Ints, i: int, what: int) -> None:
    """Put a number behind those that the range of island i has."""
    order[span[i, at.NEXT_FREE], 0] = what
    span[i, at.NEXT_FREE] += 1


@kernel
def group_bodies(island: Ints, kind: Ints, order: Ints, span: Ints, islands: int) -> None:
    """Order the touched bodies that move by islands, those of each ascending (counting sort)."""
    for i in range(islands + 1):
        span[i, at.FIRST_BODY] = 0
    for b in range(len(island)):
        if island[b, at.NUMBER] >= 0 and kind[b, at.TOUCHED] == 1:
            span[island[b, at.NUMBER] + 1, at.FIRST_BODY] += 1
    begin_ranges(span, islands, at.FIRST_BODY)
    for b in range(len(island)):
        if island[b, at.NUMBER] >= 0 and kind[b, at.TOUCHED] == 1:
            put_next(order, span, island[b, at.NUMBER], b)


@kernel
def island_of(island: Ints, links: Links, k: int, islands: int) -> int:
    """The number of the island of link k; one more than the last where neither of its bodies moves."""
    a, b = ends_of(links, k)
    i = max(island[a, at.NUMBER], island[b, at.NUMBER])
    return int(i if i >= 0 else islands)


@kernel
def group_links(island: Ints, span: Ints, islands: int, links: Links, first: int) -> None:
    """Order the links by islands, those of each ascending and those of none behind (counting sort).

    Args: first: the column of `span` where each island's range begins.
    """
    for i in range(islands + 2):
        span[i, first] = 0
    for k in range(len(links.bodies)):
        span[island_of(island, links, k, islands) + 1, first] += 1
    begin_ranges(span, islands + 1, first)
    for k in range(len(links.bodies)):
        put_next(links.order, span, island_of(island, links, k, islands), k)


@kernel
def share(span: Ints, tally: Ints, t: int) -> int:
    """Where the islands of thread t begin, so that each thread has about as many contacts and joints as the next."""
    islands, threads = tally[0, at.ISLANDS], tally[0, at.THREADS]
    links = span[islands, at.FIRST_MANIFOLD] + span[islands, at.FIRST_JOINT]
    low, high = 0, islands
    while low < high:
        middle = (low + high) // 2
        if (span[middle, at.FIRST_MANIFOLD] + span[middle, at.FIRST_JOINT]) * threads < t * links:
            low = middle + 1
        else:
            high = middle
    return islands if t == threads else (0 if t == 0 else low)
