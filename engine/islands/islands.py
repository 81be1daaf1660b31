"""Islands: the connected components of bodies under contacts and joints, found by union-find.

Static and kinematic bodies end an island: what is done to them reaches no one else. The lower of two roots becomes the root of
both, so an island's root is its lowest body, and islands are numbered in the order of their lowest bodies. A body that nothing
touches is an island of its own.

Source: Tarjan, van Leeuwen, Worst-Case Analysis of Set Union Algorithms, J. ACM 31, 1984 (path halving); Catto, Iterative
Dynamics with Temporal Coherence, GDC 2005 (islands).
"""

from engine.compile.jit import entry, kernel
from engine.maths.vec import Ints
from engine.memory.arena import (
    BODY_A,
    BODY_B,
    CHILD,
    DYNAMIC,
    FIRST_BODY,
    FIRST_JOINT,
    FIRST_LOCAL,
    FIRST_MANIFOLD,
    ISLANDS,
    LOCAL,
    MEMBER,
    MOTION,
    NUMBER,
    PARENT,
    ROOT,
    STAMP,
    THREADS,
    TOUCHED,
)  # fmt: skip

__all__ = [
    "assign_rows",
    "connect",
    "connected_components",
    "group_bodies",
    "group_links",
    "number_islands",
    "share",
    "start_islands",
]


@kernel
def root_of(island: Ints, b: int) -> int:
    """The root of body b; on the way every other body is hung one place higher."""
    while island[b, ROOT] != b:
        island[b, ROOT] = island[island[b, ROOT], ROOT]
        b = island[b, ROOT]
    return b


@kernel
def start_islands(island: Ints, bodies: int) -> None:
    """Every body alone."""
    for b in range(bodies):
        island[b, ROOT], island[b, NUMBER] = b, -1


@kernel
def connect(island: Ints, kind: Ints, a: int, b: int) -> None:
    """Join the islands of two bodies, if both are dynamic."""
    if kind[a, MOTION] == DYNAMIC and kind[b, MOTION] == DYNAMIC:
        one, two = root_of(island, a), root_of(island, b)
        island[max(one, two), ROOT] = min(one, two)


@kernel
def number_islands(island: Ints, kind: Ints, bodies: int) -> int:
    """Write the number of every dynamic body's island, -1 for the others. Returns: how many islands there are."""
    islands = 0
    for b in range(bodies):
        if kind[b, MOTION] != DYNAMIC:
            island[b, NUMBER] = -1
        elif root_of(island, b) == b:
            island[b, NUMBER] = islands
            islands += 1
        else:
            island[b, NUMBER] = island[root_of(island, b), NUMBER]
    return islands


@kernel
def island_of(island: Ints, a: int, b: int) -> int:
    """The number of the island of a contact or joint between a and b; -1 where neither is dynamic."""
    return int(max(island[a, NUMBER], island[b, NUMBER]))


@kernel
def group_bodies(island: Ints, kind: Ints, bodies: int, span: Ints, islands: int) -> None:
    """List the touched bodies of every island in MEMBER, in ascending order (counting sort)."""
    for i in range(islands + 1):
        span[i, FIRST_BODY] = 0
    for b in range(bodies):
        if island[b, NUMBER] >= 0 and kind[b, TOUCHED] == 1:
            span[island[b, NUMBER] + 1, FIRST_BODY] += 1
    for i in range(islands):
        span[i + 1, FIRST_BODY] += span[i, FIRST_BODY]
        span[i, STAMP] = span[i, FIRST_BODY]
    for b in range(bodies):
        if island[b, NUMBER] >= 0 and kind[b, TOUCHED] == 1:
            i = island[b, NUMBER]
            island[span[i, STAMP], MEMBER] = b
            span[i, STAMP] += 1


@kernel
def group_links(
    island: Ints, link: Ints, links: int, one: int, two: int, span: Ints, islands: int, first: int, order: Ints
) -> None:
    """List the links (contacts or joints) of every island in `order`, in ascending order (counting sort).

    Args: one, two: the columns of `link` with its two bodies; first: the column of `span` where each island's list begins.
    """
    for i in range(islands + 1):
        span[i, first] = 0
    for k in range(links):
        i = island_of(island, link[k, one], link[k, two])
        if i >= 0:
            span[i + 1, first] += 1
    for i in range(islands):
        span[i + 1, first] += span[i, first]
        span[i, STAMP] = span[i, first]
    for k in range(links):
        i = island_of(island, link[k, one], link[k, two])
        if i >= 0:
            order[span[i, STAMP], 0] = k
            span[i, STAMP] += 1


@kernel
def assign_row(island: Ints, owner: Ints, b: int, i: int, row: int) -> int:
    """Give body b a row of island i, unless it has one. Returns: the next free row."""
    if island[b, STAMP] == i:
        return row
    island[b, STAMP], island[b, LOCAL] = i, row
    owner[row, 0] = b
    return row + 1


@kernel
def assign_rows(
    island: Ints, bodies: int, span: Ints, islands: int, key: Ints, grouped: Ints, joint_kind: Ints, grouped_joint: Ints,
    owner: Ints, manifold_key: Ints, local_joint_kind: Ints,
) -> None:  # fmt: skip
    """Give the bodies of every island rows beside each other, its own before the fixed ones that it leans on.

    A fixed body has a row in each of its islands. The contacts and joints of the islands are written, grouped, with these rows
    in the place of their bodies.
    """
    for b in range(bodies + 1):
        island[b, STAMP] = -1
    row = 0
    for i in range(islands):
        first = row
        span[i, FIRST_LOCAL] = row
        for at in range(span[i, FIRST_BODY], span[i + 1, FIRST_BODY]):
            row = assign_row(island, owner, island[at, MEMBER], i, row)
        for at in range(span[i, FIRST_MANIFOLD], span[i + 1, FIRST_MANIFOLD]):
            m = grouped[at, 0]
            for side in (BODY_A, BODY_B):
                row = assign_row(island, owner, key[m, side], i, row)
                manifold_key[at, side] = island[key[m, side], LOCAL] - first
        for at in range(span[i, FIRST_JOINT], span[i + 1, FIRST_JOINT]):
            j = grouped_joint[at, 0]
            for side in (PARENT, CHILD):
                row = assign_row(island, owner, joint_kind[j, side], i, row)
                local_joint_kind[at, side] = island[joint_kind[j, side], LOCAL] - first
    span[islands, FIRST_LOCAL] = row


@kernel
def share(span: Ints, tally: Ints, t: int) -> int:
    """Where the islands of thread t begin, so that each thread has about as many contacts and joints as the next."""
    islands, threads = tally[0, ISLANDS], tally[0, THREADS]
    links = span[islands, FIRST_MANIFOLD] + span[islands, FIRST_JOINT]
    low, high = 0, islands
    while low < high:
        middle = (low + high) // 2
        if (span[middle, FIRST_MANIFOLD] + span[middle, FIRST_JOINT]) * threads < t * links:
            low = middle + 1
        else:
            high = middle
    return islands if t == threads else (0 if t == 0 else low)


@entry
def connected_components(links: Ints, kind: Ints, island: Ints) -> int:
    """Number the islands of bodies under links alone.

    Args: links (k, 2): pairs of bodies; kind (n, 4) as BODY_KIND; island (n, 8) as ISLAND, whose column NUMBER is written.
    Returns: how many islands there are.
    """
    start_islands(island, kind.shape[0])
    for k in range(links.shape[0]):
        connect(island, kind, links[k, 0], links[k, 1])
    return number_islands(island, kind, kind.shape[0])
