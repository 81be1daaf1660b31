"""Jacobi sweeps with split masses: every point answers the velocities that were there before the sweep, and then all are given.

A body with n points of contact counts as n bodies of an n-th of its mass and inertia, one at each point. What an impulse there
does to the relative velocity is

    n_A W_A + n_B W_B,  W_A and W_B what it does by the whole bodies

A point's answer is as if its two parts were alone in the world. What all points give to a body changes its velocity by the mean
of the changes of its parts, so that no sweep overshoots however many there are. No point sees what another gives in the
same sweep: in which order contacts are found shows in the rounding of sums alone, and threads share contacts of any graph.

The spring of a contact is one of so many times a second, so that it is as soft as the parts are light: a body of n points lies
n times as deep as under Gauss-Seidel. Springs of the whole masses between the parts were tried, and a tower of ten shook: so
few sweeps do not load them.

Source: Tonge, Benevolenski, Voroshilov, Mass splitting for jitter-free parallel rigid body simulation, ACM Trans. Graph. 31(4),
2012; Saad, Iterative Methods for Sparse Linear Systems, 2003, section 4.1.
"""

from numba import prange

from plumbline.engine.compile.jit import inlined, kernel, template
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, store3
from plumbline.engine.maths.vec import add
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.tables import Bodies, Contacts, bodies_of, contacts_of, shapes_of, some_contacts
from plumbline.engine.respond.arms import refresh
from plumbline.engine.respond.centre import centre_of, give_impulse, lighter, motion_of, pair_of, relative_motion
from plumbline.engine.respond.friction import roll
from plumbline.engine.respond.prepare import weigh
from plumbline.engine.respond.soft import resist_at
from plumbline.engine.respond.softness import PUSH, TURN, Softness, softness_of
from plumbline.engine.respond.substep import kept_impulse


@kernel
def split_masses(floats: Floats, ints: Ints) -> None:
    """Effective masses of all points between the parts of the bodies; rolling and torsional friction has a part of its own."""
    bodies, contacts, parts = bodies_of(floats, ints), contacts_of(floats, ints), floats_of(floats, ints, at.START)
    n = ints_of(ints, at.COUNT)[0, at.MANIFOLDS]
    for b in range(parts.shape[0]):
        parts[b, 0] = 0.0
    for m in range(n):
        turns = contacts.manifold[m, at.LAW + 3] > 0.0 or contacts.manifold[m, at.LAW + 4] > 0.0
        more = contacts.key[m, at.POINTS] + (1 if turns else 0)
        parts[contacts.key[m, at.BODY_A], 0] += more
        parts[contacts.key[m, at.BODY_B], 0] += more
    for m in range(n):
        a, b = contacts.key[m, at.BODY_A], contacts.key[m, at.BODY_B]
        part = lighter(pair_of(bodies.body, bodies.turned, a, b), parts[a, 0], parts[b, 0])
        weigh(contacts, m, centre_of(contacts.manifold, m), part)


@inlined
def answer_of(contacts: Contacts, m: int, motion: tuple[Vec, Vec], soft: Softness, aim: int) -> tuple[Vec, Vec]:
    """What the points of manifold m give against the relative motion, each as if it were alone: force and moment."""
    moment = roll(contacts, m, motion[1])
    force = (0.0, 0.0, 0.0)
    for i in range(4 * m, 4 * m + contacts.key[m, at.POINTS]):
        f, t = resist_at(contacts, m, (i, i + 1), motion, (0.0, 0.0, 0.0), soft, aim)
        force, moment = add(force, f), add(moment, t)
    return force, moment


@kernel
def answer_lane(floats: Floats, ints: Ints, aim: int, lane: int, lanes: int) -> None:
    """Note what each contact of a lane gives, or take its points to the present poses, as `aim` says.

    Tables are carved here, since no tuple of them can be handed to a thread.
    """
    bodies, contacts, answer = bodies_of(floats, ints), contacts_of(floats, ints), floats_of(floats, ints, at.ANSWER)
    setting, n = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)[0, at.MANIFOLDS]
    soft = softness_of(setting, setting[0, at.DT] / ints_of(ints, at.COUNT)[0, at.SUBSTEPS])
    first, end = n * lane // lanes, n * (lane + 1) // lanes
    if aim == TURN:
        refresh(bodies.state, shapes_of(floats, ints), some_contacts(contacts, first, end))
        return
    for m in range(first, end):
        centre = centre_of(contacts.manifold, m)
        if aim == PUSH:
            force, moment = kept_impulse(contacts, m, centre.frame)
        else:
            motion = relative_motion(centre, motion_of(bodies.state, contacts.key[m, at.BODY_A], contacts.key[m, at.BODY_B]))
            force, moment = answer_of(contacts, m, motion, soft, aim)
        store3(answer, m, 0, force)
        store3(answer, m, 3, moment)


@kernel
def give_answers(bodies: Bodies, contacts: Contacts, answer: Floats, manifolds: int) -> None:
    """Give what was noted to the whole bodies."""
    for m in range(manifolds):
        a, b = contacts.key[m, at.BODY_A], contacts.key[m, at.BODY_B]
        pair, motion = pair_of(bodies.body, bodies.turned, a, b), motion_of(bodies.state, a, b)
        give_impulse(bodies.state, pair, centre_of(contacts.manifold, m), motion, load3(answer, m, 0), load3(answer, m, 3))


@template
def at_once(floats: Floats, ints: Ints, bodies: Bodies, contacts: Contacts, _soft: Softness, aim: int) -> None:
    """Do what `aim` says to all contacts, from one state of the world. Where there is one thread, none is sent for."""
    lanes, n = ints_of(ints, at.TALLY)[0, at.THREADS], ints_of(ints, at.COUNT)[0, at.MANIFOLDS]
    if lanes == 1:
        answer_lane(floats, ints, aim, 0, 1)
    else:
        for lane in prange(lanes):
            answer_lane(floats, ints, aim, lane, lanes)
    if aim != TURN:
        give_answers(bodies, contacts, floats_of(floats, ints, at.ANSWER), n)
