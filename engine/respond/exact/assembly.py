"""The compiled assembly of a contact problem without joints, and what its impulses do: W = J M^-1 J^T block by block.

Contacts that share no dynamic body share no block. Blocks above the diagonal are those below it, turned: W is symmetric to the
last bit.
"""

import math

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.rows import Floats, Ints, load3, load6, store3
from plumbline.engine.maths.vec import axpy, cross, dot, scale, sub, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of

VELOCITY, BROUGHT, FRICTION, LIFT, COLUMNS = 0, 3, 6, 7, 8
"""Columns of what is said of a contact: what the law sees at no impulse (3) m/s, the impulse (3) N s that it brings, Coulomb's
coefficient, and, told, what is added to J v along the normal [m/s]."""


@entry
def write_frames(floats: Floats, ints: Ints, rows: Ints, bodies: Ints, frame: Floats, arm: Floats) -> int:
    """Write rows, bodies, frames and arms of all present contacts. Args: as of `ContactFrames`. Returns: how many there are.

    Source of the frames: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6, 2017.
    """
    point, manifold = floats_of(floats, ints, at.POINT), floats_of(floats, ints, at.MANIFOLD)
    key, k = ints_of(ints, at.MANIFOLD_KEY), 0
    for m in range(ints_of(ints, at.COUNT)[0, at.MANIFOLDS]):
        x, y, z = load3(manifold, m, at.NORMAL)
        sign = 1.0 if z >= 0.0 else -1.0
        a = -1.0 / (sign + z)
        b = x * y * a
        for p in range(4 * m, 4 * m + key[m, at.POINTS]):
            rows[k], bodies[k, 0], bodies[k, 1] = p, key[m, at.BODY_A], key[m, at.BODY_B]
            frame[k, 0, 0], frame[k, 1, 0], frame[k, 2, 0] = x, y, z
            frame[k, 0, 1], frame[k, 1, 1], frame[k, 2, 1] = 1.0 + sign * x * x * a, sign * b, -sign * x
            frame[k, 0, 2], frame[k, 1, 2], frame[k, 2, 2] = b, sign + y * y * a, -y
            for c in range(3):
                arm[k, 0, c], arm[k, 1, c] = point[p, at.ARM_A + c], point[p, at.ARM_B + c]
            k += 1
    return k


@entry
def write_closing(floats: Floats, ints: Ints, rows: Ints, touching: float, h: float, lift: Floats) -> None:
    """Write the velocities (k,) m/s at which gaps beyond `touching` [m] close in h seconds; 0 for the others."""
    point = floats_of(floats, ints, at.POINT)
    for i in range(len(rows)):
        lift[i] = max(point[rows[i], at.SEPARATION] - touching, 0.0) / h


@kernel
def turn_of(frame: Floats, arm: Floats, i: int, end: int, c: int) -> tuple[float, float, float]:
    """The arm of an end of contact i across axis c of its frame."""
    return cross((arm[i, end, 0], arm[i, end, 1], arm[i, end, 2]), (frame[i, 0, c], frame[i, 1, c], frame[i, 2, c]))


@entry
def write_problem(
    floats: Floats, ints: Ints, rows: Ints, bodies: Ints, frame: Floats, arm: Floats, w: Floats, out: Floats
) -> float:
    """Write W (3k, 3k), and of each contact `out` (k, COLUMNS). Args: rows, bodies, frame, arm: as of `ContactFrames`.

    Returns: the largest of the velocities J v and of the rebounds [m/s]; no number where one is none.
    """
    state, body = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.BODY)
    turned = floats_of(floats, ints, at.TURNED)
    point, manifold = floats_of(floats, ints, at.POINT), floats_of(floats, ints, at.MANIFOLD)
    k, square, total = len(rows), 0.0, 0.0
    angular, reach = np.empty((k, 2, 3, 3)), np.empty((k, 2, 3, 3))
    for i in range(k):
        for end in range(2):
            inverse = load6(turned, bodies[i, end], 0)
            for c in range(3):
                turn = turn_of(frame, arm, i, end, c)
                moved = sym_vec(inverse, turn)
                for x in range(3):
                    angular[i, end, c, x], reach[i, end, c, x] = turn[x], moved[x]
        a, b, p = bodies[i, 0], bodies[i, 1], rows[i]
        arm_a, arm_b = (arm[i, 0, 0], arm[i, 0, 1], arm[i, 0, 2]), (arm[i, 1, 0], arm[i, 1, 1], arm[i, 1, 2])
        at_a = axpy(1.0, load3(state, a, at.V), cross(load3(state, a, at.W), arm_a))
        at_b = axpy(1.0, load3(state, b, at.V), cross(load3(state, b, at.W), arm_b))
        u = sub(at_b, at_a)
        square, total = max(square, dot(u, u)), total + dot(u, u)
        normal = (frame[i, 0, 0], frame[i, 1, 0], frame[i, 2, 0])
        impulse = axpy(point[p, at.NORMAL_IMPULSE], normal, load3(point, p, at.TANGENT_IMPULSE))
        for c in range(3):
            axis = (frame[i, 0, c], frame[i, 1, c], frame[i, 2, c])
            out[i, VELOCITY + c], out[i, BROUGHT + c] = dot(axis, u), dot(axis, impulse)
        out[i, VELOCITY] += out[i, LIFT]
        square = max(square, min(out[i, LIFT], 0.0) ** 2)
        out[i, FRICTION] = manifold[p // 4, at.LAW + 1]
    w[:] = 0.0
    for i in range(k):
        for j in range(i + 1):
            apart = True
            for end in range(2):
                b = bodies[i, end]
                inverse_mass = body[b, at.INV_MASS]
                if inverse_mass == 0.0:
                    continue
                for other in range(2):
                    if bodies[j, other] != b:
                        continue
                    apart = False
                    sign = 1.0 if end == other else -1.0
                    for c in range(3):
                        for d in range(c + 1 if i == j else 3):
                            linear, turns = 0.0, 0.0
                            for x in range(3):
                                linear += frame[i, x, c] * frame[j, x, d]
                                turns += angular[i, end, c, x] * reach[j, other, d, x]
                            w[3 * i + c, 3 * j + d] += sign * (inverse_mass * linear + turns)
            if apart:
                continue
            for c in range(3):
                for d in range(c + 1 if i == j else 3):
                    w[3 * j + d, 3 * i + c] = w[3 * i + c, 3 * j + d]
    return math.sqrt(square) if math.isfinite(total) else math.nan


@entry
def give_impulses(floats: Floats, ints: Ints, rows: Ints, bodies: Ints, frame: Floats, arm: Floats, impulse: Floats) -> None:
    """Change the velocities by impulses (k, 3) N s, and keep them with the contact points. Args: as of `write_problem`."""
    state, body = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.BODY)
    turned = floats_of(floats, ints, at.TURNED)
    point = floats_of(floats, ints, at.POINT)
    for i in range(len(point)):
        for c in range(at.NORMAL_IMPULSE, at.TANGENT_IMPULSE + 3):
            point[i, c] = 0.0  # contacts left out of the problem give none
    for i in range(len(rows)):
        normal = (frame[i, 0, 0], frame[i, 1, 0], frame[i, 2, 0])
        one, two = (frame[i, 0, 1], frame[i, 1, 1], frame[i, 2, 1]), (frame[i, 0, 2], frame[i, 1, 2], frame[i, 2, 2])
        along = axpy(impulse[i, 1], one, scale(impulse[i, 2], two))
        whole = axpy(impulse[i, 0], normal, along)
        point[rows[i], at.NORMAL_IMPULSE] = impulse[i, 0]
        store3(point, rows[i], at.TANGENT_IMPULSE, along)
        for end in range(2):
            b, sign = bodies[i, end], 2.0 * end - 1.0
            if body[b, at.INV_MASS] == 0.0:
                continue
            moment = cross((arm[i, end, 0], arm[i, end, 1], arm[i, end, 2]), whole)
            store3(state, b, at.V, axpy(sign * body[b, at.INV_MASS], whole, load3(state, b, at.V)))
            store3(state, b, at.W, axpy(sign, sym_vec(load6(turned, b, 0), moment), load3(state, b, at.W)))
