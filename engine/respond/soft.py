"""Sub-stepped, soft, warm-started sequential impulses with a circular friction cone.

In each sub-step h: kick; warm start; sweeps with the soft position error; drift; sweeps without it (relax); restitution.
A contact is a spring-damper of `hertz` and `damping_ratio` taken implicitly:

    a1 = 2 zeta + h omega,  a2 = h omega a1,  a3 = 1 / (1 + a2),
    bias rate = omega / a1,  mass scale = a2 a3,  impulse scale = a3

Friction is one vector per point in the tangent plane, projected onto the disc of radius mu times the present normal impulse; no
direction is preferred. While a manifold sticks the disc has mu_static, once its whole disc is used up it slips under
mu_kinetic.

All points of a manifold see one relative motion of its two bodies, six numbers: V of B against A at the manifold's centre and
W = w_B - w_A, in its frame (t1, t2, n). A sweep takes these six into registers, works through the points on them alone, by
(V, W) += M (force, moment) after each impulse, and gives the sum to the bodies:

    normal velocity at (x, y)        V3 + y W1 - x W2
    tangential velocity at (x, y)    V1 - y W3, V2 + x W3

M, six by six, is taken at the start of the step, as are the effective masses; the velocities themselves are always exact.

`softness` has the spring, `mobility` M, `arms` the places of the points, `substep` all that is no sweep.

Source: Catto, Solver2D, 2024 (TGS Soft); Jean, Comput. Methods Appl. Mech. Eng. 177, 1999 (cone); Featherstone, Rigid Body
Dynamics Algorithms, 2008, section 2.4 (motion and force as six-vectors).
"""

import math

from plumbline.engine.compile.jit import inlined, kernel
from plumbline.engine.maths.floats import fma
from plumbline.engine.maths.rows import Vec, load3, load6, load9
from plumbline.engine.maths.vec import add, axpy, mat_vec, sym_vec, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Contacts
from plumbline.engine.respond.centre import Centre, frame_of, give_impulse, motion_of, pair_of, relative_motion
from plumbline.engine.respond.friction import friction_point, roll, static_friction
from plumbline.engine.respond.softness import PRESS, REBOUND, Softness


@inlined
def resist(contacts: Contacts, m: int, v: Vec, w: Vec, soft: Softness, aim: int) -> tuple[Vec, Vec]:
    """What manifold m gives against the relative motion (V, W) at its centre. Args: as `sweep`. Returns: force and moment."""
    moment = roll(contacts, m, w)
    return resist_at(contacts, m, (4 * m, 4 * m + contacts.key[m, at.POINTS]), (v, w), moment, soft, aim)


@inlined
def resist_at(
    contacts: Contacts, m: int, points: tuple[int, int], motion: tuple[Vec, Vec], moment: Vec, soft: Softness, aim: int
) -> tuple[Vec, Vec]:
    """What some points of manifold m, one after the other, give against the relative motion (V, W) at its centre.

    Args: points: their first and end; moment: that was given against (V, W) already. Returns: force and moment, with it.
    """
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    normals, tangents = load6(manifold, m, at.NORMAL_BLOCK), load6(manifold, m, at.TANGENT_BLOCK)
    coupling = load9(manifold, m, at.COUPLING)
    first, end = points
    v, w = motion
    pressed, rubbed = (0.0, moment[0], moment[1]), (0.0, 0.0, moment[2])
    lift, slide = (v[2], w[0], w[1]), (v[0], v[1], w[2])
    if manifold[m, at.LAW + 3] > 0.0 or manifold[m, at.LAW + 4] > 0.0:
        lift = add(add(lift, sym_vec(normals, pressed)), tmat_vec(coupling, rubbed))
        slide = add(add(slide, sym_vec(tangents, rubbed)), mat_vec(coupling, pressed))
    friction = manifold[m, at.LAW] if key[m, at.SLIPS] == 0 else manifold[m, at.LAW + 1]
    for half in range(2):
        if (half == 0) != (aim == PRESS):
            f, m1, m2 = 0.0, 0.0, 0.0
            for k in range(first, end):
                i = first + end - 1 - k if soft.backwards == 1 else k
                s, before = point[i, at.SEPARATION], point[i, at.NORMAL_IMPULSE]
                bias, hard, keep = 0.0, 1.0, 0.0
                if aim == PRESS:
                    if s > 0.0:
                        bias = s / soft.h
                    else:
                        bias, hard, keep = max(soft.bias_rate * s, -soft.max_push), soft.mass_scale, soft.impulse_scale
                elif s > 0.0 and before == 0.0:
                    continue
                elif aim == REBOUND and point[i, at.STRUCK] == 1.0 and point[i, at.SPIKE] > 0.0:
                    bias = manifold[m, at.LAW + 2] * point[i, at.APPROACH]
                x, y, mass = point[i, at.SPREAD], point[i, at.SPREAD + 1], hard * point[i, at.NORMAL_MASS]
                u = fma(-x, lift[2], fma(y, lift[1], lift[0]))
                impulse = max(fma(-mass, u, (1.0 - keep) * before - mass * bias), 0.0)
                point[i, at.NORMAL_IMPULSE] = impulse
                if key[m, at.STRIKES] == 1:
                    point[i, at.SPIKE] = max(point[i, at.SPIKE], impulse)
                change, by_it = impulse - before, sym_vec(normals, (1.0, y, -x))
                lift = axpy(impulse, by_it, axpy(-before, by_it, lift))
                f, m1, m2 = f + change, fma(y, change, m1), fma(-x, change, m2)
            pressed = add(pressed, (f, m1, m2))
            if half == 0:
                slide = add(slide, mat_vec(coupling, (f, m1, m2)))
        elif friction > 0.0:
            f1, f2, m3 = math.inf, 0.0, 0.0
            if end - first == key[m, at.POINTS]:
                f1, f2, m3 = static_friction(manifold, m, slide, friction, first, end, point)
            if f1 == math.inf:
                f1, f2, m3 = friction_point(tangents, slide, friction, first, end, soft.backwards, point)
            rubbed = add(rubbed, (f1, f2, m3))
            if half == 0:
                lift = add(lift, tmat_vec(coupling, (f1, f2, m3)))
    return (rubbed[0], rubbed[1], pressed[0]), (pressed[1], pressed[2], rubbed[2])


@kernel
def sweep(bodies: Bodies, contacts: Contacts, soft: Softness, aim: int) -> None:
    """One sweep over the manifolds: rolling and torsional friction, then friction and normal.

    While the position error is corrected the normal comes last, since it matters most; in the relaxing sweeps friction does,
    so that it ends on the cone of the final normal impulse.

    Args: aim: PRESS to correct the position error; RELAX not to, then points that gave no impulse stay out; REBOUND to aim at
    the velocity after restitution instead.
    """
    manifold, key = contacts.manifold, contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[len(contacts.order) - 1 - rank if soft.backwards == 1 else rank, 0]
        a, b = key[m, at.BODY_A], key[m, at.BODY_B]
        frame = frame_of(manifold, m)
        pair, motion = pair_of(bodies.body, bodies.turned, a, b), motion_of(bodies.state, a, b)
        centre = Centre(frame, load3(manifold, m, at.CENTRE_A), load3(manifold, m, at.CENTRE_B))
        v, w = relative_motion(centre, motion)
        force, moment = resist(contacts, m, v, w, soft, aim)
        give_impulse(bodies.state, pair, centre, motion, force, moment)
