"""The narrow phase of one step of a world in which forces move meshes: triangles against triangles, and what is convex.

Compiled for such worlds alone; all others have `collide_convex`, which knows triangles as what convex shapes touch.
"""

from plumbline.engine.compile.jit import entry
from plumbline.engine.contact.look_ahead import look_ahead, thinnest
from plumbline.engine.contact.tables import pairs_of, rules_of
from plumbline.engine.maths.rows import Floats, Ints, store3
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.narrow.collide import is_convex_pair, ordered
from plumbline.engine.narrow.convex import convex_contact, plane_contact
from plumbline.engine.narrow.gjk import simplex_of
from plumbline.engine.narrow.mesh_mesh import SUNK, mesh_contact, mesh_plane
from plumbline.engine.narrow.point import Points
from plumbline.engine.narrow.support import solids_of

HANDICAP = 1e-3
"""As in `collide_convex`."""


@entry
def collide_meshes(floats: Floats, ints: Ints) -> None:
    """Answer the pairs of the coming step that have no closed form, for `build_manifolds` to read."""
    t, rules, pairs, simplex = solids_of(floats, ints), rules_of(floats, ints), pairs_of(floats, ints), simplex_of(floats, ints)
    out = Points(pairs.point, pairs.point_key, floats_of(floats, ints, at.POLYGON), ints_of(ints, at.POLYGON_KEY))
    state, setting, count = floats_of(floats, ints, at.STATE), rules.setting, rules.numbers
    sunk = SUNK * setting[0, at.MARGIN]
    for p in range(count[0, at.PAIRS]):
        a, b = ordered(t.shape_kind, pairs.pair[p, 0], pairs.pair[p, 1])
        ta, tb = t.shape_kind[a, at.TYPE], t.shape_kind[b, at.TYPE]
        if not is_convex_pair(ta, tb):
            continue
        margin = look_ahead(state, t.shape, t.shape_kind, a, b, setting, count[0, at.CONTINUOUS])
        if ta == at.TRIANGLE:
            points, n = mesh_contact(t, a, b, margin, sunk, simplex, out, 4 * p)
        elif tb == at.TRIANGLE and ta == at.PLANE:
            points, n = mesh_plane(t, a, b, margin, out, 4 * p)
        elif ta == at.PLANE:
            points, n = plane_contact(t, a, b, margin, out, 4 * p)
        else:
            slack = HANDICAP * min(thinnest(t.shape, t.shape_kind, a), thinnest(t.shape, t.shape_kind, b))
            points, n = convex_contact(t, a, b, margin, slack, simplex, out, 4 * p)
        pairs.points[p, 0] = points
        store3(pairs.normal, p, 0, n)
    count[0, at.CONVEX_READY] = 1
