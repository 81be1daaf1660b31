"""The narrow phase of one step of a world in which forces move meshes: triangles against triangles, and what is convex.

Compiled for such worlds alone; all others have `collide_convex`, which knows triangles as what convex shapes touch.
"""

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.contact.collide_convex import answer_pairs, meet_convex
from plumbline.engine.maths.rows import Floats, Ints, Vec
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.gjk import Simplex
from plumbline.engine.narrow.mesh_mesh import SUNK, mesh_contact, mesh_plane
from plumbline.engine.narrow.point import Points
from plumbline.engine.narrow.support import Solids


@kernel
def meet_meshes(
    t: Solids, a: int, b: int, margin: float, least: float, simplex: Simplex, out: Points, row: int
) -> tuple[int, Vec]:  # fmt: skip
    """The contact of two shapes, of which triangles are skins of solids. Args: as of `answer_pairs`."""
    ta, tb = t.shape_kind[a, at.TYPE], t.shape_kind[b, at.TYPE]
    if ta == at.TRIANGLE:
        return mesh_contact(t, a, b, margin, SUNK * least, simplex, out, row)
    if tb == at.TRIANGLE and ta == at.PLANE:
        return mesh_plane(t, a, b, margin, out, row)
    return meet_convex(t, a, b, margin, least, simplex, out, row)


@entry
def collide_meshes(floats: Floats, ints: Ints) -> None:
    """As `answer_pairs`, where triangles meet each other."""
    answer_pairs(floats, ints, meet_meshes)
