"""Whether a joint stays open after a step: the last look at what the solvers were asked to close."""

from engine.compile.jit import kernel
from engine.constrain.joint_rows import anchors, equality_rows
from engine.maths.vec import Floats, Ints, dot, load3, norm
from engine.memory.arena import (
    BODY,
    CHILD,
    COUNT,
    DT,
    EXTENT,
    GAP,
    JACOBIAN,
    LENGTH,
    OPEN_GAP,
    PARENT,
    SETTING,
    STATE,
    SUBSTEPS,
    P,
    V,
    W,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import OPEN_JOINT
from engine.memory.tables import Joints, Rows, joints_of, rows_of

__all__ = ["open_joint"]

CLOSED = 1e-6
"""A gap below this share of the joint's levers, or this angle, is closed: rounds end at 1e-14 or where round-off stops them."""

CONTACT_CLOSED = 0.1
"""The same beside contacts, whose sub-steps close a gap of the last one: turning by w h opens (w h)^2 / 2 of the lever."""

ROUND_OFF = 1e-12
"""What floats lose of a place, by its distance from the origin, over the sums that make a gap; and of any gap [m or rad]."""


@kernel
def open_joint(floats: Floats, ints: Ints, touching: bool) -> int:
    """Look at all gaps. Args: touching: whether contacts are solved beside the joints.

    Returns: 0, or OPEN_JOINT plus the number of the joint that is open furthest beyond its bound; its gap goes to OPEN_GAP.
    """
    state, body, setting = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, SETTING)
    joints, every = joints_of(floats, ints), rows_of(floats, ints)
    joint, kind, spare = joints.joint, joints.kind, every.row.shape[0] // 2
    rows = Rows(every.row[spare:], every.body[spare:], every.reach, every.matrix, every.factor, every.vector)
    h, share = setting[0, DT] / ints_of(ints, COUNT)[0, SUBSTEPS], CONTACT_CLOSED if touching else CLOSED
    worst, furthest = 0, 1.0
    for j in range(joint.shape[0]):
        a, b = kind[j, PARENT], kind[j, CHILD]
        n = equality_rows(state, Joints(joint[j : j + 1], kind[j : j + 1]), rows)
        ra, rb, d = anchors(state, joint, j, a, b)
        wa, wb = norm(load3(state, a, W)), norm(load3(state, b, W))
        way = h * (norm(load3(state, a, V)) + norm(load3(state, b, V)) + wa * norm(ra) + wb * norm(rb))
        lever = norm(ra) + norm(rb) + joint[j, LENGTH]
        if touching:
            lever += body[a, EXTENT] + body[b, EXTENT] + way / share
        length = (
            share * lever + CLOSED * way + ROUND_OFF * (1.0 + norm(load3(state, a, P)) + norm(load3(state, b, P)) + norm(d))
        )
        angle = share + (h * (wa + wb) if touching else 0.0)
        for r in range(n):
            turns = dot(load3(rows.row, r, JACOBIAN), load3(rows.row, r, JACOBIAN)) == 0.0
            excess = abs(rows.row[r, GAP]) / (angle if turns else length)
            if excess > furthest:
                worst, furthest = OPEN_JOINT + j, excess
                setting[0, OPEN_GAP] = abs(rows.row[r, GAP])
    return worst
