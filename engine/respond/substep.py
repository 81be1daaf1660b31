"""What begins and ends a sub-step of contact: warm start, blows to come, restitution, friction's mode, sums of impulses."""

from plumbline.engine.compile.jit import inlined, kernel
from plumbline.engine.maths.elementary import hypot
from plumbline.engine.maths.rows import Floats, Mat, Vec, load3, store3
from plumbline.engine.maths.vec import add, axpy, dot, mat_vec, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Contacts
from plumbline.engine.respond.centre import Centre, centre_of, frame_of, give_impulse, motion_of, pair_of, relative_motion
from plumbline.engine.respond.softness import STUCK, TOUCHING


@inlined
def kept_impulse(contacts: Contacts, m: int, frame: Mat) -> tuple[Vec, Vec]:
    """The impulses that manifold m has now, as force and moment at its centre, in its frame."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    moment = mat_vec(frame, load3(manifold, m, at.SPIN_IMPULSE))
    f1, f2, f3, m1, m2, m3 = 0.0, 0.0, 0.0, moment[0], moment[1], moment[2]
    for i in range(4 * m, 4 * m + key[m, at.POINTS]):
        x, y, normal, one = point[i, at.SPREAD], point[i, at.SPREAD + 1], point[i, at.NORMAL_IMPULSE], point[i, at.HELD]
        two = point[i, at.HELD + 1]
        f1, f2, f3 = f1 + one, f2 + two, f3 + normal
        m1, m2, m3 = m1 + y * normal, m2 - x * normal, m3 + x * two - y * one
    return (f1, f2, f3), (m1, m2, m3)


@kernel
def warm_start(bodies: Bodies, contacts: Contacts) -> None:
    """Apply the impulses of the last sub-step."""
    state, manifold, key = bodies.state, contacts.manifold, contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        a, b = key[m, at.BODY_A], key[m, at.BODY_B]
        frame = frame_of(manifold, m)
        force, moment = kept_impulse(contacts, m, frame)
        pair = pair_of(bodies.body, bodies.turned, a, b)
        centre = Centre(frame, load3(manifold, m, at.CENTRE_A), load3(manifold, m, at.CENTRE_B))
        give_impulse(state, pair, centre, motion_of(state, a, b), force, moment)


@kernel
def approach(bodies: Bodies, contacts: Contacts, setting: Floats, h: float, slow: float) -> int:
    """Note the points that are about to strike in this sub-step, with their normal velocity at the moment of impact [m/s].

    With separation s and normal velocity u < 0 after the kick a h, the impact comes after the share tau = s / (-u h) of the
    sub-step, when the velocity is u - (1 - tau) a h. Impulses of earlier sub-steps are no guess for a blow and are dropped. A
    gap that is the way of the sub-step to rounding is one that closes in it.

    Returns: how many points strike.
    """
    state, kind = bodies.state, bodies.kind
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    strikes = 0
    g = load3(setting, 0, at.GRAVITY)
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        a, b = key[m, at.BODY_A], key[m, at.BODY_B]
        v, w = relative_motion(centre_of(manifold, m), motion_of(state, a, b))
        kick = h * dot(load3(manifold, m, at.NORMAL), g)
        kick *= (1.0 if kind[b, at.MOTION] == at.DYNAMIC else 0.0) - (1.0 if kind[a, at.MOTION] == at.DYNAMIC else 0.0)
        if key[m, at.STRIKES] == 1:
            key[m, at.STRIKES] = 0
            for i in range(4 * m, 4 * m + key[m, at.POINTS]):
                point[i, at.STRUCK] = 0.0
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            u = v[2] + w[0] * point[i, at.SPREAD + 1] - w[1] * point[i, at.SPREAD]
            if u < -slow and point[i, at.SEPARATION] < -u * h * (1.0 + TOUCHING):
                share = min(max(point[i, at.SEPARATION] / (-u * h), 0.0), 1.0)
                strikes += 1
                key[m, at.STRIKES] = 1
                point[i, at.STRUCK] = 1.0
                point[i, at.SPIKE] = 0.0
                point[i, at.APPROACH] = min(u - (1.0 - share) * kick, 0.0)
                point[i, at.NORMAL_IMPULSE], point[i, at.HELD], point[i, at.HELD + 1] = 0.0, 0.0, 0.0
                store3(point, i, at.TANGENT_IMPULSE, (0.0, 0.0, 0.0))
    return strikes


@kernel
def bounce(contacts: Contacts) -> bool:
    """Whether any point struck a surface with restitution in this sub-step."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        if key[m, at.STRIKES] == 1 and manifold[m, at.LAW + 2] > 0.0:
            for i in range(4 * m, 4 * m + key[m, at.POINTS]):
                if point[i, at.STRUCK] == 1.0 and point[i, at.SPIKE] > 0.0:
                    return True
    return False


@kernel
def spread_friction(static: float, first: int, end: int, point: Floats) -> None:
    """Spread the friction of the points first..end - 1 as their loads are, if that stays within the discs of `static`.

    Points that bear unlike loads fill their discs one after the other, and then push against each other too: part of the discs
    goes into forces that cancel. With the same sum and moment, friction at (x, y) becomes N (F/n + turn (-y, x)), counted from
    the centre of load; n is the sum of the loads N. Each operation is rounded by itself, so that every program that holds it
    gives the same bits.
    """
    n, cx, cy, f1, f2, moment, spread = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(first, end):
        x, y, load, one = point[i, at.SPREAD], point[i, at.SPREAD + 1], point[i, at.NORMAL_IMPULSE], point[i, at.HELD]
        two = point[i, at.HELD + 1]
        n, cx, cy, spread = n + load, cx + load * x, cy + load * y, spread + load * (x * x + y * y)
        f1, f2, moment = f1 + one, f2 + two, moment + x * two - y * one
    if n <= 0.0:
        return
    cx, cy = cx / n, cy / n
    about = spread - n * (cx * cx + cy * cy)
    turn = (moment - cx * f2 + cy * f1) / about if about > 1e-9 * spread else 0.0
    f1, f2 = f1 / n + turn * cy, f2 / n - turn * cx
    for i in range(first, end):
        one, two = f1 - turn * point[i, at.SPREAD + 1], f2 + turn * point[i, at.SPREAD]
        if one * one + two * two > static * static:
            return
    for i in range(first, end):
        point[i, at.HELD] = point[i, at.NORMAL_IMPULSE] * (f1 - turn * point[i, at.SPREAD + 1])
        point[i, at.HELD + 1] = point[i, at.NORMAL_IMPULSE] * (f2 + turn * point[i, at.SPREAD])


@kernel
def friction_mode(bodies: Bodies, contacts: Contacts) -> None:
    """A manifold slips where what would stop its motion takes more power than its static disc can, else it sticks.

    Of all that friction can give, the discs full against the motion take most power from it (maximum dissipation), so that a
    force and moment that would take more are out of reach.
    """
    state, body = bodies.state, bodies.body
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        static = manifold[m, at.LAW]
        if static == manifold[m, at.LAW + 1]:
            continue
        a, b = key[m, at.BODY_A], key[m, at.BODY_B]
        v, w = relative_motion(centre_of(manifold, m), motion_of(state, a, b))
        needed, most = 0.0, 0.0
        share = 1.0 / (max(body[a, at.INV_MASS] + body[b, at.INV_MASS], 1e-300) * max(key[m, at.POINTS], 1))
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            one, two = v[0] - point[i, at.SPREAD + 1] * w[2], v[1] + point[i, at.SPREAD] * w[2]
            needed += one * (share * one - point[i, at.HELD]) + two * (share * two - point[i, at.HELD + 1])
            most += static * point[i, at.NORMAL_IMPULSE] * hypot(one, two)  # whose squares may underflow
        key[m, at.SLIPS] = int(needed > STUCK * most)
        if key[m, at.SLIPS] == 0:
            spread_friction(static, 4 * m, 4 * m + key[m, at.POINTS], point)


@kernel
def end_substep(contacts: Contacts) -> None:
    """Add the sub-step's impulses to the step's, in the frames, and drop those of a blow, which do not last."""
    point, key = contacts.point, contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            point[i, at.SUM] += point[i, at.HELD]
            point[i, at.SUM + 1] += point[i, at.HELD + 1]
            point[i, at.SUM + 2] += point[i, at.NORMAL_IMPULSE]
            if point[i, at.STRUCK] == 1.0:
                point[i, at.NORMAL_IMPULSE], point[i, at.HELD], point[i, at.HELD + 1] = 0.0, 0.0, 0.0


@kernel
def end_step(contacts: Contacts) -> None:
    """Turn the sum of the step's impulses, and the friction that the next step starts from, into W."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        frame = frame_of(manifold, m)
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            store3(point, i, at.SUM, tmat_vec(frame, load3(point, i, at.SUM)))
            store3(point, i, at.TANGENT_IMPULSE, tmat_vec(frame, (point[i, at.HELD], point[i, at.HELD + 1], 0.0)))


@kernel
def sum_impulses(contacts: Contacts) -> None:
    """As `end_substep`, where friction impulses are kept in W all along."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        n = load3(manifold, m, at.NORMAL)
        for i in range(4 * m, 4 * m + key[m, at.POINTS]):
            tangent = load3(point, i, at.TANGENT_IMPULSE)
            store3(point, i, at.SUM, add(load3(point, i, at.SUM), axpy(point[i, at.NORMAL_IMPULSE], n, tangent)))
            if point[i, at.STRUCK] == 1.0:
                point[i, at.NORMAL_IMPULSE] = 0.0
                store3(point, i, at.TANGENT_IMPULSE, (0.0, 0.0, 0.0))
