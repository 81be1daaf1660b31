"""Where a sub-step takes the links, and by how much their way there leaves the tangent of its start.

    v = (p(q + h q') - p(q)) / h,    exp(h w) R(q) = R(q + h q'),    bend = (w, v) - T(q) q'

All is told by turns D = R(q + h q') R(q)^T and ways from the start on, in W, so that no digits are lost in differences:

    D = D_parent exp(h sum S_k q'_k),    way = way_parent + (D_parent - 1) (anchor - p_parent) + (D - 1) (p - anchor)

and what slides goes h q' D_parent n more.
"""

import math
from typing import Final

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.forces import centre_velocity, put_force
from plumbline.engine.articulated.motion import UPRIGHT, rates_of
from plumbline.engine.articulated.spatial import STILL, sliding, sub6, turning
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import atan2, cos_sin
from plumbline.engine.maths.floats import fma
from plumbline.engine.maths.rows import Quat, Vec, load3, load4, load6, store3, store4, store6
from plumbline.engine.maths.vec import add, axpy, cross, dot, neg, quat_mul, scale, sub, sym_vec
from plumbline.engine.memory import arena as at

SMALL: Final = 2.5e-3
"""The square of half an angle, or of its sine, up to which the series here are as good as round-off: below 1e-17 is left."""

FAR: Final = 2.0
"""An angle [rad] from which on a turn may be meant as one by more than half a round, or the other way."""


@kernel
def turn_by(angle: Vec) -> Quat:
    """exp(angle), as a quaternion."""
    square = 0.25 * dot(angle, angle)
    if square < SMALL:
        again = square * square
        cosine = fma(again, fma(again, 1 / 40320, fma(square, -1 / 720, 1 / 24)), fma(square, -1 / 2, 1.0))
        ratio = fma(again, fma(again, 1 / 362880, fma(square, -1 / 5040, 1 / 120)), fma(square, -1 / 6, 1.0))
    else:
        half = math.sqrt(square)
        cosine, sine = cos_sin(half)
        ratio = sine / half
    s = 0.5 * ratio
    return cosine, s * angle[0], s * angle[1], s * angle[2]


@kernel
def moved_by(d: Quat, arm: Vec) -> Vec:
    """(D - 1) arm."""
    x = (d[1], d[2], d[3])
    once = cross(x, arm)
    return scale(2.0, axpy(d[0], once, cross(x, once)))


@kernel
def angular_velocity(d: Quat, h: float, near: Vec) -> Vec:
    """w with exp(h w) = D; of all those, that nearest to `near`."""
    sign = 1.0 if d[0] >= 0.0 else -1.0
    x = (sign * d[1], sign * d[2], sign * d[3])
    square = dot(x, x)
    far = h * h * dot(near, near) > FAR * FAR
    if square < SMALL and not far:
        # The series of the arcsine.
        again = square * square
        far_terms = fma(again, fma(square, 63 / 2816, 35 / 1152), fma(square, 5 / 112, 3 / 40))
        return scale(2.0 / h * fma(again, far_terms, fma(square, 1 / 6, 1.0)), x)
    sine = math.sqrt(square)
    if sine == 0.0:
        return near if far else x
    angle = 2.0 * atan2(sine, sign * d[0])
    if far:
        angle += 2.0 * math.pi * math.floor((h * dot(near, x) / sine - angle) / (2.0 * math.pi) + 0.5)
    return scale(angle / (h * sine), x)


@kernel
def base_end(trees: Trees, i: int, h: float) -> tuple[Quat, Vec]:
    """The turn of the base of root i in h seconds, and the way of the tree's origin on it."""
    state, b = trees.bodies.state, trees.kind[i, tree.BASE]
    if trees.bodies.kind[b, at.MOTION] != at.KINEMATIC:
        return UPRIGHT, STILL
    d = turn_by(scale(h, load3(state, b, at.W)))
    arm = sub(load3(trees.motion, i, tree.ORIGIN), load3(state, b, at.P))
    return d, axpy(h, load3(state, b, at.V), moved_by(d, arm))


@kernel
def go_to_end(trees: Trees, i: int, h: float) -> tuple[Quat, Vec]:
    """The turn of link i in h seconds by the present rates, and the way of its centre of mass, its parent's being known."""
    passage, motion, column = trees.passage, trees.motion, trees.column
    kind, parent, k = trees.kind[i, tree.TYPE], trees.kind[i, tree.PARENT], trees.kind[i, tree.FIRST]
    if kind == tree.FREE:
        return turn_by(scale(h, rates_of(trees, k))), scale(h, rates_of(trees, k + 3))
    anchor = load3(passage, i, tree.ANCHOR_W)
    if parent >= 0:
        d = load4(passage, parent, tree.TURNING)
        way = add(load3(passage, parent, tree.WAY), moved_by(d, sub(anchor, load3(motion, parent, tree.PLACE))))
    else:
        d, way = base_end(trees, i, h)
        way = add(way, moved_by(d, anchor))
    if kind == at.REVOLUTE:
        d = quat_mul(d, turn_by(scale(h * column[k, tree.RATE], load3(column, k, tree.AXIS_W))))
    elif kind == at.PRISMATIC:
        n = load3(column, k, tree.AXIS_W + 3)
        way = axpy(h * column[k, tree.RATE], add(n, moved_by(d, n)), way)
    elif kind == at.BALL:
        w = scale(column[k + 2, tree.RATE], load3(column, k + 2, tree.AXIS_W))
        for c in (k + 1, k):
            w = axpy(column[c, tree.RATE], load3(column, c, tree.AXIS_W), w)
        d = quat_mul(d, turn_by(scale(h, w)))
    return d, add(way, moved_by(d, sub(load3(motion, i, tree.PLACE), anchor)))


@kernel
def bend_links(trees: Trees, h: float) -> None:
    """Write the bend of every link at the present rates, and the force that it needs for what is new of it."""
    passage = trees.passage
    for i in range(trees.link.shape[0]):
        d, shift = go_to_end(trees, i, h)
        store4(passage, i, tree.TURNING, d)
        store3(passage, i, tree.WAY, shift)
        tangent, last = load3(trees.motion, i, tree.VELOCITY), load6(passage, i, tree.BEND)
        bend = (*sub(angular_velocity(d, h, tangent), tangent), *axpy(1.0 / h, shift, neg(centre_velocity(trees, i))))
        store6(passage, i, tree.BEND, bend)
        more = sub6(bend, last)
        torque = sym_vec(load6(passage, i, tree.TURNED_INERTIA), turning(more))
        put_force(trees, i, scale(1.0 / h, torque), scale(trees.link[i, tree.MASS] / h, sliding(more)))
