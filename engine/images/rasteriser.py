"""A z-buffer: every shape is drawn by itself into the pixels that it covers, and the nearest surface stays.

Polygons are filled between their edges; what is round is met by a ray through each pixel of its rows, so that outlines and
depths are exact to rounding. Nothing is culled by its facing: a solid cut open by the near plane shows its inside.

Source: Catmull, A Subdivision Algorithm for Computer Display of Curved Surfaces, 1974 (the z-buffer).
"""

import numpy as np

from plumbline.engine.broad.bounds import put_pose
from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.images.polygons import draw_polygon
from plumbline.engine.images.rounds import draw_round
from plumbline.engine.images.screen import Screen, flat_row, row_of, screen_of
from plumbline.engine.maths.rows import Floats, Ints, Mat, Vec, load3, load4, load9, store3
from plumbline.engine.maths.vec import add, dot, mat_vec, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.narrow.solid import column, face_corner
from plumbline.engine.rays.streams import Primitive

TAGS = 2**32
"""Faces of a shape that can be told apart: a tag is the shape's row in the table of shapes times this, plus the face."""


@kernel
def shape_poses(floats: Floats, ints: Ints) -> Floats:
    """Position [m] and rotation matrix in W of every shape (shapes, 12)."""
    state, shape = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.SHAPE)
    shape_kind = ints_of(ints, at.SHAPE_KIND)
    pose = np.empty((len(shape), 12))
    for s in range(ints_of(ints, at.COUNT)[0, at.SHAPES]):
        b = shape_kind[s, at.OWNER]
        put_pose(shape, s, load3(state, b, at.P), load4(state, b, at.Q), pose, s)
    return pose


@kernel
def draw_box(screen: Screen, c: Vec, m: Mat, h: Vec, tag: int, corner: Floats, kept: Floats) -> None:
    """Draw the six faces of a box, 2 k the one at -h[k] and 2 k + 1 the one opposite; room as of `draw_polygon`."""
    for face in range(6):
        k = face // 2
        for q in range(4):
            store3(corner, q, 0, face_corner(c, m, h, k, 1.0 if face % 2 else -1.0, q))
        draw_polygon(screen, 4, corner, column(m, k), tag + face, kept)


@entry
def rasterise(floats: Floats, ints: Ints, eye: Floats, depth: Floats, tags: Ints) -> None:
    """Write z-depth (h, w) m, inf for nothing, and tag (h, w), -1 for nothing, of what is nearest in each pixel.

    Args: eye (1, 23): see `engine.images.eye.Eye.row`; without distortion.
    """
    shape, shape_kind, pose = floats_of(floats, ints, at.SHAPE), ints_of(ints, at.SHAPE_KIND), shape_poses(floats, ints)
    vertex, face = floats_of(floats, ints, at.VERTEX), floats_of(floats, ints, at.FACE)
    polyhedron, span, loop = ints_of(ints, at.POLYHEDRON), ints_of(ints, at.SPAN), ints_of(ints, at.LOOP)
    origin, turn, pinhole = load3(eye, 0, 0), load9(eye, 0, 3), eye[:, 12:17]
    screen = screen_of(pinhole, depth, tags)
    most = 4
    for f in range(len(span)):
        most = max(most, span[f, 1])
    corner, kept = np.empty((most, 3)), np.empty((most + 2, 3))
    for s in range(ints_of(ints, at.COUNT)[0, at.SHAPES]):
        tag, kind, size, axes = s * TAGS, shape_kind[s, at.TYPE], load3(shape, s, at.SIZE), load9(pose, s, 3)
        c = tmat_vec(turn, sub(load3(pose, s, 0), origin))
        x, y = tmat_vec(turn, (axes[0], axes[3], axes[6])), tmat_vec(turn, (axes[1], axes[4], axes[7]))
        a = tmat_vec(turn, (axes[2], axes[5], axes[8]))
        m = (x[0], y[0], a[0], x[1], y[1], a[1], x[2], y[2], a[2])
        if kind == at.BOX:
            draw_box(screen, c, m, size, tag, corner, kept)
        elif kind == at.PLANE:
            for j in range(depth.shape[0]):
                flat_row(row_of(screen, j, pinhole[0, 4], 0, depth.shape[1]), a, dot(a, c), tag)
        elif kind < at.HULL:
            if kind == at.SPHERE:
                kind, size = at.ELLIPSOID, (size[0], size[0], size[0])
            draw_round(screen, Primitive(s, kind, 0, 0, c, m, size, shape[s, at.BALL_RADIUS]), tag)
        else:
            # The second face of a triangle is the first, seen from behind.
            for f in range(polyhedron[s, at.FACES] if kind == at.HULL else 1):
                row = polyhedron[s, at.FIRST_FACE] + f
                for k in range(span[row, 1]):
                    store3(corner, k, 0, add(c, mat_vec(m, load3(vertex, loop[span[row, 0] + k, 0], 0))))
                draw_polygon(screen, span[row, 1], corner, mat_vec(m, load3(face, row, 0)), tag + f, kept)
