"""What happens at an instant: bodies put on their paths, and the impulses of a blow.

The blow is one set of impulses for all contacts of the world, by sequential impulses: first without restitution, then, where a
point approached faster than resting contacts do, towards the velocity u = -e u_before. The impulses that contacts bring from
their last step do not act, and are kept for the next.

Source: Moreau, Unilateral Contact and Dry Friction in Finite Freedom Dynamics, 1988 (one impact law for all contacts).
"""

from engine.compile.jit import entry
from engine.contact.find_contacts import find_contacts
from engine.integrate.semi_implicit_euler import angular_momentum, turn_inertia
from engine.maths.vec import Floats, Ints, add, cross, dot, load3, load6, store3, store4, sub, sym_vec
from engine.memory.arena import (
    APPROACH,
    ARM_A,
    ARM_B,
    BODIES,
    BODY,
    BODY_A,
    BODY_B,
    BODY_KIND,
    COUNT,
    DYNAMIC,
    GYROSCOPIC,
    HELD,
    MANIFOLDS,
    MOTION,
    NORMAL,
    NORMAL_IMPULSE,
    OLD_MANIFOLD,
    OLD_POINT,
    POINTS,
    SEPARATION,
    SETTING,
    SPIN_IMPULSE,
    STATE,
    STATIC,
    STRIKES,
    STRUCK,
    SUBSTEPS,
    TANGENT_IMPULSE,
    TURNED,
    WHOLE_STEP,
    P,
    Q,
    V,
    W,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DONE
from engine.memory.tables import bodies_of, contacts_of
from engine.respond.sequential_impulses import sweep_velocities
from engine.respond.softness import REBOUND, RELAX, slow_approach
from engine.respond.substep import bounce, end_step, end_substep
from engine.swept.begin import touch_gap
from engine.swept.path import body_at

__all__ = ["place_bodies", "strike"]

AT_ONCE = 1e-12
"""A time [s] within which no gap can close."""


@entry
def place_bodies(floats: Floats, ints: Ints, path: Floats, time: float) -> None:
    """Put every body that moves where its path is at this time; each keeps its angular momentum."""
    state, body, turned = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, TURNED)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    for b in range(count[0, BODIES]):
        if kind[b, MOTION] == STATIC:
            continue
        momentum = angular_momentum(state, body, b)
        p, q = body_at(path, b, time)
        store3(state, b, P, p)
        store4(state, b, Q, q)
        if kind[b, MOTION] == DYNAMIC:
            turn_inertia(state, body, turned, b)
            if count[0, GYROSCOPIC] == 1:
                store3(state, b, W, sym_vec(load6(turned, b, 0), momentum))


@entry
def strike(floats: Floats, ints: Ints, sweeps: int) -> int:
    """Find the contacts of this instant and resolve their blows. Args: sweeps: of each kind. Returns: as `find_contacts`."""
    status = find_contacts(floats, ints)
    if status != DONE:
        return status
    bodies, contacts = bodies_of(floats, ints), contacts_of(floats, ints)
    state, manifold, point, key = bodies.state, contacts.manifold, contacts.point, contacts.key
    kept, kept_point = floats_of(floats, ints, OLD_MANIFOLD), floats_of(floats, ints, OLD_POINT)
    setting, count = floats_of(floats, ints, SETTING), ints_of(ints, COUNT)
    n = count[0, MANIFOLDS]
    slow, touch = slow_approach(setting, setting[0, WHOLE_STEP] / count[0, SUBSTEPS]), touch_gap(setting)
    none = (0.0, 0.0, 0.0)
    for m in range(n):
        a, b = key[m, BODY_A], key[m, BODY_B]
        va, wa, vb, wb = load3(state, a, V), load3(state, a, W), load3(state, b, V), load3(state, b, W)
        store3(kept, m, SPIN_IMPULSE, load3(manifold, m, SPIN_IMPULSE))
        store3(manifold, m, SPIN_IMPULSE, none)
        key[m, STRIKES] = 0
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            kept_point[i, NORMAL_IMPULSE] = point[i, NORMAL_IMPULSE]
            store3(kept_point, i, TANGENT_IMPULSE, load3(point, i, TANGENT_IMPULSE))
            point[i, NORMAL_IMPULSE], point[i, HELD], point[i, HELD + 1] = 0.0, 0.0, 0.0
            ra, rb = load3(point, i, ARM_A), load3(point, i, ARM_B)
            u = dot(load3(manifold, m, NORMAL), sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra))))
            if point[i, SEPARATION] <= touch:
                point[i, SEPARATION], point[i, APPROACH] = 0.0, u
                if u < -slow:
                    key[m, STRIKES], point[i, STRUCK] = 1, 1.0
    for k in range(sweeps):
        sweep_velocities(bodies, contacts, n, AT_ONCE, RELAX, k % 2)
    if bounce(contacts, n):
        for k in range(sweeps):
            sweep_velocities(bodies, contacts, n, AT_ONCE, REBOUND, k % 2)
    end_substep(contacts, n)
    end_step(contacts, n)
    for m in range(n):
        store3(manifold, m, SPIN_IMPULSE, load3(kept, m, SPIN_IMPULSE))
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            point[i, NORMAL_IMPULSE] = kept_point[i, NORMAL_IMPULSE]
            store3(point, i, TANGENT_IMPULSE, load3(kept_point, i, TANGENT_IMPULSE))
    return DONE
