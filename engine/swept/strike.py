"""What happens at an instant: bodies put on their paths, and the impulses of a blow.

The blow is one set of impulses for all contacts of the world, by sequential impulses: first without restitution, then, where a
point approached faster than resting contacts do, towards the velocity u = -e u_before. The impulses that contacts bring from
their last step do not act, and are kept for the next.

Source: Moreau, Unilateral Contact and Dry Friction in Finite Freedom Dynamics, 1988 (one impact law for all contacts).
"""

from plumbline.engine.compile.jit import entry
from plumbline.engine.contact.find_contacts import find_contacts
from plumbline.engine.integrate.semi_implicit_euler import angular_momentum, turn_inertia
from plumbline.engine.maths.rows import Floats, Ints, load3, load6, store3, store4
from plumbline.engine.maths.vec import add, cross, dot, sub, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DONE
from plumbline.engine.memory.tables import bodies_of, present_contacts
from plumbline.engine.respond.sequential_impulses import sweep_both_ways
from plumbline.engine.respond.softness import PRESS, REBOUND, slow_approach
from plumbline.engine.respond.substep import bounce, end_step, end_substep
from plumbline.engine.swept.begin import touch_gap
from plumbline.engine.swept.path import body_at

AT_ONCE = 1e-12
"""A time [s] within which no gap can close."""


@entry
def place_bodies(floats: Floats, ints: Ints, path: Floats, time: float) -> None:
    """Put every body that moves where its path is at this time; each keeps its angular momentum."""
    state, body = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.BODY)
    turned = floats_of(floats, ints, at.TURNED)
    kind, count = ints_of(ints, at.BODY_KIND), ints_of(ints, at.COUNT)
    for b in range(count[0, at.BODIES]):
        if kind[b, at.MOTION] == at.STATIC:
            continue
        momentum = angular_momentum(state, body, b)
        p, q = body_at(path, b, time)
        store3(state, b, at.P, p)
        store4(state, b, at.Q, q)
        if kind[b, at.MOTION] == at.DYNAMIC:
            turn_inertia(state, body, turned, b)
            if count[0, at.GYROSCOPIC] == 1:
                store3(state, b, at.W, sym_vec(load6(turned, b, 0), momentum))


@entry
def strike(floats: Floats, ints: Ints, sweeps: int) -> int:
    """Find the contacts of this instant and resolve their blows. Args: sweeps: of each kind. Returns: as `find_contacts`."""
    status = find_contacts(floats, ints)
    if status != DONE:
        return status
    bodies, contacts = bodies_of(floats, ints), present_contacts(floats, ints)
    state, manifold, point, key = bodies.state, contacts.manifold, contacts.point, contacts.key
    kept, kept_point = floats_of(floats, ints, at.OLD_MANIFOLD), floats_of(floats, ints, at.OLD_POINT)
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    n = count[0, at.MANIFOLDS]
    slow, touch = slow_approach(setting, setting[0, at.WHOLE_STEP] / count[0, at.SUBSTEPS]), touch_gap(setting)
    none = (0.0, 0.0, 0.0)
    for m in range(n):
        a, b = key[m, at.BODY_A], key[m, at.BODY_B]
        va, wa, vb, wb = load3(state, a, at.V), load3(state, a, at.W), load3(state, b, at.V), load3(state, b, at.W)
        store3(kept, m, at.SPIN_IMPULSE, load3(manifold, m, at.SPIN_IMPULSE))
        store3(manifold, m, at.SPIN_IMPULSE, none)
        key[m, at.STRIKES] = 0
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            kept_point[i, at.NORMAL_IMPULSE] = point[i, at.NORMAL_IMPULSE]
            store3(kept_point, i, at.TANGENT_IMPULSE, load3(point, i, at.TANGENT_IMPULSE))
            point[i, at.NORMAL_IMPULSE], point[i, at.HELD], point[i, at.HELD + 1] = 0.0, 0.0, 0.0
            ra, rb = load3(point, i, at.ARM_A), load3(point, i, at.ARM_B)
            u = dot(load3(manifold, m, at.NORMAL), sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra))))
            if point[i, at.SEPARATION] <= touch:
                point[i, at.SEPARATION], point[i, at.APPROACH] = 0.0, u
                if u < -slow:
                    key[m, at.STRIKES], point[i, at.STRUCK] = 1, 1.0
    sweep_both_ways(bodies, contacts, AT_ONCE, PRESS, sweeps)
    if bounce(contacts):
        sweep_both_ways(bodies, contacts, AT_ONCE, REBOUND, sweeps)
    end_substep(contacts)
    end_step(contacts)
    for m in range(n):
        store3(manifold, m, at.SPIN_IMPULSE, load3(kept, m, at.SPIN_IMPULSE))
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            point[i, at.NORMAL_IMPULSE] = kept_point[i, at.NORMAL_IMPULSE]
            store3(point, i, at.TANGENT_IMPULSE, load3(kept_point, i, at.TANGENT_IMPULSE))
    return DONE
