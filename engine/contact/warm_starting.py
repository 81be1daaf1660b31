"""What a manifold takes over from the last step: the impulses of its points, or, where both bodies are still, all of it.

Points match when shapes and feature are the same, or, where a corner has just crossed an edge and so changed its feature, when
they lie close together. A ball that has gone on to the next triangle of a body goes on with what it bore on the last one.

Source: Ericson, Real-Time Collision Detection, section 12.4 (features); Catto, Iterative Dynamics with Temporal Coherence,
GDC 2005.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, load3, store3
from plumbline.engine.maths.vec import add, dot, norm, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Contacts, OldContacts

ON = 0.5
"""Share of a ball's radius [1] by which its contact may have moved on, from one triangle to the next."""
BENT = 0.99
"""Cosine of the angle [1] by which they may differ: an edge that is sharper is met with a blow."""


@kernel
def keep_old(kind: Ints, count: Ints, new: Contacts, old: OldContacts) -> None:
    """Move the last step's manifolds aside and list them by their first shape; those of still bodies whole."""
    n = count[0, at.MANIFOLDS]
    count[0, at.OLD_MANIFOLDS] = n
    for s in range(count[0, at.SHAPES]):
        old.head[s, 0] = -1
    for m in range(n):
        for c in range(old.key.shape[1]):
            old.key[m, c] = new.key[m, c]
        still = kind[new.key[m, at.BODY_A], at.STILL] == 1 and kind[new.key[m, at.BODY_B], at.STILL] == 1
        for c in range(old.manifold.shape[1] if still else 0):
            old.manifold[m, c] = new.manifold[m, c]
        store3(old.manifold, m, at.NORMAL, load3(new.manifold, m, at.NORMAL))
        store3(old.manifold, m, at.SPIN_IMPULSE, load3(new.manifold, m, at.SPIN_IMPULSE))
        for row in range(4 * m, 4 * m + new.key[m, at.POINTS]):
            for c in range(0 if still else at.NORMAL_IMPULSE, old.point.shape[1] if still else at.TANGENT_IMPULSE + 3):
                old.point[row, c] = new.point[row, c]
            store3(old.point, row, at.PLACE, load3(new.point, row, at.PLACE))
            old.point_key[row, 0] = new.point_key[row, 0]
        s = new.key[m, at.SHAPE_A]
        old.following[m, 0] = old.head[s, 0]
        old.head[s, 0] = m


@kernel
def last_manifold(old: OldContacts, a: int, b: int) -> int:
    """The row of the manifold that shapes a and b had in the last step, or -1."""
    m = old.head[a, 0]
    while m >= 0 and old.key[m, at.SHAPE_B] != b:
        m = old.following[m, 0]
    return int(m)


@kernel
def matching_point(new: Contacts, i: int, old: OldContacts, m: int, near: float) -> int:
    """The row of the point of old manifold m with the feature of point i, else of the closest within `near` [m], else -1."""
    best, closest = -1, near
    for other in range(4 * m, 4 * m + old.key[m, at.POINTS]):
        if old.point_key[other, 0] == new.point_key[i, 0]:
            return other
        apart = norm(sub(load3(old.point, other, at.PLACE), load3(new.point, i, at.PLACE)))
        if apart < closest:
            best, closest = other, apart
    return best


@kernel
def take_over(new: Contacts, row: int, old: OldContacts, m: int) -> None:
    """Take old manifold m over as it was."""
    copy_contact(Contacts(old.manifold, old.point, old.key, old.point_key, new.order), m, new, row)
    old.key[m, at.POINTS] = 0


@kernel
def copy_contact(contacts: Contacts, m: int, target: Contacts, to: int) -> None:
    """Copy manifold m with its points to row `to` of other tables, or of the same."""
    for c in range(target.manifold.shape[1]):
        target.manifold[to, c] = contacts.manifold[m, c]
    for c in range(target.key.shape[1]):
        target.key[to, c] = contacts.key[m, c]
    for k in range(contacts.key[m, at.POINTS]):
        for c in range(target.point.shape[1]):
            target.point[4 * to + k, c] = contacts.point[4 * m + k, c]
        for c in range(target.point_key.shape[1]):
            target.point_key[4 * to + k, c] = contacts.point_key[4 * m + k, c]


@kernel
def start_anew(state: Floats, contacts: Contacts, first: int, end: int) -> None:
    """Begin a step with the manifolds first..end - 1 as they are; `refresh` has put their points where the bodies are now."""
    point, key = contacts.point, contacts.key
    for m in range(first, end):
        pa = load3(state, key[m, at.BODY_A], at.P)
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            point[i, at.FIRST_GAP] = point[i, at.SEPARATION]
            store3(point, i, at.PLACE, add(pa, load3(point, i, at.ARM_A)))
            store3(point, i, at.SUM, (0.0, 0.0, 0.0))


@kernel
def carry_over(new: Contacts, row: int, old: OldContacts, m: int, near: float) -> None:
    """Start a manifold with the impulses of old manifold m, point by point; points within `near` [m] match.

    What is taken over leaves the old manifold without points, here and in the other functions.
    """
    new.key[row, at.SLIPS], new.key[row, at.BEGUN] = old.key[m, at.SLIPS], old.key[m, at.BEGUN]
    store3(new.manifold, row, at.SPIN_IMPULSE, load3(old.manifold, m, at.SPIN_IMPULSE))
    for i in range(4 * row, 4 * row + new.key[row, at.POINTS]):
        twin = matching_point(new, i, old, m, near)
        if twin >= 0:
            new.point[i, at.NORMAL_IMPULSE] = old.point[twin, at.NORMAL_IMPULSE]
            store3(new.point, i, at.TANGENT_IMPULSE, load3(old.point, twin, at.TANGENT_IMPULSE))
    old.key[m, at.POINTS] = 0


@kernel
def go_on(shape: Floats, shape_kind: Ints, new: Contacts, row: int, old: OldContacts) -> bool:
    """Start the contact of a ball on a triangle with what it bore on another one of the same body, which it has left.

    Returns: whether there is such a one.
    """
    a, b = new.key[row, at.SHAPE_A], new.key[row, at.SHAPE_B]
    if shape_kind[a, at.TYPE] != at.SPHERE or shape_kind[b, at.TYPE] != at.TRIANGLE:
        return False
    n, x, m = load3(new.manifold, row, at.NORMAL), load3(new.point, 4 * row, at.PLACE), old.head[a, 0]
    while m >= 0:
        if (
            old.key[m, at.POINTS] == 1
            and old.key[m, at.BODY_B] == new.key[row, at.BODY_B]
            and dot(n, load3(old.manifold, m, at.NORMAL)) > BENT
            and norm(sub(x, load3(old.point, 4 * m, at.PLACE))) < ON * shape[a, at.SIZE]
        ):
            carry_over(new, row, old, m, ON * shape[a, at.SIZE])
            return True
        m = old.following[m, 0]
    return False
