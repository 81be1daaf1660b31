"""Sweeps of the soft solver over contacts whose bodies hang on others: each manifold's impulses reach all that its trees touch.

What a manifold gives is what `engine.respond.soft` finds on its mobility; here that is handed to the places of its bodies.

Source: as `engine.respond.soft`; Featherstone, Rigid Body Dynamics Algorithms, 2008, section 11.5 (contact).
"""

from typing import Final

from plumbline.engine.articulated.touched import LINK, NOWHERE, Touched, give
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Vec
from plumbline.engine.maths.vec import add, cross, neg, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Contacts
from plumbline.engine.respond.centre import Centre, centre_of, motion_of, relative_motion
from plumbline.engine.respond.soft import resist
from plumbline.engine.respond.softness import Softness
from plumbline.engine.respond.substep import kept_impulse

STIFFEST: Final = 0.249
"""Of a turn in a sub-step [1], from which on the spring of a contact is as stiff as `softness_of` lets it be, a quarter."""

BORNE: Final = 100.0
"""Times the effective mass of a point [1] that machines bear down on it with: a trunk on a foot that moves with its shank."""


@kernel
def under_machines(setting: Floats, soft: Softness) -> Softness:
    """The contact stiffness under links: scaled by the robot's weight unless set.

    A spring sinks by the load over its stiffness: g / omega^2 times what bears down over the effective mass of the point, which
    on trees are unlike by `BORNE`. With omega and the damping ratio both larger by the root of that, the stiffness is larger by
    `BORNE`, and a depth is worked off at the same pace, omega / a1. Where one loose body lies on another it is no help: sweeps
    settle stacks more slowly the less their contacts give.
    """
    if setting[0, at.HERTZ] * soft.h < STIFFEST:
        return soft
    forgotten = 1.0 / (1.0 + BORNE * soft.mass_scale / soft.impulse_scale)
    return Softness(soft.h, soft.bias_rate, 1.0 - forgotten, forgotten, soft.max_push)


@kernel
def bears_link(touched: Touched, a: int, b: int) -> bool:
    """Whether of two bodies one is a link, and the other nothing that contacts move."""
    one, other = touched.place[a], touched.place[b]
    if one == NOWHERE:
        one, other = other, one
    return bool(one != NOWHERE and other == NOWHERE and touched.kind[one, LINK] != NOWHERE)


@kernel
def give_pair(touched: Touched, state: Floats, bodies: tuple[int, int], centre: Centre, force: Vec, moment: Vec) -> None:
    """Give impulses of force and moment at the centre, in its frame, to the second body, and their reaction to the first."""
    f, t = tmat_vec(centre.frame, force), tmat_vec(centre.frame, moment)
    a, b = touched.place[bodies[0]], touched.place[bodies[1]]
    if a != NOWHERE:
        give(touched, state, a, neg(f), neg(add(cross(centre.arm_a, f), t)))
    if b != NOWHERE:
        give(touched, state, b, f, add(cross(centre.arm_b, f), t))


@kernel
def start_warm(state: Floats, contacts: Contacts, touched: Touched) -> None:
    """Apply the impulses of the last sub-step."""
    key = contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        centre = centre_of(contacts.manifold, m)
        force, moment = kept_impulse(contacts, m, centre.frame)
        give_pair(touched, state, (key[m, at.BODY_A], key[m, at.BODY_B]), centre, force, moment)


@kernel
def sweep_trees(state: Floats, contacts: Contacts, touched: Touched, soft: Softness, firm: Softness, aim: int) -> None:
    """One sweep over all manifolds. Args: as `engine.respond.soft.sweep`; firm: the softness of contacts under links."""
    manifold, key = contacts.manifold, contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        a, b = key[m, at.BODY_A], key[m, at.BODY_B]
        centre = centre_of(manifold, m)
        v, w = relative_motion(centre, motion_of(state, a, b))
        force, moment = resist(contacts, m, v, w, firm if bears_link(touched, a, b) else soft, aim)
        give_pair(touched, state, (a, b), centre, force, moment)
