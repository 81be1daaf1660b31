"""Share the load of a body among its many contacts with what stands still, evenly, without a change of its force and moment.

More than three contacts with parallel normals are redundant: Coulomb's and Newton's laws give their resultant alone. Sequential
impulses leave it where the order of the contacts put it, and springs even it out slowly, from neighbour to neighbour in that
order; torsion by friction depends on it. Of all normal impulses with the same force and moments those of the least sum of
squares are affine in the place (x, y) on the plane of contact:

    l = a + b x + c y,  with the sums of l, l x and l y as they were

They are taken where none of them is negative, as the impulses that each solve starts from.

Source: Winkler's foundation under a rigid plate: Timoshenko, Woinowsky-Krieger, Theory of Plates and Shells, 1959, chapter 8.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, load3, store3
from plumbline.engine.maths.vec import dot, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Contacts

FEW = 4
"""Loaded points up to which a body's contacts are left as they are: one manifold's."""
TOUCHING = 1e-9
"""Gap [m] up to which a point without load may be given some."""
PARALLEL = 1e-12
"""Squared distance [1] of unit normals that count as one."""

# Columns of the sums over the loaded points of a body.
SIZE, SX, SY, SXX, SXY, SYY, SL, SLX, SLY, FIRST, MIXED = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 12
DONE = -1.0
"""In place of the number of points, once the plane is fitted."""


@kernel
def bearer(kind: Ints, key: Ints, m: int) -> int:
    """The dynamic body of a manifold with one that is not; -1 where both are."""
    a, b = key[m, at.BODY_A], key[m, at.BODY_B]
    if kind[a, at.MOTION] != at.DYNAMIC:
        return int(b)
    return int(a) if kind[b, at.MOTION] != at.DYNAMIC else -1


@kernel
def bears(point: Floats, i: int) -> bool:
    """Whether a point carries load, or touches and may, but for a blow."""
    return bool(point[i, at.STRUCK] == 0.0 and (point[i, at.NORMAL_IMPULSE] > 0.0 or point[i, at.SEPARATION] <= TOUCHING))


@kernel
def list_sharing(bodies: Bodies, contacts: Contacts, sums: Floats, room: Ints) -> int:
    """The contacts of bodies that have points enough on what does not move.

    Args: sums (bodies, 13): room to work in; room (k, 1): for their order. Returns: how many they are.
    """
    key, n = contacts.key, 0
    for step in range(3):
        for rank in range(len(contacts.order)):
            m = contacts.order[rank, 0]
            b = bearer(bodies.kind, key, m)
            if b >= 0 and step == 0:
                sums[b, SIZE] = 0.0
            elif b >= 0 and step == 1:
                sums[b, SIZE] += key[m, at.POINTS]
            elif b >= 0 and sums[b, SIZE] > FEW:
                room[n, 0] = m
                n += 1
    return n


@kernel
def share_loads(bodies: Bodies, contacts: Contacts, sums: Floats) -> None:
    """Make the normal impulses that the contacts bring along even. Args: sums (bodies, 13): room to work in."""
    if len(contacts.order) > 1:
        add_loads(bodies.kind, contacts, sums)
        for rank in range(len(contacts.order)):
            b = bearer(bodies.kind, contacts.key, contacts.order[rank, 0])
            if b >= 0 and sums[b, MIXED] == 0.0 and sums[b, SIZE] >= 0.0:
                fit_plane(sums, b)
        give_loads(bodies.kind, contacts, sums)


@kernel
def add_loads(kind: Ints, contacts: Contacts, sums: Floats) -> None:
    """Sum up what bears each body."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    for rank in range(len(contacts.order)):
        b = bearer(kind, key, contacts.order[rank, 0])
        for c in range(sums.shape[1] if b >= 0 else 0):
            sums[b, c] = 0.0
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        b = bearer(kind, key, m)
        if b < 0:
            continue
        n, t1, t2 = load3(manifold, m, at.NORMAL), load3(manifold, m, at.TANGENTS), load3(manifold, m, at.TANGENTS + 3)
        arm = at.ARM_A if key[m, at.BODY_A] == b else at.ARM_B
        if sums[b, SIZE] == 0.0:
            store3(sums, b, FIRST, n)
        apart = sub(n, load3(sums, b, FIRST))
        if dot(apart, apart) > PARALLEL:
            sums[b, MIXED] = 1.0
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            impulse, spot = point[i, at.NORMAL_IMPULSE], load3(point, i, arm)
            if bears(point, i):
                x, y = dot(t1, spot), dot(t2, spot)
                sums[b, SIZE] += 1.0
                sums[b, SX] += x
                sums[b, SY] += y
                sums[b, SXX] += x * x
                sums[b, SXY] += x * y
                sums[b, SYY] += y * y
                sums[b, SL] += impulse
                sums[b, SLX] += impulse * x
                sums[b, SLY] += impulse * y


@kernel
def fit_plane(sums: Floats, b: int) -> None:
    """Replace the sums of loads of body b by a, b and c of the even ones; MIXED where there are none."""
    size = sums[b, SIZE]
    if size <= FEW:
        sums[b, MIXED] = 1.0
        return
    x, y, mean = sums[b, SX] / size, sums[b, SY] / size, sums[b, SL] / size
    xx, xy, yy = sums[b, SXX] - size * x * x, sums[b, SXY] - size * x * y, sums[b, SYY] - size * y * y
    lx, ly = sums[b, SLX] - sums[b, SL] * x, sums[b, SLY] - sums[b, SL] * y
    det = xx * yy - xy * xy
    if det <= 1e-9 * (xx + yy) * (xx + yy):
        sums[b, MIXED] = 1.0
        return
    sums[b, SLX], sums[b, SLY] = (yy * lx - xy * ly) / det, (xx * ly - xy * lx) / det
    sums[b, SL] = mean - sums[b, SLX] * x - sums[b, SLY] * y
    sums[b, SIZE] = DONE


@kernel
def give_loads(kind: Ints, contacts: Contacts, sums: Floats) -> None:
    """Give the points of each body their even loads, unless one of these is negative."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    for given in range(2):
        for rank in range(len(contacts.order)):
            m = contacts.order[rank, 0]
            b = bearer(kind, key, m)
            if b < 0 or sums[b, MIXED] == 1.0:
                continue
            t1, t2 = load3(manifold, m, at.TANGENTS), load3(manifold, m, at.TANGENTS + 3)
            arm = at.ARM_A if key[m, at.BODY_A] == b else at.ARM_B
            for i in range(4 * m, 4 * m + key[m, at.POINTS]):
                if bears(point, i):
                    spot = load3(point, i, arm)
                    impulse = sums[b, SL] + sums[b, SLX] * dot(t1, spot) + sums[b, SLY] * dot(t2, spot)
                    if given == 1:
                        point[i, at.NORMAL_IMPULSE] = impulse
                    elif impulse <= 0.0:
                        sums[b, MIXED] = 1.0
