"""The sub-stepped soft contact solver for spheres, whose arms lie along the normal: no impulse along it turns anything.

With n from A to B and arms l_A n and -l_B n, the velocity of B's surface against A's is

    v_B - v_A - (l_A w_A + l_B w_B) x n

and an impulse t at right angles to n turns A by -I_A^-1 l_A (n x t) and B by -I_B^-1 l_B (n x t). Between two spheres the
normal is taken anew in each sub-step, so that both arms lead to one place and angular momentum is kept. The law of the contact
is that of `soft`. Sweeps go over the contacts first..end - 1.

Source: Catto, Solver2D, 2024 (TGS Soft).
"""

import math
from typing import NamedTuple

from plumbline.engine.compile.jit import inlined, kernel
from plumbline.engine.maths.elementary import exp
from plumbline.engine.maths.floats import fma
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load4, store3, store4
from plumbline.engine.maths.vec import axpy, cross, dot, norm, quat_spin, quat_unit, scale, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.tables import Bodies
from plumbline.engine.respond.centre import Motion
from plumbline.engine.respond.softness import REBOUND, STUCK, TOUCHING, Softness


class Touches(NamedTuple):
    """The contacts of spheres: what a sweep reads, what it needs less often, their keys, and the bodies that they move.

    Terms: elastic: 1 where some law has restitution.
    """

    touch: Floats
    rest: Floats
    key: Ints
    mover: Floats
    elastic: int


class Levers(NamedTuple):
    """Of A and B: inverse masses [1/kg], inverse inertias [1/(kg m2)], and arms [m] along the normal."""

    mass_a: float
    inertia_a: float
    arm_a: float
    mass_b: float
    inertia_b: float
    arm_b: float


@inlined
def touches_of(floats: Floats, ints: Ints) -> Touches:
    """The contacts of spheres of an arena."""
    surface = floats_of(floats, ints, at.SURFACE)
    most = 0.0
    for law in range(surface.shape[0]):
        most = max(most, surface[law, 2])
    return Touches(
        floats_of(floats, ints, at.TOUCH),
        floats_of(floats, ints, at.TOUCH_REST),
        ints_of(ints, at.TOUCH_KEY),
        floats_of(floats, ints, at.MOVER),
        1 if most > 0.0 else 0,
    )


@inlined
def way_of(motion: Motion, arm_a: float, arm_b: float, n: Vec) -> tuple[float, Vec]:
    """The velocity of B's surface against A's [m/s]: along the normal, and the slip at right angles to it."""
    way = sub(motion.vb, motion.va)
    along = dot(n, way)
    return along, axpy(-along, n, sub(way, cross(axpy(arm_a, motion.wa, scale(arm_b, motion.wb)), n)))


@inlined
def moving(mover: Floats, a: int, b: int) -> Motion:
    """The velocities of two bodies."""
    return Motion(load3(mover, a, 0), load3(mover, a, 3), load3(mover, b, 0), load3(mover, b, 3))


@inlined
def add_to_sum(touch: Floats, t: int, share: float) -> Vec:
    """Count a share of the impulse of contact t to the step's. Returns: that impulse on B [N s]."""
    impulse = axpy(touch[t, at.T_NORMAL], load3(touch, t, 0), load3(touch, t, at.T_TANGENT))
    store3(touch, t, at.T_SUM, axpy(share, impulse, load3(touch, t, at.T_SUM)))
    return impulse


@kernel
def note_strikes(touches: Touches, count: int, setting: Floats, h: float, slow: float, counted: float) -> int:
    """As `substep.approach`: note what is about to strike, and drop impulses that are no guess for a blow.

    Args: h: the sub-step [s]; slow: the speed [m/s] up to which nothing strikes; counted: as the share of `push_again`.
    """
    touch, rest, key, mover = touches.touch, touches.rest, touches.key, touches.mover
    g, strikes = load3(setting, 0, at.GRAVITY), 0
    for t in range(count):
        n, gap = load3(touch, t, 0), touch[t, at.T_GAP]
        way = sub(load3(mover, key[t, at.K_BODY_B], 0), load3(mover, key[t, at.K_BODY_A], 0))
        u = dot(n, way)
        rest[t, at.R_STRUCK] = 0.0
        if u < -slow and gap < -u * h * (1.0 + TOUCHING):
            strikes += 1
            share = min(max(gap / (-u * h), 0.0), 1.0)
            rest[t, at.R_STRUCK] = 1.0
            store3(rest, t, at.R_APPROACH, axpy((1.0 - share) * h * (0.0 if key[t, at.K_MOVES] == 1 else 1.0), g, way))
            add_to_sum(touch, t, counted)
            touch[t, at.T_NORMAL] = 0.0
            store3(touch, t, at.T_TANGENT, (0.0, 0.0, 0.0))
    return strikes


@kernel
def push_again(touches: Touches, first: int, end: int, share: float) -> None:
    """Apply the impulses of the last sub-step, and count a share of them to the step's: 0 for those of the step before."""
    touch, key, mover = touches.touch, touches.key, touches.mover
    for t in range(first, end):
        a, b, n = key[t, at.K_BODY_A], key[t, at.K_BODY_B], load3(touch, t, 0)
        tangent, half = load3(touch, t, at.T_TANGENT), 0.5 * touch[t, at.T_GAP]
        impulse, turn = add_to_sum(touch, t, share), cross(n, tangent)
        store3(mover, a, 0, axpy(-mover[a, at.M_INV_MASS], impulse, load3(mover, a, 0)))
        store3(mover, a, 3, axpy(-mover[a, at.M_INV_INERTIA] * (touch[t, at.T_RADIUS_A] + half), turn, load3(mover, a, 3)))
        if key[t, at.K_MOVES] == 1:
            store3(mover, b, 0, axpy(mover[b, at.M_INV_MASS], impulse, load3(mover, b, 0)))
            store3(mover, b, 3, axpy(-mover[b, at.M_INV_INERTIA] * (touch[t, at.T_RADIUS_B] + half), turn, load3(mover, b, 3)))


@kernel
def turn_normals(touches: Touches, first: int, end: int, state: Floats) -> None:
    """Normals and gaps at the present places; friction is turned along with its normal.

    So is the impulse of a blow, with what it did to the velocities: the whole of it has then the direction that the rebound
    is measured along. A blow at the angle of an earlier place gives energy, in proportion to the time step.
    """
    touch, rest, key, mover = touches.touch, touches.rest, touches.key, touches.mover
    for t in range(first, end):
        pa = load3(state, key[t, at.K_BODY_A], at.P)
        if key[t, at.K_ROUND] == 1:
            d = sub(load3(state, key[t, at.K_BODY_B], at.P), pa)
            length = norm(d)
            touch[t, at.T_GAP] = length - touch[t, at.T_RADIUS_A] - touch[t, at.T_RADIUS_B]
            if length > 1e-300:
                n, tangent = scale(1.0 / length, d), load3(touch, t, at.T_TANGENT)
                if touches.elastic == 1 and rest[t, at.R_STRUCK] == 1.0:
                    a, b = key[t, at.K_BODY_A], key[t, at.K_BODY_B]
                    turn = scale(touch[t, at.T_NORMAL], sub(n, load3(touch, t, 0)))
                    store3(mover, a, 0, axpy(-mover[a, at.M_INV_MASS], turn, load3(mover, a, 0)))
                    if key[t, at.K_MOVES] == 1:
                        store3(mover, b, 0, axpy(mover[b, at.M_INV_MASS], turn, load3(mover, b, 0)))
                store3(touch, t, 0, n)
                store3(touch, t, at.T_TANGENT, axpy(-dot(n, tangent), n, tangent))
        else:
            touch[t, at.T_GAP] = touch[t, at.T_BASE] - dot(load3(touch, t, 0), pa)


@inlined
def rub(held: Vec, mass: float, slip: Vec, most: float) -> Vec:
    """The impulse of friction that stops the slip, or else is as large as it may be."""
    after = axpy(-mass, slip, held)
    square = dot(after, after)
    if square > most * most:
        after = scale(most / square * math.sqrt(square), after)
    return after


@inlined
def answer(levers: Levers, n: Vec, normal: float, change: Vec, motion: Motion) -> Motion:
    """The motion after an impulse on B along the normal and another at right angles to it [N s]."""
    impulse, turn = axpy(normal, n, change), cross(n, change)
    return Motion(
        axpy(-levers.mass_a, impulse, motion.va),
        axpy(-levers.inertia_a * levers.arm_a, turn, motion.wa),
        axpy(levers.mass_b, impulse, motion.vb),
        axpy(-levers.inertia_b * levers.arm_b, turn, motion.wb),
    )


@inlined
def uses_up(needed: Vec, room: float) -> bool:
    """Whether an impulse at right angles to the normal takes all that the static disc of this radius [N s] has."""
    return dot(needed, needed) >= STUCK * STUCK * room * room and room > 0.0


@inlined
def levers_of(touch: Floats, mover: Floats, t: int, a: int, b: int) -> Levers:
    """How two bodies answer to contact t."""
    la, lb = touch[t, at.T_RADIUS_A] + 0.5 * touch[t, at.T_GAP], touch[t, at.T_RADIUS_B] + 0.5 * touch[t, at.T_GAP]
    return Levers(
        mover[a, at.M_INV_MASS], mover[a, at.M_INV_INERTIA], la, mover[b, at.M_INV_MASS], mover[b, at.M_INV_INERTIA], lb
    )


@inlined
def store_moving(mover: Floats, a: int, b: int, moves: int, motion: Motion) -> None:
    """Put the velocities of two bodies back, of which B may be one that nothing moves."""
    store3(mover, a, 0, motion.va)
    store3(mover, a, 3, motion.wa)
    if moves == 1:
        store3(mover, b, 0, motion.vb)
        store3(mover, b, 3, motion.wb)


@kernel
def press_spheres(touches: Touches, first: int, end: int, soft: Softness) -> None:
    """One sweep that corrects positions, as `soft.sweep` does to PRESS: friction and then the normal of each contact.

    Neither changes the velocity that the other answers, so that both are taken from one.
    """
    touch, rest, key, mover = touches.touch, touches.rest, touches.key, touches.mover
    for t in range(first, end):
        a, b, n = key[t, at.K_BODY_A], key[t, at.K_BODY_B], load3(touch, t, 0)
        s, before, held = touch[t, at.T_GAP], touch[t, at.T_NORMAL], load3(touch, t, at.T_TANGENT)
        motion, levers = moving(mover, a, b), levers_of(touch, mover, t, a, b)
        along, slip = way_of(motion, levers.arm_a, levers.arm_b, n)
        bias, hard, keep = s / soft.h, 1.0, 0.0
        if s <= 0.0:
            bias, hard, keep = max(soft.bias_rate * s, -soft.max_push), soft.mass_scale, soft.impulse_scale
        impulse = max(fma(-touch[t, at.T_NORMAL_MASS] * hard, along + bias, fma(-keep, before, before)), 0.0)
        after = rub(held, touch[t, at.T_TANGENT_MASS], slip, touch[t, at.T_FRICTION] * before)
        touch[t, at.T_NORMAL] = impulse
        store3(touch, t, at.T_TANGENT, after)
        if touches.elastic == 1:
            rest[t, at.R_SPIKE] = max(rest[t, at.R_SPIKE], impulse)
        store_moving(mover, a, b, key[t, at.K_MOVES], answer(levers, n, impulse - before, sub(after, held), motion))


@kernel
def relax_spheres(touches: Touches, first: int, end: int, aim: int) -> bool:
    """One sweep without the position error, as `soft.sweep`: the normal and then friction, both from one velocity.

    Args: aim: RELAX, or REBOUND to give struck contacts their rebound.
    Returns: whether a contact that bears slips or is about to, so that `choose_friction` has to be asked.
    """
    touch, rest, key, mover = touches.touch, touches.rest, touches.key, touches.mover
    slipping = False
    for t in range(first, end):
        before = touch[t, at.T_NORMAL]
        if touch[t, at.T_GAP] > 0.0 and before == 0.0:
            continue
        a, b, n, held = key[t, at.K_BODY_A], key[t, at.K_BODY_B], load3(touch, t, 0), load3(touch, t, at.T_TANGENT)
        motion, levers = moving(mover, a, b), levers_of(touch, mover, t, a, b)
        along, slip = way_of(motion, levers.arm_a, levers.arm_b, n)
        if aim == REBOUND and rest[t, at.R_STRUCK] == 1.0 and rest[t, at.R_SPIKE] > 0.0:
            along += rest[t, at.R_RESTITUTION] * min(dot(n, load3(rest, t, at.R_APPROACH)), 0.0)
        impulse = max(fma(-touch[t, at.T_NORMAL_MASS], along, before), 0.0)
        most = touch[t, at.T_FRICTION] * impulse
        after = rub(held, touch[t, at.T_TANGENT_MASS], slip, most)
        slipping = slipping or (impulse > 0.0 and (key[t, at.K_SLIPS] == 1 or uses_up(after, most)))
        touch[t, at.T_NORMAL] = impulse
        store3(touch, t, at.T_TANGENT, after)
        if touches.elastic == 1:
            rest[t, at.R_SPIKE] = max(rest[t, at.R_SPIKE], impulse)
        store_moving(mover, a, b, key[t, at.K_MOVES], answer(levers, n, impulse - before, sub(after, held), motion))
    return slipping


@kernel
def any_struck(touches: Touches, count: int) -> bool:
    """Whether a contact with restitution was struck in this sub-step."""
    rest, struck = touches.rest, False
    for t in range(count):
        struck = struck or (rest[t, at.R_RESTITUTION] > 0.0 and rest[t, at.R_STRUCK] == 1.0 and rest[t, at.R_SPIKE] > 0.0)
    return struck


@kernel
def choose_friction(touches: Touches, count: int) -> None:
    """Let contacts that use up their static disc slip, and slipping ones that it can stop stick."""
    touch, rest, key, mover = touches.touch, touches.rest, touches.key, touches.mover
    for t in range(count):
        needed, room = load3(touch, t, at.T_TANGENT), rest[t, at.R_STATIC] * touch[t, at.T_NORMAL]
        if room > 0.0:
            if key[t, at.K_SLIPS] == 1:
                a, b, half = key[t, at.K_BODY_A], key[t, at.K_BODY_B], 0.5 * touch[t, at.T_GAP]
                la, lb = touch[t, at.T_RADIUS_A] + half, touch[t, at.T_RADIUS_B] + half
                slip = way_of(moving(mover, a, b), la, lb, load3(touch, t, 0))[1]
                needed = axpy(-touch[t, at.T_NORMAL_MASS], slip, needed)
            key[t, at.K_SLIPS] = 1 if uses_up(needed, room) else 0
            touch[t, at.T_FRICTION] = rest[t, at.R_STATIC] if key[t, at.K_SLIPS] == 0 else rest[t, at.R_KINETIC]


@kernel
def drop_blows(touches: Touches, count: int) -> None:
    """Count the impulses of blows to the step's, and drop them: they do not last."""
    touch, rest = touches.touch, touches.rest
    for t in range(count):
        if rest[t, at.R_STRUCK] == 1.0:
            add_to_sum(touch, t, 1.0)
            touch[t, at.T_NORMAL] = 0.0
            store3(touch, t, at.T_TANGENT, (0.0, 0.0, 0.0))
        rest[t, at.R_SPIKE] = 0.0


@kernel
def kick_spheres(bodies: Bodies, mover: Floats, setting: Floats, count: Ints, h: float) -> None:
    """Gravity, applied loads and damping for h seconds on all bodies in contact."""
    body, load, kind = bodies.body, bodies.load, bodies.kind
    g = load3(setting, 0, at.GRAVITY)
    for b in range(count[0, at.BODIES]):
        if kind[b, at.TOUCHED] == 1 and kind[b, at.MOTION] == at.DYNAMIC:
            v = axpy(h, axpy(mover[b, at.M_INV_MASS], load3(load, b, 0), g), load3(mover, b, 0))
            w = axpy(h * mover[b, at.M_INV_INERTIA], load3(load, b, 3), load3(mover, b, 3))
            if body[b, at.LINEAR_DAMPING] > 0.0:
                v = scale(exp(-h * body[b, at.LINEAR_DAMPING]), v)
            if body[b, at.ANGULAR_DAMPING] > 0.0:
                w = scale(exp(-h * body[b, at.ANGULAR_DAMPING]), w)
            store3(mover, b, 0, v)
            store3(mover, b, 3, w)


@kernel
def drift_spheres(bodies: Bodies, mover: Floats, count: Ints, h: float) -> None:
    """Move all bodies in contact for h seconds; `end_spheres` makes the quaternions unit."""
    state, kind = bodies.state, bodies.kind
    for b in range(count[0, at.BODIES]):
        if kind[b, at.TOUCHED] == 1 and kind[b, at.MOTION] == at.DYNAMIC:
            store3(state, b, at.P, axpy(h, load3(mover, b, 0), load3(state, b, at.P)))
            store4(state, b, at.Q, quat_spin(load4(state, b, at.Q), load3(mover, b, 3), h))


@kernel
def end_spheres(bodies: Bodies, mover: Floats, count: Ints) -> None:
    """Put the velocities of all bodies in contact back into the state."""
    state, kind = bodies.state, bodies.kind
    for b in range(count[0, at.BODIES]):
        if kind[b, at.TOUCHED] == 1 and kind[b, at.MOTION] == at.DYNAMIC:
            store4(state, b, at.Q, quat_unit(load4(state, b, at.Q)))
            store3(state, b, at.V, load3(mover, b, 0))
            store3(state, b, at.W, load3(mover, b, 3))
