"""Build this step's manifolds from the pairs: the narrow phase, what the last step knew of each, and preparation.

Source: Ericson, Real-Time Collision Detection, section 12.4; Catto, Iterative Dynamics with Temporal Coherence, GDC 2005.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.contact.look_ahead import look_ahead, thinnest
from plumbline.engine.contact.warm_starting import carry_over, go_on, last_manifold, start_anew, take_over
from plumbline.engine.maths.rows import Floats, Vec, load3, store3
from plumbline.engine.maths.vec import add, axpy, cross, dot, norm, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Contacts, OldContacts, Pairs, Rules, Shapes
from plumbline.engine.narrow.box_box import FACE_OF_B
from plumbline.engine.narrow.collide import collide, is_convex_pair, ordered
from plumbline.engine.narrow.point import CORNERS_OF_B, Points
from plumbline.engine.respond.prepare import prepare
from plumbline.engine.swept.begin import FAST, begins

NEAR = 0.02
"""Share of half the thickness of the thinner shape [1] within which points of different features match."""
AT_REST = 1e-6
"""Tangential speed [m/s] below which a new contact counts as sticking."""
UNKNOWN = -1
"""For whether a manifold slips that the last step did not have, until all that it had are found again."""


@kernel
def find_points(
    shapes: Shapes, pairs: Pairs, p: int, a: int, b: int, margin: float, out: Points, first: int
) -> tuple[int, Vec]:  # fmt: skip
    """Write the contact points of pair p, shapes a and b, from row `first` on: as answered, or by their closed form.

    Returns: as `collide`.
    """
    if not is_convex_pair(shapes.kind[a, at.TYPE], shapes.kind[b, at.TYPE]):
        return collide(shapes, a, b, margin, out, first)
    points = pairs.points[p, 0]
    for k in range(points):
        store3(out.point, first + k, at.PLACE, load3(pairs.point, 4 * p + k, at.PLACE))
        out.point[first + k, at.FIRST_GAP] = pairs.point[4 * p + k, at.FIRST_GAP]
        out.key[first + k, 0] = pairs.point_key[4 * p + k, 0]
    return points, load3(pairs.normal, p, 0)


@kernel
def begin_manifold(
    shapes: Shapes, rules: Rules, a: int, b: int, points: int, normal: Vec, new: Contacts, row: int
) -> None:  # fmt: skip
    """Write what the narrow phase found of shapes a and b into a row, and clear the rest of it and of its points."""
    first = 4 * row
    for k in range(points):
        for c in range(new.point.shape[1]):
            if c != at.FIRST_GAP and not at.PLACE <= c < at.PLACE + 3:
                new.point[first + k, c] = 0.0
    for c in range(new.manifold.shape[1]):
        new.manifold[row, c] = 0.0
    store3(new.manifold, row, at.NORMAL, normal)
    law = shapes.kind[a, at.MATERIAL] * rules.numbers[0, at.MATERIALS] + shapes.kind[b, at.MATERIAL]
    for c in range(5):
        new.manifold[row, at.LAW + c] = rules.surface[law, c]
    new.key[row, at.SHAPE_A], new.key[row, at.SHAPE_B] = a, b
    new.key[row, at.BODY_A], new.key[row, at.BODY_B] = shapes.kind[a, at.OWNER], shapes.kind[b, at.OWNER]
    new.key[row, at.POINTS], new.key[row, at.SLIPS] = points, 0
    corners_of_b = (
        shapes.kind[a, at.TYPE] == at.BOX and shapes.kind[b, at.TYPE] == at.BOX and new.point_key[first, 0] < FACE_OF_B
    )
    new.key[row, at.LEADS] = 1 if corners_of_b or new.point_key[first, 0] >= CORNERS_OF_B else 0


@kernel
def start_slip(state: Floats, new: Contacts, row: int) -> None:
    """Let a new manifold slip or stick by the velocity of its first point."""
    i, j, n = new.key[row, at.BODY_A], new.key[row, at.BODY_B], load3(new.manifold, row, at.NORMAL)
    x = load3(new.point, 4 * row, at.PLACE)
    va = add(load3(state, i, at.V), cross(load3(state, i, at.W), sub(x, load3(state, i, at.P))))
    vb = add(load3(state, j, at.V), cross(load3(state, j, at.W), sub(x, load3(state, j, at.P))))
    u = sub(vb, va)
    new.key[row, at.SLIPS] = 1 if norm(axpy(-dot(u, n), n, u)) > AT_REST else 0


@kernel
def build_manifolds(
    bodies: Bodies, shapes: Shapes, rules: Rules, pairs: Pairs, new: Contacts, old: OldContacts, out: Points
) -> None:  # fmt: skip
    """Run the narrow phase on all pairs, match the points found with the old ones, and prepare them.

    Manifolds between still bodies stay what they were.

    Args: out: the points of the new contacts, and scratch.
    """
    state, kind, setting, count = bodies.state, bodies.kind, rules.setting, rules.numbers
    shape, shape_kind = shapes.shape, shapes.kind
    row, fresh = 0, 0
    for p in range(count[0, at.PAIRS]):
        a, b = ordered(shape_kind, pairs.pair[p, 0], pairs.pair[p, 1])
        i, j, m = shape_kind[a, at.OWNER], shape_kind[b, at.OWNER], last_manifold(old, a, b)
        if m >= 0 and kind[i, at.STILL] == 1 and kind[j, at.STILL] == 1:
            take_over(new, row, old, m)
            start_anew(state, new, row, row + 1)
            kind[i, at.TOUCHED] = 1
            kind[j, at.TOUCHED] = 1
            row += 1
            continue
        margin = look_ahead(state, shape, shape_kind, a, b, setting, count[0, at.CONTINUOUS])
        points, normal = find_points(shapes, pairs, p, a, b, margin, out, 4 * row)
        if points <= 0:
            continue
        fast = count[0, at.CONTINUOUS] == at.SWEPT and not margin <= FAST * setting[0, at.MARGIN]
        if fast and not begins(state, setting, i, j, normal, new.point, 4 * row, points):
            continue
        begin_manifold(shapes, rules, a, b, points, normal, new, row)
        kind[i, at.TOUCHED] = 1
        kind[j, at.TOUCHED] = 1
        if m < 0:
            new.key[row, at.SLIPS] = UNKNOWN
        else:
            carry_over(new, row, old, m, NEAR * min(thinnest(shape, shape_kind, a), thinnest(shape, shape_kind, b)))
            prepare(bodies, shapes, new, row)
        row += 1
    for m in range(row):
        if new.key[m, at.SLIPS] == UNKNOWN:
            if not go_on(shape, shape_kind, new, m, old):
                fresh += 1
                new.key[m, at.BEGUN] = count[0, at.STEPS]
                start_slip(state, new, m)
            prepare(bodies, shapes, new, m)
    count[0, at.MANIFOLDS], count[0, at.NEW] = row, fresh
