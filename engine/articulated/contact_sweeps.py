"""What contacts do where their bodies hang on others: the mobility of each manifold, and sweeps that reach all its trees touch.

Impulses at the centre of a manifold change the relative motion there by M = J G J^T. J takes the velocities of both bodies to
the relative motion at the centre in its frame. Trees leave directions in which nothing moves, a hinge's link all but one; there
M has what a share of the bodies' own mobility gives, so that friction has an inverse to work with, and a normal along which no
motion of the tree opens the gap carries nothing. What a manifold gives in a sweep is what `engine.respond.soft` finds on M; it
is handed to the places of its bodies.

Source: Khatib, A unified approach for motion and force control of robot manipulators: the operational space formulation, IEEE
J. Robotics Automation 3, 1987; Featherstone, Rigid Body Dynamics Algorithms, 2008, section 11.5 (contact).
"""

from typing import Final

from plumbline.engine.articulated.responses import LINK, NOWHERE, Touched, change_of, give
from plumbline.engine.articulated.spatial import STILL
from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.joint_rows import AXES
from plumbline.engine.maths.rows import Floats, Vec, store6, store9
from plumbline.engine.maths.vec import add, cross, neg, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Contacts
from plumbline.engine.respond.centre import Centre, Motion, centre_of, motion_of, relative_motion
from plumbline.engine.respond.mobility import write_masses
from plumbline.engine.respond.soft import resist
from plumbline.engine.respond.softness import Softness
from plumbline.engine.respond.substep import kept_impulse

SHARE: Final = 1e-6
"""Of the bodies' own mobility, which M has more than it should: a foot under a robot leaves a thousand times as much of it."""


@kernel
def answer(touched: Touched, a: int, b: int, centre: Centre, force: Vec, moment: Vec) -> tuple[Vec, Vec]:
    """The change of the relative motion at the centre by force and moment there, in the frame. Args: a, b: places."""
    f, t = tmat_vec(centre.frame, force), tmat_vec(centre.frame, moment)
    on_a, on_b = neg(add(cross(centre.arm_a, f), t)), add(cross(centre.arm_b, f), t)
    va, wa = change_of(touched, a, a, neg(f), on_a)
    vb, wb = change_of(touched, b, b, f, on_b)
    v, w = change_of(touched, a, b, f, on_b)
    va, wa = add(va, v), add(wa, w)
    v, w = change_of(touched, b, a, neg(f), on_a)
    return relative_motion(centre, Motion(va, wa, add(vb, v), add(wb, w)))


@kernel
def own_mobility(body: Floats, a: int, b: int) -> tuple[float, float]:
    """What the two bodies alone would give way, by force [1/kg] and by moment [1/(kg m2)]."""
    turning = 0.0
    for c in range(3):
        turning += body[a, at.INV_INERTIA + c] + body[b, at.INV_INERTIA + c]
    return body[a, at.INV_MASS] + body[b, at.INV_MASS], turning / 3.0


@kernel
def write_mobility(bodies: Bodies, contacts: Contacts, touched: Touched, m: int) -> None:
    """The blocks of M of manifold m, and the effective masses of its points."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    a, b = touched.place[key[m, at.BODY_A]], touched.place[key[m, at.BODY_B]]
    centre = centre_of(manifold, m)
    v1, w1 = answer(touched, a, b, centre, AXES[0], STILL)
    v2, w2 = answer(touched, a, b, centre, AXES[1], STILL)
    v3, w3 = answer(touched, a, b, centre, AXES[2], STILL)
    _, x1 = answer(touched, a, b, centre, STILL, AXES[0])
    _, x2 = answer(touched, a, b, centre, STILL, AXES[1])
    _, x3 = answer(touched, a, b, centre, STILL, AXES[2])
    shift, turn = own_mobility(bodies.body, key[m, at.BODY_A], key[m, at.BODY_B])
    s, t = SHARE * shift, SHARE * turn
    store6(manifold, m, at.NORMAL_BLOCK, (v3[2] + s, x1[0] + t, x2[1] + t, w3[0], w3[1], x1[1]))
    store6(manifold, m, at.TANGENT_BLOCK, (v1[0] + s, v2[1] + s, x3[2] + t, v1[1], w1[2], w2[2]))
    # Rows V1, V2, W3 by the forces along V3, W1 and W2; M is symmetric.
    store9(manifold, m, at.COUPLING, (v1[2], w1[0], w1[1], v2[2], w2[0], w2[1], w3[2], x3[0], x3[1]))
    write_masses(contacts, m)
    for i in range(4 * m, 4 * m + key[m, at.POINTS]):
        x, y = point[i, at.SPREAD], point[i, at.SPREAD + 1]
        if point[i, at.NORMAL_MASS] * (s + t * (x * x + y * y)) > 0.5:
            point[i, at.NORMAL_MASS] = 0.0


@kernel
def write_mobilities(bodies: Bodies, contacts: Contacts, touched: Touched) -> None:
    """The blocks of M of all manifolds, by the responses at hand."""
    for rank in range(len(contacts.order)):
        write_mobility(bodies, contacts, touched, contacts.order[rank, 0])


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
    return Softness(soft.h, soft.bias_rate, 1.0 - forgotten, forgotten, soft.max_push, soft.backwards)


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
