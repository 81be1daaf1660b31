"""What impulses at the centre of a manifold do to the relative motion there: M, six by six, kept as three blocks.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, section 2.4 (motion and force as six-vectors).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, Mat, Sym, Vec, load6, store6, store9
from plumbline.engine.maths.vec import cross, mat_vec, sym_rotate
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Contacts
from plumbline.engine.respond.centre import Centre, Pair

THIN = 1e-6
"""Squared spread of the points over the squared arm at which they would move the bodies as much by turning as by shifting [1],
below which they count as one."""


@kernel
def mobility(frame: Mat, mass: float, inertia: Sym, c: Vec) -> tuple[Sym, Mat, Sym]:
    """What force and moment at the arm c [m] in W do to one body's motion there, per unit of impulse, in the frame.

    Args: mass [1/kg] and inertia [1/(kg m2)], in W, of the body, both inverse.
    Returns: velocity by force, velocity by moment (rows: velocity), angular velocity by moment.
    """
    g = sym_rotate(frame, inertia)
    c = mat_vec(frame, c)
    by_1, by_2, by_3 = cross((g[0], g[3], g[4]), c), cross((g[3], g[1], g[5]), c), cross((g[4], g[5], g[2]), c)
    x = cross((by_1[0], by_2[0], by_3[0]), c)
    y = cross((by_1[1], by_2[1], by_3[1]), c)
    z = cross((by_1[2], by_2[2], by_3[2]), c)
    turned: Mat = (by_1[0], by_2[0], by_3[0], by_1[1], by_2[1], by_3[1], by_1[2], by_2[2], by_3[2])
    return (mass + x[0], mass + y[1], mass + z[2], x[1], x[2], y[2]), turned, g


@kernel
def write_blocks(manifold: Floats, m: int, centre: Centre, pair: Pair) -> None:
    """The three blocks of M: on (V3, W1, W2) and on (V1, V2, W3) of their own forces, and the rest, rows V1, V2, W3."""
    fa, ta, ga = mobility(centre.frame, pair.mass_a, pair.inertia_a, centre.arm_a)
    fb, tb, gb = mobility(centre.frame, pair.mass_b, pair.inertia_b, centre.arm_b)
    store6(
        manifold, m, at.NORMAL_BLOCK,
        (fa[2] + fb[2], ga[0] + gb[0], ga[1] + gb[1], ta[6] + tb[6], ta[7] + tb[7], ga[3] + gb[3]),
    )  # fmt: skip
    store6(
        manifold, m, at.TANGENT_BLOCK,
        (fa[0] + fb[0], fa[1] + fb[1], ga[2] + gb[2], fa[3] + fb[3], ta[2] + tb[2], ta[5] + tb[5]),
    )  # fmt: skip
    store9(
        manifold, m, at.COUPLING,
        (
            fa[4] + fb[4], ta[0] + tb[0], ta[1] + tb[1],
            fa[5] + fb[5], ta[3] + tb[3], ta[4] + tb[4],
            ta[8] + tb[8], ga[4] + gb[4], ga[5] + gb[5],
        ),
    )  # fmt: skip


@kernel
def effective_masses(normals: Sym, tangents: Sym, x: float, y: float) -> tuple[float, float]:
    """1 / the response to a normal impulse at (x, y), and 1 / the largest to a tangential one."""
    nn = normals[0] + y * (2.0 * normals[3] + y * normals[1] - 2.0 * x * normals[5]) + x * (x * normals[2] - 2.0 * normals[4])
    one = tangents[0] + y * (y * tangents[2] - 2.0 * tangents[4])
    two = tangents[1] + x * (x * tangents[2] + 2.0 * tangents[5])
    both = tangents[3] + x * tangents[4] - y * tangents[5] - x * y * tangents[2]
    half = 0.5 * (one - two)
    return 1.0 / nn, 1.0 / (0.5 * (one + two) + math.sqrt(half * half + both * both))


@kernel
def write_stop(manifold: Floats, m: int, key: Ints, point: Floats) -> None:
    """The inverse of the block on (V1, V2, W3), where the points can give a moment; else of that on (V1, V2)."""
    t = load6(manifold, m, at.TANGENT_BLOCK)
    square = 0.0
    for i in range(4 * m, 4 * m + key[m, at.POINTS]):
        square += point[i, at.SPREAD] * point[i, at.SPREAD] + point[i, at.SPREAD + 1] * point[i, at.SPREAD + 1]
    spans = square * t[2] > THIN * (t[0] + t[1])
    if not spans:
        t = (t[0], t[1], 1.0, t[3], 0.0, 0.0)
    stop: Sym = (
        t[1] * t[2] - t[5] * t[5],
        t[0] * t[2] - t[4] * t[4],
        t[0] * t[1] - t[3] * t[3],
        t[4] * t[5] - t[3] * t[2],
        t[3] * t[5] - t[4] * t[1],
        t[3] * t[4] - t[0] * t[5],
    )
    one = 1.0 / (t[0] * stop[0] + t[3] * stop[3] + t[4] * stop[4])
    store6(
        manifold, m, at.STOP_BLOCK, (one * stop[0], one * stop[1], one * stop[2], one * stop[3], one * stop[4], one * stop[5])
    )
    manifold[m, at.STOP_TURN] = 1.0 / square if spans else 0.0


@kernel
def write_masses(contacts: Contacts, m: int) -> None:
    """The effective masses of manifold m and of its points, by its blocks."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    normals, tangents = load6(manifold, m, at.NORMAL_BLOCK), load6(manifold, m, at.TANGENT_BLOCK)
    for i in range(4 * m, 4 * m + key[m, at.POINTS]):
        point[i, at.NORMAL_MASS], point[i, at.TANGENT_MASS] = effective_masses(
            normals, tangents, point[i, at.SPREAD], point[i, at.SPREAD + 1]
        )
    write_stop(manifold, m, key, point)
    if manifold[m, at.LAW + 3] > 0.0 or manifold[m, at.LAW + 4] > 0.0:
        manifold[m, at.SPIN_MASS] = 1.0 / max(normals[1] + normals[2], 1e-300)
        manifold[m, at.SPIN_MASS + 1] = 1.0 / max(tangents[2], 1e-300)
