"""The sub-stepped soft contact solver for spheres, whose arms lie along the normal: no impulse along it turns anything.

With n from A to B and arms l_A n and -l_B n, the velocity of B's surface against A's is

    v_B - v_A - (l_A w_A + l_B w_B) x n

and an impulse t at right angles to n turns A by -I_A^-1 l_A (n x t) and B by -I_B^-1 l_B (n x t). Between two spheres the
normal is taken anew in each sub-step, so that both arms lead to one place and angular momentum is kept. The law of the contact
is that of `soft`.

Source: Catto, Solver2D, 2024 (TGS Soft).
"""

import math

from engine.compile.jit import inlined, kernel
from engine.maths.vec import Floats, Ints, Vec, add, axpy, cross, dot, load3, norm, scale, store3, sub
from engine.memory.arena import (
    GRAVITY,
    K_BODY_A,
    K_BODY_B,
    K_MOVES,
    K_ROUND,
    K_SLIPS,
    M_INV_INERTIA,
    M_INV_MASS,
    R_APPROACH,
    R_KINETIC,
    R_RESTITUTION,
    R_SPIKE,
    R_STATIC,
    R_STRUCK,
    R_SUM,
    T_BASE,
    T_FRICTION,
    T_GAP,
    T_NORMAL,
    T_NORMAL_MASS,
    T_RADIUS_A,
    T_RADIUS_B,
    T_TANGENT,
    T_TANGENT_MASS,
    P,
)  # fmt: skip
from engine.respond.soft import STUCK, TOUCHING

__all__ = ["close_substep", "note_strikes", "press_spheres", "push_again", "relax_spheres", "turn_normals"]


@inlined
def slip_of(va: Vec, wa: Vec, la: float, vb: Vec, wb: Vec, lb: float, n: Vec) -> Vec:
    """The tangential velocity of B's surface against A's [m/s]."""
    way = sub(sub(vb, va), cross(axpy(la, wa, scale(lb, wb)), n))
    return axpy(-dot(n, way), n, way)


@kernel
def note_strikes(
    touches: int, touch: Floats, rest: Floats, key: Ints, mover: Floats, setting: Floats, h: float, slow: float
) -> int:
    """As `contact_solver.approach`: note what is about to strike, and drop impulses that are no guess for a blow."""
    g, strikes = load3(setting, 0, GRAVITY), 0
    for t in range(touches):
        n, gap = load3(touch, t, 0), touch[t, T_GAP]
        way = sub(load3(mover, key[t, K_BODY_B], 0), load3(mover, key[t, K_BODY_A], 0))
        u = dot(n, way)
        rest[t, R_STRUCK] = 0.0
        if u < -slow and gap < -u * h * (1.0 + TOUCHING):
            strikes += 1
            share = min(max(gap / (-u * h), 0.0), 1.0)
            rest[t, R_STRUCK] = 1.0
            store3(rest, t, R_APPROACH, axpy((1.0 - share) * h * (0.0 if key[t, K_MOVES] == 1 else 1.0), g, way))
            touch[t, T_NORMAL] = 0.0
            store3(touch, t, T_TANGENT, (0.0, 0.0, 0.0))
    return strikes


@kernel
def push_again(touches: int, touch: Floats, key: Ints, mover: Floats) -> None:
    """Apply the impulses of the last sub-step."""
    for t in range(touches):
        a, b, n = key[t, K_BODY_A], key[t, K_BODY_B], load3(touch, t, 0)
        tangent, half = load3(touch, t, T_TANGENT), 0.5 * touch[t, T_GAP]
        impulse, turn = axpy(touch[t, T_NORMAL], n, tangent), cross(n, tangent)
        store3(mover, a, 0, axpy(-mover[a, M_INV_MASS], impulse, load3(mover, a, 0)))
        store3(mover, a, 3, axpy(-mover[a, M_INV_INERTIA] * (touch[t, T_RADIUS_A] + half), turn, load3(mover, a, 3)))
        if key[t, K_MOVES] == 1:
            store3(mover, b, 0, axpy(mover[b, M_INV_MASS], impulse, load3(mover, b, 0)))
            store3(mover, b, 3, axpy(-mover[b, M_INV_INERTIA] * (touch[t, T_RADIUS_B] + half), turn, load3(mover, b, 3)))


@kernel
def turn_normals(
    touches: int, touch: Floats, rest: Floats, key: Ints, mover: Floats, state: Floats, striking: int
) -> None:  # fmt: skip
    """Normals and gaps at the present places; friction is turned along with its normal.

    So is the impulse of a blow, with what it did to the velocities: the whole of it has then the direction that the rebound
    is measured along. A blow at the angle of an earlier place gives energy, in proportion to the time step.

    Args: striking: 1 where some law has restitution.
    """
    for t in range(touches):
        pa = load3(state, key[t, K_BODY_A], P)
        if key[t, K_ROUND] == 1:
            d = sub(load3(state, key[t, K_BODY_B], P), pa)
            length = norm(d)
            touch[t, T_GAP] = length - touch[t, T_RADIUS_A] - touch[t, T_RADIUS_B]
            if length > 1e-300:
                n, tangent = scale(1.0 / length, d), load3(touch, t, T_TANGENT)
                if striking == 1 and rest[t, R_STRUCK] == 1.0:
                    a, b = key[t, K_BODY_A], key[t, K_BODY_B]
                    turn = scale(touch[t, T_NORMAL], sub(n, load3(touch, t, 0)))
                    store3(mover, a, 0, axpy(-mover[a, M_INV_MASS], turn, load3(mover, a, 0)))
                    if key[t, K_MOVES] == 1:
                        store3(mover, b, 0, axpy(mover[b, M_INV_MASS], turn, load3(mover, b, 0)))
                store3(touch, t, 0, n)
                store3(touch, t, T_TANGENT, axpy(-dot(n, tangent), n, tangent))
        else:
            touch[t, T_GAP] = touch[t, T_BASE] - dot(load3(touch, t, 0), pa)


@inlined
def rub(
    va: Vec, wa: Vec, vb: Vec, wb: Vec, ma: float, ia: float, la: float, mb: float, ib: float, lb: float, n: Vec, held: Vec,
    mass: float, most: float,
) -> tuple[Vec, Vec, Vec, Vec, Vec]:  # fmt: skip
    """Friction that stops the slip, or else is as large as it may be. Returns: its impulse and the four velocities after it."""
    after = axpy(-mass, slip_of(va, wa, la, vb, wb, lb, n), held)
    size = dot(after, after)
    if size > most * most:
        after = scale(most / math.sqrt(size), after)
    change = sub(after, held)
    turn = cross(n, change)
    return after, axpy(-ma, change, va), axpy(-ia * la, turn, wa), axpy(mb, change, vb), axpy(-ib * lb, turn, wb)


@kernel
def press_spheres(
    touches: int, touch: Floats, rest: Floats, key: Ints, mover: Floats, h: float, bias_rate: float, mass_scale: float,
    impulse_scale: float, max_push: float, striking: int,
) -> None:  # fmt: skip
    """One sweep that corrects positions, as `contact_solver.sweep` while soft: friction and then the normal of each contact.

    Args: striking: 1 where some law has restitution.
    """
    for t in range(touches):
        a, b, n = key[t, K_BODY_A], key[t, K_BODY_B], load3(touch, t, 0)
        s, before = touch[t, T_GAP], touch[t, T_NORMAL]
        va, wa, vb, wb = load3(mover, a, 0), load3(mover, a, 3), load3(mover, b, 0), load3(mover, b, 3)
        ma, ia, mb, ib = mover[a, M_INV_MASS], mover[a, M_INV_INERTIA], mover[b, M_INV_MASS], mover[b, M_INV_INERTIA]
        held = load3(touch, t, T_TANGENT)
        if before > 0.0 or dot(held, held) > 0.0:
            la, lb = touch[t, T_RADIUS_A] + 0.5 * s, touch[t, T_RADIUS_B] + 0.5 * s
            after, va, wa, vb, wb = rub(
                va, wa, vb, wb, ma, ia, la, mb, ib, lb, n, held, touch[t, T_TANGENT_MASS], touch[t, T_FRICTION] * before
            )
            store3(touch, t, T_TANGENT, after)
        bias, hard, keep = s / h, 1.0, 0.0
        if s <= 0.0:
            bias, hard, keep = max(bias_rate * s, -max_push), mass_scale, impulse_scale
        impulse = max(before - touch[t, T_NORMAL_MASS] * hard * (dot(n, sub(vb, va)) + bias) - keep * before, 0.0)
        touch[t, T_NORMAL] = impulse
        if striking == 1:
            rest[t, R_SPIKE] = max(rest[t, R_SPIKE], impulse)
        store3(mover, a, 0, axpy(ma * (before - impulse), n, va))
        store3(mover, a, 3, wa)
        if key[t, K_MOVES] == 1:
            store3(mover, b, 0, axpy(mb * (impulse - before), n, vb))
            store3(mover, b, 3, wb)


@kernel
def relax_spheres(
    touches: int, touch: Floats, rest: Floats, key: Ints, mover: Floats, bouncing: int, striking: int
) -> None:  # fmt: skip
    """One sweep without the position error, as `contact_solver.sweep` while not soft: the normal and then friction.

    Args: bouncing: 1 to give struck contacts their rebound. striking: 1 where some law has restitution.
    """
    for t in range(touches):
        s, before = touch[t, T_GAP], touch[t, T_NORMAL]
        if s > 0.0 and before == 0.0:
            continue
        a, b, n = key[t, K_BODY_A], key[t, K_BODY_B], load3(touch, t, 0)
        va, wa, vb, wb = load3(mover, a, 0), load3(mover, a, 3), load3(mover, b, 0), load3(mover, b, 3)
        ma, ia, mb, ib = mover[a, M_INV_MASS], mover[a, M_INV_INERTIA], mover[b, M_INV_MASS], mover[b, M_INV_INERTIA]
        bias = 0.0
        if bouncing == 1 and rest[t, R_STRUCK] == 1.0 and rest[t, R_SPIKE] > 0.0:
            bias = rest[t, R_RESTITUTION] * min(dot(n, load3(rest, t, R_APPROACH)), 0.0)
        impulse = max(before - touch[t, T_NORMAL_MASS] * (dot(n, sub(vb, va)) + bias), 0.0)
        va, vb = axpy(ma * (before - impulse), n, va), axpy(mb * (impulse - before), n, vb)
        held = load3(touch, t, T_TANGENT)
        if impulse > 0.0 or dot(held, held) > 0.0:
            la, lb = touch[t, T_RADIUS_A] + 0.5 * s, touch[t, T_RADIUS_B] + 0.5 * s
            after, va, wa, vb, wb = rub(
                va, wa, vb, wb, ma, ia, la, mb, ib, lb, n, held, touch[t, T_TANGENT_MASS], touch[t, T_FRICTION] * impulse
            )
            store3(touch, t, T_TANGENT, after)
        touch[t, T_NORMAL] = impulse
        if striking == 1:
            rest[t, R_SPIKE] = max(rest[t, R_SPIKE], impulse)
        store3(mover, a, 0, va)
        store3(mover, a, 3, wa)
        if key[t, K_MOVES] == 1:
            store3(mover, b, 0, vb)
            store3(mover, b, 3, wb)


@kernel
def close_substep(touches: int, touch: Floats, rest: Floats, key: Ints, mover: Floats, striking: int) -> None:
    """Sum up the impulses, and let contacts that use up their static disc slip, and slipping ones that it can stop stick.

    Args: striking: 1 to drop the impulses of blows, which do not last.
    """
    for t in range(touches):
        n, normal, held = load3(touch, t, 0), touch[t, T_NORMAL], load3(touch, t, T_TANGENT)
        if normal == 0.0 and dot(held, held) == 0.0:
            continue
        store3(rest, t, R_SUM, add(load3(rest, t, R_SUM), axpy(normal, n, held)))
        room = rest[t, R_STATIC] * normal
        if room > 0.0:
            needed = held
            if key[t, K_SLIPS] == 1:
                a, b, half = key[t, K_BODY_A], key[t, K_BODY_B], 0.5 * touch[t, T_GAP]
                la, lb = touch[t, T_RADIUS_A] + half, touch[t, T_RADIUS_B] + half
                va, wa, vb, wb = load3(mover, a, 0), load3(mover, a, 3), load3(mover, b, 0), load3(mover, b, 3)
                needed = axpy(-touch[t, T_NORMAL_MASS], slip_of(va, wa, la, vb, wb, lb, n), held)
            key[t, K_SLIPS] = 1 if dot(needed, needed) >= STUCK * STUCK * room * room else 0
            touch[t, T_FRICTION] = rest[t, R_STATIC] if key[t, K_SLIPS] == 0 else rest[t, R_KINETIC]
        if striking == 1:
            if rest[t, R_STRUCK] == 1.0:
                touch[t, T_NORMAL] = 0.0
                store3(touch, t, T_TANGENT, (0.0, 0.0, 0.0))
            rest[t, R_SPIKE] = 0.0
