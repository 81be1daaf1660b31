"""Whether a joint stays open after a step: the last look at what the solvers were asked to close.

Beside contacts a joint may be open by what the last sub-step turned, and the next one closes that. So a gap is looked into that
is wider than it has any need to be: where no motion of the bodies closes it, it stays.
"""

import numpy as np

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.joint_rows import anchors, equality_rows
from plumbline.engine.constrain.projection import close_gaps
from plumbline.engine.integrate.semi_implicit_euler import turn_inertia
from plumbline.engine.maths.rows import Floats, Ints, load3
from plumbline.engine.maths.vec import dot, norm
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import OPEN_JOINT
from plumbline.engine.memory.tables import Bodies, Joints, Rows, bodies_of, joints_of, rows_of

CLOSED = 1e-6
"""A gap below this share of the joint's levers, or this angle, is closed: rounds end at 1e-14 or where round-off stops them."""

CONTACT_CLOSED = 0.1
"""The same beside contacts, whose sub-steps close a gap of the last one: turning by w h opens (w h)^2 / 2 of the lever."""

SUSPECT = 1e-3
"""Beside contacts, a wider gap is looked into: it is what a turn of .045 in a sub-step opens, or one that nothing closes."""

TRIES = 3
"""Times that closing a gap is tried, of four rounds each; the number of right digits doubles in a round."""

ROUND_OFF = 1e-12
"""What floats lose of a place, by its distance from the origin, over the sums that make a gap; and of any gap [m or rad]."""


@kernel
def open_joint(floats: Floats, ints: Ints, touching: bool) -> int:
    """Look at all gaps. Args: touching: whether contacts are solved beside the joints.

    Returns: 0, or OPEN_JOINT plus the number of the joint that is open furthest beyond its bound; its gap goes to OPEN_GAP.
    """
    state, setting = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.SETTING)
    joint, gap = widest_joint(floats, ints, state, SUSPECT if touching else CLOSED, moving=False)
    if touching and joint >= 0:
        suspect, narrow = joint, gap
        joint, gap = widest_joint(floats, ints, state, CONTACT_CLOSED, moving=True)
        if joint < 0 and not closes(floats, ints):
            joint, gap = suspect, narrow
    if joint < 0:
        return 0
    setting[0, at.OPEN_GAP] = gap
    return OPEN_JOINT + joint


@kernel
def closes(floats: Floats, ints: Ints) -> bool:
    """Whether some motion of the bodies, tried on copies, closes the gaps of all joints."""
    bodies, joints, rows = bodies_of(floats, ints), joints_of(floats, ints), rows_of(floats, ints)
    state, turned = bodies.state.copy(), bodies.turned.copy()
    for b in range(state.shape[0]):
        if bodies.kind[b, at.MOTION] == at.DYNAMIC:
            turn_inertia(state, bodies.body, turned, b)
    trial, change = Bodies(state, bodies.body, turned, bodies.load, bodies.kind), np.zeros(state.shape)
    for _ in range(TRIES):
        close_gaps(trial, joints, rows, change)
    joint, _ = widest_joint(floats, ints, state, SUSPECT, moving=False)
    return joint < 0


@kernel
def widest_joint(floats: Floats, ints: Ints, state: Floats, share: float, moving: bool) -> tuple[int, float]:
    """The joint that is open furthest beyond a share of its levers, or an angle of that size, in this state, and its gap.

    Args: moving: whether the sizes of its bodies count as levers, and what its bodies go and turn in a sub-step is granted.
    Returns: -1 where none is.
    """
    body, setting = floats_of(floats, ints, at.BODY), floats_of(floats, ints, at.SETTING)
    joints, every = joints_of(floats, ints), rows_of(floats, ints)
    joint, kind, spare = joints.joint, joints.kind, every.row.shape[0] // 2
    rows = Rows(every.row[spare:], every.body[spare:], every.reach, every.matrix, every.factor, every.vector)
    h = setting[0, at.DT] / ints_of(ints, at.COUNT)[0, at.SUBSTEPS]
    widest, furthest, gap = -1, 1.0, 0.0
    for rank in range(len(joints.order)):
        j = joints.order[rank, 0]
        a, b = kind[j, at.PARENT], kind[j, at.CHILD]
        n = equality_rows(state, Joints(joint, kind, joints.order[rank : rank + 1]), rows)
        ra, rb, d = anchors(state, joint, j, a, b)
        wa, wb = norm(load3(state, a, at.W)), norm(load3(state, b, at.W))
        way = h * (norm(load3(state, a, at.V)) + norm(load3(state, b, at.V)) + wa * norm(ra) + wb * norm(rb))
        lever = norm(ra) + norm(rb) + joint[j, at.LENGTH]
        if moving:
            lever += body[a, at.EXTENT] + body[b, at.EXTENT] + way / share
        size = 1.0 + norm(load3(state, a, at.P)) + norm(load3(state, b, at.P)) + norm(d)
        length = share * lever + CLOSED * way + ROUND_OFF * size
        angle = share + (h * (wa + wb) if moving else 0.0)
        for r in range(n):
            turns = dot(load3(rows.row, r, at.JACOBIAN), load3(rows.row, r, at.JACOBIAN)) == 0.0
            excess = abs(rows.row[r, at.GAP]) / (angle if turns else length)
            if excess > furthest:
                widest, furthest, gap = j, excess, abs(rows.row[r, at.GAP])
    return widest, gap
