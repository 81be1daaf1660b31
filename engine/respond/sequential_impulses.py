"""Sequential impulses: projected Gauss-Seidel on velocities, warm-started, with a split impulse for the position error.

Sweeps are those of `soft` without its spring: for each point in turn, with the effective mass m of its direction and the
velocity u of B against A,

    friction      l_T <- project onto the disc of radius mu l_N:  l_T - m_T u_T
    normal        l_N <- max(l_N - m_N (u_N + max(s, 0) / h), 0)     s > 0: a gap may close, not more
    restitution   l_N <- max(l_N - m_N (u_N + e u_before), 0)        for points that struck
    position      p   <- max(p - m_N (w_N + beta (s + slop) / h), 0)   pseudo-velocities w, forgotten after the move

and each change of an impulse goes into the velocities at once. Sweeps go through the contacts forwards and backwards in turn:
always in one order, from the ground up, a stack of ten boxes keeps swaying at 7 cm/s. The slop is a depth left alone, so that
contacts last; without it such a stack rattles at 1 cm/s, as sweeps that end too early part what they should hold. Soft
sub-stepped contact has a spring where this has the pseudo-velocities.

Source: Catto, Iterative Dynamics with Temporal Coherence, GDC 2005 (accumulated impulses, warm start); Catto, Fast and Simple
Physics using Sequential Impulses, GDC 2006 (split impulse); Jean, Comput. Methods Appl. Mech. Eng. 177, 1999 (cone); Saad,
Iterative Methods for Sparse Linear Systems, 2003, section 4.1 (symmetric Gauss-Seidel).
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.semi_implicit_euler import turn_inertia
from plumbline.engine.maths.rows import Floats, Vec, load3, load4, store3, store4
from plumbline.engine.maths.vec import add, axpy, cross, dot, quat_turn, scale, sub, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Contacts
from plumbline.engine.respond.centre import Motion, Pair, motion_of, pair_of, store_motion
from plumbline.engine.respond.soft import sweep
from plumbline.engine.respond.softness import Softness

BAUMGARTE = 0.2
"""Share of a depth [1] that one position correction works off; Baumgarte's, here on pseudo-velocities."""


@kernel
def sweep_both_ways(bodies: Bodies, contacts: Contacts, h: float, aim: int, sweeps: int) -> None:
    """Sweep forwards and backwards in turn, without springs. Args: aim: PRESS or REBOUND."""
    for k in range(sweeps):
        sweep(bodies, contacts, Softness(h, 0.0, 1.0, 0.0, 0.0, k % 2), aim)


@kernel
def push(pair: Pair, arm_a: Vec, arm_b: Vec, impulse: Vec, motion: Motion) -> Motion:
    """The velocities after an impulse on B and its reaction on A."""
    return Motion(
        axpy(-pair.mass_a, impulse, motion.va),
        sub(motion.wa, sym_vec(pair.inertia_a, cross(arm_a, impulse))),
        axpy(pair.mass_b, impulse, motion.vb),
        add(motion.wb, sym_vec(pair.inertia_b, cross(arm_b, impulse))),
    )


@kernel
def velocity_at(arm_a: Vec, arm_b: Vec, motion: Motion) -> Vec:
    """The velocity [m/s] of B against A where both arms end."""
    return sub(add(motion.vb, cross(motion.wb, arm_b)), add(motion.va, cross(motion.wa, arm_a)))


@kernel
def push_apart(bodies: Bodies, contacts: Contacts, pseudo: Floats, h: float, sweeps: int, slop: float) -> bool:
    """Work off depths by pseudo-velocities, kept in `pseudo` (bodies + 1, 13), that last for this one move of h seconds.

    Args: slop [m]: the depth that is left. Returns: whether anything was deep enough to move.
    """
    state, manifold, point, key = bodies.state, contacts.manifold, contacts.point, contacts.key
    rows = state.shape[0]
    deep = False
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            point[i, at.PUSH] = 0.0
            deep = deep or point[i, at.SEPARATION] < -slop
    if not deep:
        return False
    for b in range(rows):
        store3(pseudo, b, at.V, (0.0, 0.0, 0.0))
        store3(pseudo, b, at.W, (0.0, 0.0, 0.0))
    for _ in range(sweeps):
        for rank in range(len(contacts.order)):
            m = contacts.order[rank, 0]
            a, b = key[m, at.BODY_A], key[m, at.BODY_B]
            n = load3(manifold, m, at.NORMAL)
            pair, motion = pair_of(bodies.body, bodies.turned, a, b), motion_of(pseudo, a, b)
            for i in range(4 * m, 4 * m + key[m, at.POINTS]):
                s, before = point[i, at.SEPARATION], point[i, at.PUSH]
                if s > -slop and before == 0.0:
                    continue
                ra, rb = load3(point, i, at.ARM_A), load3(point, i, at.ARM_B)
                speed = dot(n, velocity_at(ra, rb, motion))
                after = max(before - point[i, at.NORMAL_MASS] * (speed + BAUMGARTE * min(s + slop, 0.0) / h), 0.0)
                point[i, at.PUSH] = after
                motion = push(pair, ra, rb, scale(after - before, n), motion)
            store_motion(pseudo, a, b, motion)
    for b in range(rows - 1):
        if bodies.kind[b, at.MOTION] == at.DYNAMIC:
            store3(state, b, at.P, axpy(h, load3(pseudo, b, at.V), load3(state, b, at.P)))
            store4(state, b, at.Q, quat_turn(load4(state, b, at.Q), load3(pseudo, b, at.W), h))
            turn_inertia(state, bodies.body, bodies.turned, b)
    return True
