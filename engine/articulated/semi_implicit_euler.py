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

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions, change_rates, drift_coordinates
from plumbline.engine.articulated.articulated_body import answer_forces
from plumbline.engine.articulated.bounded import MOST_TURNS, are_settled, settle_laws, start_again, start_laws
from plumbline.engine.articulated.laws import ALL, write_laws
from plumbline.engine.articulated.momenta import go_on_bending, keep_momenta
from plumbline.engine.articulated.motion import move_links
from plumbline.engine.articulated.secants import bend_links
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.articulated.tendons import write_tendons
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, load3, store3
from plumbline.engine.maths.vec import axpy
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints

FORGOTTEN = 2.0
"""By how much the share of a change that a round leaves may have grown from one sub-step to the next."""

MOST_ROUNDS = 50
"""Three are needed where h times the angular velocities is small; more than these where the step is far too long."""


@kernel
def take_changes(tables: Tables, joints: Joints, h: float, reactions: bool) -> None:
    """Change rates, and velocities of links along the tangent, by h times what was solved for; count what joints carry."""
    if reactions:
        add_reactions(tables, joints, h)
    change_rates(tables, h)
    motion = tables.motion
    for i in range(motion.shape[0]):
        for c in (0, 3):
            a = load3(motion, i, tree.ACCELERATION + c)
            store3(motion, i, tree.VELOCITY + c, axpy(h, a, load3(motion, i, tree.VELOCITY + c)))


@kernel
def semi_implicit_euler(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, reactions: bool
) -> bool:
    """Advance all trees by h. Args: reactions: whether to count what joints carry. Returns: whether the laws had an answer."""
    move_links(tables, bodies.state)
    go_on_bending(tables)
    start_laws(tables)
    breaks = write_laws(tables, joints, h, ALL) + write_tendons(tables, h)
    for turn in range(MOST_TURNS if breaks > 0 else 1):
        if turn > 0:
            if are_settled(tables, joints, setting, h):
                break
            start_again(tables, bodies, joints, setting, h, gyroscopic, ALL, reactions)
        if not settle_laws(tables, bodies, joints, setting, h, gyroscopic, ALL, breaks):
            return False
        take_changes(tables, joints, h, reactions)
        close_bends(tables, bodies, joints, setting, h, reactions)
    keep_momenta(tables, gyroscopic)
    drift_coordinates(tables, h)
    return True


@kernel
def close_bends(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, reactions: bool) -> None:
    """Change the rates until they take the momenta along the bends that they make themselves. Args: as above.

    The first change says of the next what the last sub-step knew, unless it is a surprise itself; then each two say.
    """
    before, left = math.inf, tables.passage[0, tree.CONTRACTION]
    for turn in range(MOST_ROUNDS):
        bend_links(tables, bodies, h)
        change, rate = answer_forces(tables, h)
        if reactions:
            add_reactions(tables, joints, h)
        if turn > 0:
            left = change / before
        surprise = change / rate if turn == 0 and rate > 0.0 else 0.0
        if change * max(left, surprise) <= setting[0, at.STEP_TOLERANCE] * rate or change >= before:
            break
        before = change
    tables.passage[0, tree.CONTRACTION] = min(FORGOTTEN * left, 1.0)
