"""Contacts of worlds of spheres: one point per pair, in the order of the pairs, matched with the last step's by walking both.

Source: Ericson, Real-Time Collision Detection, section 4.3.1; Catto, Iterative Dynamics with Temporal Coherence, GDC 2005.
"""

from plumbline.engine.broad.bounds import brute_force
from plumbline.engine.broad.candidates import rank_of
from plumbline.engine.compile.jit import kernel
from plumbline.engine.contact.find_contacts import needs_search
from plumbline.engine.contact.look_ahead import look_ahead
from plumbline.engine.contact.manifolds import AT_REST
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, store3
from plumbline.engine.maths.vec import add, axpy, cross, dot, norm, scale, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DONE, FULL, SEARCH_PENDING
from plumbline.engine.memory.tables import Shapes, shapes_of
from plumbline.engine.narrow.box_pairs import sphere_box
from plumbline.engine.narrow.point import Points, points_of
from plumbline.engine.narrow.round_pairs import sphere_plane
from plumbline.engine.narrow.solid import solid_of


@kernel
def against_static(shapes: Shapes, a: int, b: int, margin: float, out: Points) -> tuple[int, Vec]:
    """Sphere a against box or plane b, written on row 0 of `out`. Returns: points, normal."""
    one, two = solid_of(shapes, a), solid_of(shapes, b)
    if shapes.kind[b, at.TYPE] == at.BOX:
        return sphere_box(one, two, margin, out, 0)
    return sphere_plane(one, two, margin, out, 0)


@kernel
def gather(floats: Floats, ints: Ints) -> None:
    """Copy what the solver needs of each body into one row, and mark all bodies as untouched."""
    state, body, mover = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.BODY), floats_of(floats, ints, at.MOVER)
    kind = ints_of(ints, at.BODY_KIND)
    for b in range(ints_of(ints, at.COUNT)[0, at.BODIES] + 1):
        kind[b, at.TOUCHED] = 0
        store3(mover, b, 0, load3(state, b, at.V))
        store3(mover, b, 3, load3(state, b, at.W))
        mover[b, at.M_INV_MASS], mover[b, at.M_INV_INERTIA] = body[b, at.INV_MASS], body[b, at.INV_INERTIA]


@kernel
def keep_old(touch: Floats, key: Ints, first: int, last: int, old: Floats, old_key: Ints) -> None:
    """Copy what the next step takes over of a range of contacts, before others are written in their place."""
    for m in range(first, last):
        old_key[m, 0], old_key[m, 1] = key[m, at.K_PAIR], key[m, at.K_SLIPS]
        for c in range(4):
            old[m, c] = touch[m, at.T_NORMAL + c]


@kernel
def list_by_sphere(key: Ints, first: int, last: int, head: Ints, table: Ints) -> None:
    """List the contacts of the last step in a range of rows by their sphere A. Args: head: LAST_OF_SPHERE; table: COLOURED."""
    for b in range(head.shape[0]):
        head[b, 0] = -1
    for m in range(first, last):
        table[m, at.FOLLOWING] = head[key[m, at.K_BODY_A], 0]
        head[key[m, at.K_BODY_A], 0] = m


@kernel
def build_touches(floats: Floats, ints: Ints, pairs: int) -> None:
    """Run the narrow phase on all pairs and take over the impulses of those that touched in the last step.

    Up to the first pair that did not, or that does no longer, contacts stay in their rows with all that never changes. Pairs
    come in rising order, and both steps' contacts are walked at once; where colours sort them otherwise, those of the last step
    are looked up by their sphere.
    """
    tables, surface = shapes_of(floats, ints), floats_of(floats, ints, at.SURFACE)
    shape, pose, shape_kind = tables
    touch, rest = floats_of(floats, ints, at.TOUCH), floats_of(floats, ints, at.TOUCH_REST)
    old = floats_of(floats, ints, at.OLD_TOUCH)
    state, mover = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.MOVER)
    setting, points = floats_of(floats, ints, at.SETTING), points_of(floats, ints)
    key, old_key, pair = ints_of(ints, at.TOUCH_KEY), ints_of(ints, at.OLD_TOUCH_KEY), ints_of(ints, at.PAIR)
    kind, count = ints_of(ints, at.BODY_KIND), ints_of(ints, at.COUNT)
    last, shapes, materials = count[0, at.MANIFOLDS], count[0, at.SHAPES], count[0, at.MATERIALS]
    continuous = count[0, at.CONTINUOUS]
    head, table = ints_of(ints, at.LAST_OF_SPHERE), ints_of(ints, at.COLOURED)
    least, dt, coloured = setting[0, at.MARGIN], setting[0, at.DT], head.shape[0] > 0
    fall = dt * norm(load3(setting, 0, at.GRAVITY))
    found, new, walk, as_before = 0, 0, 0, True
    for p in range(pairs):
        code = rank_of(pair[p, 0], pair[p, 1], shapes)
        a, b = pair[p, 0], pair[p, 1]
        if shape_kind[a, at.TYPE] != at.SPHERE or kind[shape_kind[a, at.OWNER], at.MOTION] != at.DYNAMIC:
            a, b = b, a
        i, j, t = shape_kind[a, at.OWNER], shape_kind[b, at.OWNER], found
        pa, ra = load3(pose, a, 0), shape[a, at.SIZE]
        # Spheres are compared here: a call that hands over several arrays costs more than the comparison.
        if shape_kind[b, at.TYPE] == at.SPHERE:
            is_round, rb, d = 1, shape[b, at.SIZE], sub(load3(pose, b, 0), pa)
            length = norm(d)
            gap = length - ra - rb
            if gap > least:
                way = least + dt * (norm(sub(load3(mover, j, 0), load3(mover, i, 0))) + fall)
                if gap > (way if continuous == at.SPECULATIVE else min(way, max(least, min(ra, rb)))):
                    continue
            n = scale(1.0 / length, d) if length > 1e-300 else (0.0, 0.0, 1.0)
            place = axpy(ra + 0.5 * gap, n, pa)
        else:
            is_round, rb = 0, 0.0
            margin = look_ahead(state, shape, shape_kind, a, b, setting, continuous)
            touching, n = against_static(tables, a, b, margin, points)
            if touching == 0:
                continue
            gap, place = points.point[0, at.FIRST_GAP], load3(points.point, 0, at.PLACE)
        la, lb = ra + 0.5 * gap, rb + 0.5 * gap
        mass = mover[i, at.M_INV_MASS] + mover[j, at.M_INV_MASS]
        if as_before and (t >= last or key[t, at.K_PAIR] != code):
            as_before, walk = False, t
            keep_old(touch, key, t, last, old, old_key)
            if coloured:
                list_by_sphere(key, t, last, head, table)
        store3(touch, t, 0, n)
        touch[t, at.T_GAP] = gap
        touch[t, at.T_TANGENT_MASS] = 1.0 / (mass + la * la * mover[i, at.M_INV_INERTIA] + lb * lb * mover[j, at.M_INV_INERTIA])
        touch[t, at.T_BASE] = gap + dot(n, pa)
        store3(touch, t, at.T_SUM, (0.0, 0.0, 0.0))
        store3(rest, t, at.R_PLACE, place)
        store3(rest, t, at.R_NORMAL, n)
        rest[t, at.R_FIRST_GAP] = gap
        kind[i, at.TOUCHED] = 1
        kind[j, at.TOUCHED] = 1
        found += 1
        if as_before:
            held = load3(touch, t, at.T_TANGENT)
            store3(touch, t, at.T_TANGENT, axpy(-dot(n, held), n, held))
            continue
        touch[t, at.T_NORMAL_MASS] = 1.0 / mass
        touch[t, at.T_RADIUS_A], touch[t, at.T_RADIUS_B] = ra, rb
        law = shape_kind[a, at.MATERIAL] * materials + shape_kind[b, at.MATERIAL]
        rest[t, at.R_STATIC], rest[t, at.R_KINETIC] = surface[law, 0], surface[law, 1]
        rest[t, at.R_RESTITUTION] = surface[law, 2]
        rest[t, at.R_STRUCK], rest[t, at.R_SPIKE] = 0.0, 0.0
        key[t, at.K_BODY_A], key[t, at.K_BODY_B], key[t, at.K_PAIR], key[t, at.K_ROUND] = i, j, code, is_round
        key[t, at.K_MOVES] = 1 if kind[j, at.MOTION] == at.DYNAMIC else 0
        if coloured:
            walk = head[i, 0]
            while walk >= 0 and old_key[walk, 0] != code:
                walk = table[walk, at.FOLLOWING]
            walk = walk if walk >= 0 else last
        else:
            while walk < last and old_key[walk, 0] < code:
                walk += 1
        if walk < last and old_key[walk, 0] == code:
            key[t, at.K_SLIPS], touch[t, at.T_NORMAL] = old_key[walk, 1], old[walk, 0]
            held = load3(old, walk, 1)
            store3(touch, t, at.T_TANGENT, axpy(-dot(n, held), n, held))
        else:
            new += 1
            spin = add(scale(la, load3(mover, i, 3)), scale(lb, load3(mover, j, 3)))
            u = sub(sub(load3(mover, j, 0), load3(mover, i, 0)), cross(spin, n))
            key[t, at.K_SLIPS] = 1 if norm(axpy(-dot(u, n), n, u)) > AT_REST else 0
            touch[t, at.T_NORMAL] = 0.0
            store3(touch, t, at.T_TANGENT, (0.0, 0.0, 0.0))
        touch[t, at.T_FRICTION] = rest[t, at.R_STATIC] if key[t, at.K_SLIPS] == 0 else rest[t, at.R_KINETIC]
    count[0, at.MANIFOLDS], count[0, at.NEW] = found, new


@kernel
def find_touches(floats: Floats, ints: Ints) -> int:
    """Find the contacts of this step and mark the bodies they touch. Returns: DONE, or SEARCH_PENDING or FULL."""
    if needs_search(ints):
        return SEARCH_PENDING
    count = ints_of(ints, at.COUNT)
    if count[0, at.BROAD] == 0:
        brute_force(floats, ints)
        if count[0, at.PAIRS] > len(ints_of(ints, at.PAIR)):
            return FULL
    ints_of(ints, at.TALLY)[0, at.SEARCHED] = 0
    gather(floats, ints)
    build_touches(floats, ints, count[0, at.PAIRS])
    return DONE
