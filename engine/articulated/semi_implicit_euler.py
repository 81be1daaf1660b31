"""Semi-implicit Euler in joint coordinates: momenta by the forces now, springs and limits at the end, coordinates by the rates.

    T(q)^T (M (x(q + h q') - x(q)) - h P - h^2 f) = h^2 (what acts along coordinates)
    P <- M (x(q + h q') - x(q)) / h,   q <- q + h q'

x are the poses of the bodies, T = dx/dq, and orientations turn by exp(h w). That is SHAKE without its multipliers, which the
tangent T leaves out, and without its gaps: the same motion as that of bodies with coordinates of their own, symplectic where
these are. It is solved by the articulated inertia of the start, which is found once: round by round

    q' <- q' - (T^T M T)^-1 T^T (M (x(q + h q') - x(q)) / h - M T q' - the last round's)

each of which makes the error smaller by about h times the angular velocities; the first begins with the bend that a parabola
through the last three sub-steps' tells. No round is made for a change of a rate that is expected to be below the tolerance of a
step, as a share of the largest rate. That leaves out as small a share of the way of one sub-step; momentum, which is handed on
as answered, keeps to round-off, angular momentum of a floating tree to a hundredth of the tolerance in a sub-step of 5e-3 s.
Laws that break are held to the rates that come of it (`engine.articulated.bounded`).

Source: Ryckaert, Ciccotti, Berendsen, J. Comput. Phys. 23, 1977; Hairer, Lubich, Wanner, Geometric Numerical Integration,
section VII.1.4; Leimkuhler, Patrick, A symplectic integrator for Riemannian manifolds, J. Nonlinear Sci. 6, 1996.
"""

import math
from typing import Final

from plumbline.engine.articulated import bounded
from plumbline.engine.articulated import contact_euler as held
from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import answer_forces, carry_bases, drift_coordinates, take_changes
from plumbline.engine.articulated.momenta import go_on_bending, keep_momenta
from plumbline.engine.articulated.motion import move_links
from plumbline.engine.articulated.secants import bend_links
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.memory import arena as at

FORGOTTEN = 2.0
"""By how much the share of a change that a round leaves may have grown from one sub-step to the next."""

MOST_ROUNDS = 50
"""Three are needed where h times the angular velocities is small; more than these where the step is far too long."""


UNSEEN: Final = 1e-17
"""The square of a turn [rad] in a sub-step up to which its bends change no coordinate: below a tenth of the rounding of one."""


@kernel
def stands(trees: Trees, h: float) -> bool:
    """Whether all turns of a machine in a sub-step are so small that what they bend, a product of two of them, is not seen."""
    motion, column, most = trees.motion, trees.column, 0.0
    for i in range(motion.shape[0]):
        for c in range(3):
            most += abs(motion[i, tree.VELOCITY + c])
    for k in range(column.shape[0]):
        most += abs(column[k, tree.RATE])
    return h * most * (h * most) <= UNSEEN


@kernel
def close_bends(trees: Trees, h: float, reactions: bool) -> None:
    """Change the rates until they take the momenta along the bends that they make themselves.

    The first change says of the next what the last sub-step knew, unless it is a surprise itself; then each two say.
    """
    before, left = math.inf, trees.passage[0, tree.CONTRACTION]
    for turn in range(MOST_ROUNDS):
        bend_links(trees, h)
        change, rate = answer_forces(trees, h, reactions)
        if turn > 0:
            left = change / before
        surprise = change / rate if turn == 0 and rate > 0.0 else 0.0
        if change * max(left, surprise) <= trees.setting[0, at.STEP_TOLERANCE] * rate or change >= before:
            break
        before = change
    trees.passage[0, tree.CONTRACTION] = min(FORGOTTEN * left, 1.0)


@kernel
def semi_implicit_euler(trees: Trees, h: float, reactions: bool, touching: held.Touching | None, substep: int) -> bool:
    """Advance all trees and bases by a sub-step h, and the free bodies that contacts touch.

    Args: reactions: whether to count what joints carry; touching: what else holds them, or None.
    Returns: whether the laws had an answer.
    """
    held.begin_loops(trees, touching, h)
    held.move_others(trees, touching, h, drifts=False)
    move_links(trees)
    go_on_bending(trees)
    times = held.start_contacts(trees, touching, h, substep)
    bounded.start_laws(trees)
    breaks = bounded.write_laws(trees, h, bounded.ALL)
    for turn in range(bounded.MOST_TURNS if breaks > 0 else 1):
        if turn > 0:
            if bounded.are_settled(trees, h):
                break
            bounded.start_again(trees, h, reactions)
        settled = bounded.settle_laws(trees, h, bounded.ALL, breaks)
        if not settled or not held.settle_contacts(trees, touching, breaks, times, reactions):
            return False
        take_changes(trees, h, reactions)
        if breaks == 0:
            held.answer_given(trees, touching, h, reactions)
        if touching is not None and turn == 0 and stands(trees, h):
            bend_links(trees, h)
        else:
            close_bends(trees, h, reactions)
    drift_coordinates(trees, h)
    carry_bases(trees, h)
    held.move_others(trees, touching, h, drifts=True)
    held.relax(trees, touching, times, reactions)
    keep_momenta(trees)
    return True
