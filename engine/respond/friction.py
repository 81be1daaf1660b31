"""Coulomb friction at a manifold: static friction of all its points together, each point within its disc, rolling and torsion.

`l_T <- l_T - mass_T u_T`, scaled down to norm(l_T) <= mu l_N, where `l` are impulses along (`N`) and across (`T`) the normal
and `u_T` is the tangential velocity. `soft` calls it in each sweep.

Source: as `engine.respond.soft`.
"""

import math

from plumbline.engine.compile.jit import inlined, kernel
from plumbline.engine.maths.floats import fma
from plumbline.engine.maths.rows import Floats, Mat, Sym, Vec, load3, load6, store3
from plumbline.engine.maths.vec import axpy, mat_vec, scale, sub, sym_vec, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Contacts
from plumbline.engine.respond.centre import frame_of


@kernel
def resist_spin(manifold: Floats, m: int, frame: Mat, w: Vec, total: float) -> Vec:
    """Rolling and torsional friction under the normal impulse `total` [N s]: the change of their moment, in the frame."""
    before = mat_vec(frame, load3(manifold, m, at.SPIN_IMPULSE))
    rolling, torsional = manifold[m, at.LAW + 3] * total, manifold[m, at.LAW + 4] * total
    one, two = before[0] - manifold[m, at.SPIN_MASS] * w[0], before[1] - manifold[m, at.SPIN_MASS] * w[1]
    size = math.sqrt(one * one + two * two)
    if size > rolling:
        one, two = one * (rolling / size), two * (rolling / size)
    after = (one, two, min(max(before[2] - manifold[m, at.SPIN_MASS + 1] * w[2], -torsional), torsional))
    store3(manifold, m, at.SPIN_IMPULSE, tmat_vec(frame, after))
    return sub(after, before)


@kernel
def static_friction(manifold: Floats, m: int, slide: Vec, friction: float, first: int, end: int, point: Floats) -> Vec:
    """Stop the tangential motion (V1, V2, W3) of a manifold by impulses spread over its points first..end - 1, as a pair.

    Returns: force and moment, given to the points; or inf, and nothing given, where a point would leave its disc.
    """
    stop = sym_vec(load6(manifold, m, at.STOP_BLOCK), slide)
    share = manifold[m, at.POINT_SHARE]
    f1, f2, turn = -share * stop[0], -share * stop[1], -stop[2] * manifold[m, at.STOP_TURN]
    inside, square = True, 0.0
    for i in range(first, end):
        x, y, most = point[i, at.SPREAD], point[i, at.SPREAD + 1], friction * point[i, at.NORMAL_IMPULSE]
        one, two = fma(-y, turn, point[i, at.HELD] + f1), fma(x, turn, point[i, at.HELD + 1] + f2)
        inside = inside and one * one + two * two <= most * most
        square += x * x + y * y
    if not inside:
        return math.inf, 0.0, 0.0
    for i in range(first, end):
        point[i, at.HELD] += f1 - point[i, at.SPREAD + 1] * turn
        point[i, at.HELD + 1] += f2 + point[i, at.SPREAD] * turn
    return -stop[0], -stop[1], turn * square


@kernel
def friction_point(tangents: Sym, slide: Vec, friction: float, first: int, end: int, back: int, point: Floats) -> Vec:
    """Friction at the points first..end - 1 one by one, from the last where `back` is 1, each within its disc.

    Returns: the force and moment that they give.
    """
    f1, f2, m3 = 0.0, 0.0, 0.0
    for k in range(first, end):
        i = first + end - 1 - k if back == 1 else k
        x, y, mass = point[i, at.SPREAD], point[i, at.SPREAD + 1], point[i, at.TANGENT_MASS]
        most = friction * point[i, at.NORMAL_IMPULSE]
        was_1, was_2 = point[i, at.HELD], point[i, at.HELD + 1]
        by_1, by_2 = sym_vec(tangents, (1.0, 0.0, -y)), sym_vec(tangents, (0.0, 1.0, x))
        one, two = fma(-mass, fma(-y, slide[2], slide[0]), was_1), fma(-mass, fma(x, slide[2], slide[1]), was_2)
        square, rest = fma(two, two, one * one), axpy(-was_1, by_1, axpy(-was_2, by_2, slide))
        slide = axpy(one, by_1, axpy(two, by_2, rest))
        if square > most * most:
            share = most / square * math.sqrt(square)
            slide = axpy(share, axpy(one, by_1, scale(two, by_2)), rest)
            one, two = share * one, share * two
        point[i, at.HELD], point[i, at.HELD + 1] = one, two
        one, two = one - was_1, two - was_2
        f1, f2, m3 = f1 + one, f2 + two, fma(-y, one, fma(x, two, m3))
    return f1, f2, m3


@inlined
def roll(contacts: Contacts, m: int, w: Vec) -> Vec:
    """The moment of manifold m against rolling and torsion at the angular velocity W, in the frame."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    moment = (0.0, 0.0, 0.0)
    if manifold[m, at.LAW + 3] > 0.0 or manifold[m, at.LAW + 4] > 0.0:
        total = 0.0
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            total += point[i, at.NORMAL_IMPULSE]
        moment = resist_spin(manifold, m, frame_of(manifold, m), w, total)
    return moment
