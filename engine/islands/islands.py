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


class Islands(NamedTuple):
    """What is known of islands: their bodies' forest and numbers, where each begins, and the bodies of its rows of memory."""

    island: Ints
    span: Ints
    owner: Ints


class Links(NamedTuple):
    """Contacts, or joints: the two bodies of each; their order by islands (k, 1); and in it their bodies' rows.

    Terms: first: the column of the first of two bodies, and of their rows.
    """

    bodies: Ints
    order: Ints
    rows: Ints
    first: int


@kernel
def islands_of(ints: Ints) -> Islands:
    """The tables of the islands of an arena."""
    return Islands(ints_of(ints, at.ISLAND), ints_of(ints, at.SPAN_OF_ISLAND), ints_of(ints, at.LOCAL_OWNER))


@kernel
def linked_by_contacts(ints: Ints) -> Links:
    """The contacts of this step; the last step's table, which is done with, takes their rows."""
    n = ints_of(ints, at.COUNT)[0, at.MANIFOLDS]
    return Links(ints_of(ints, at.MANIFOLD_KEY)[:n], ints_of(ints, at.GROUPED), ints_of(ints, at.OLD_KEY)[:n], at.BODY_A)


@kernel
def linked_by_joints(ints: Ints) -> Links:
    """The joints."""
    return Links(ints_of(ints, at.JOINT_KIND), ints_of(ints, at.GROUPED_JOINT), ints_of(ints, at.LOCAL_JOINT_KIND), at.PARENT)


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
def island_of(island: Ints, a: int, b: int) -> int:
    """The number of the island of a contact or joint between a and b; -1 where neither is dynamic."""
    return int(max(island[a, at.NUMBER], island[b, at.NUMBER]))


@kernel
def group_bodies(island: Ints, kind: Ints, bodies: int, span: Ints, islands: int) -> None:
    """List the touched bodies of every island in MEMBER, in ascending order (counting sort)."""
    for i in range(islands + 1):
        span[i, at.FIRST_BODY] = 0
    for b in range(bodies):
        if island[b, at.NUMBER] >= 0 and kind[b, at.TOUCHED] == 1:
            span[island[b, at.NUMBER] + 1, at.FIRST_BODY] += 1
    for i in range(islands):
        span[i + 1, at.FIRST_BODY] += span[i, at.FIRST_BODY]
        span[i, at.STAMP] = span[i, at.FIRST_BODY]
    for b in range(bodies):
        if island[b, at.NUMBER] >= 0 and kind[b, at.TOUCHED] == 1:
            i = island[b, at.NUMBER]
            island[span[i, at.STAMP], at.MEMBER] = b
            span[i, at.STAMP] += 1


@kernel
def group_links(islands: Islands, n: int, links: Links, first: int) -> None:
    """List the links of each of n islands, in ascending order (counting sort).

    Args: first: the column of `span` where each island's list begins.
    """
    island, span = islands.island, islands.span
    for i in range(n + 1):
        span[i, first] = 0
    for k in range(links.bodies.shape[0]):
        a, b = ends_of(links, k)
        i = island_of(island, a, b)
        if i >= 0:
            span[i + 1, first] += 1
    for i in range(n):
        span[i + 1, first] += span[i, first]
        span[i, at.STAMP] = span[i, first]
    for k in range(links.bodies.shape[0]):
        a, b = ends_of(links, k)
        i = island_of(island, a, b)
        if i >= 0:
            links.order[span[i, at.STAMP], 0] = k
            span[i, at.STAMP] += 1


@kernel
def assign_row(islands: Islands, b: int, i: int, row: int) -> int:
    """Give body b a row of island i, unless it has one. Returns: the next free row."""
    island = islands.island
    if island[b, at.STAMP] == i:
        return row
    island[b, at.STAMP], island[b, at.LOCAL] = i, row
    islands.owner[row, 0] = b
    return row + 1


@kernel
def assign_link(islands: Islands, links: Links, rank: int, i: int, row: int) -> int:
    """Give the bodies of the link that is listed in rank `rank` of island i. Returns: the next free row."""
    k, first = links.order[rank, 0], islands.span[i, at.FIRST_LOCAL]
    for side in range(2):
        b = links.bodies[k, links.first + side]
        row = assign_row(islands, b, i, row)
        links.rows[rank, links.first + side] = islands.island[b, at.LOCAL] - first
    return row


@kernel
def assign_rows(islands: Islands, n: int, contacts: Links, joints: Links) -> None:
    """Give the bodies of each of n islands rows beside each other, its own before the fixed ones that it leans on.

    A fixed body has a row in each of its islands. The contacts and joints of the islands are written, grouped, with these rows
    in the place of their bodies.
    """
    island, span = islands.island, islands.span
    for b in range(island.shape[0]):
        island[b, at.STAMP] = -1
    row = 0
    for i in range(n):
        span[i, at.FIRST_LOCAL] = row
        for rank in range(span[i, at.FIRST_BODY], span[i + 1, at.FIRST_BODY]):
            row = assign_row(islands, island[rank, at.MEMBER], i, row)
        for rank in range(span[i, at.FIRST_MANIFOLD], span[i + 1, at.FIRST_MANIFOLD]):
            row = assign_link(islands, contacts, rank, i, row)
        for rank in range(span[i, at.FIRST_JOINT], span[i + 1, at.FIRST_JOINT]):
            row = assign_link(islands, joints, rank, i, row)
    span[n, at.FIRST_LOCAL] = row


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
