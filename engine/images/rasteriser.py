"""A z-buffer: every shape is drawn by itself into the pixels that it covers, and the nearest surface stays.

Polygons are filled between their edges; what is round is solved for its depth in each pixel of its rows, so that outlines and
depths are exact to rounding. Nothing is culled by its facing: a solid cut open by the near plane shows its inside.

Source: Catmull, A Subdivision Algorithm for Computer Display of Curved Surfaces, 1974 (the z-buffer).
"""

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.images.polygons import draw_polygon
from plumbline.engine.images.rounds import draw_ball, draw_capsule, draw_cylinder, draw_ellipsoid
from plumbline.engine.images.scanlines import flat_row
from plumbline.engine.images.screen import Screen, row_of, screen_of
from plumbline.engine.maths.rows import Floats, Ints, Mat, Vec, load3, load4, load9, store3
from plumbline.engine.maths.vec import add, dot, mat_vec, quat_mat, quat_mul, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of

TAGS = 2**32
"""Patches of a shape that can be told apart: a tag is its row in the table of shapes times this, plus the patch."""


@kernel
def shape_pose(state: Floats, shape: Floats, shape_kind: Ints, s: int) -> tuple[Vec, Mat]:
    """Origin [m] and axes of a shape in W."""
    b = shape_kind[s, at.OWNER]
    q = load4(state, b, at.Q)
    return (
        add(load3(state, b, at.P), mat_vec(quat_mat(q), load3(shape, s, at.OFFSET))),
        quat_mat(quat_mul(q, load4(shape, s, at.TURN))),
    )


@kernel
def draw_box(screen: Screen, c: Vec, m: Mat, h: Vec, tag: int, corner: Floats, kept: Floats) -> None:
    """Draw the six faces of a box; patch 2 k is the face at -h[k], 2 k + 1 the one opposite; room as of `draw_polygon`."""
    for face in range(6):
        k, sign = face // 2, (1.0 if face % 2 else -1.0)
        for q in range(4):
            one, two = (1.0 if q in (1, 2) else -1.0), (1.0 if q in (2, 3) else -1.0)
            spot = (
                h[0] * (sign if k == 0 else (two if k == 1 else one)),
                h[1] * (sign if k == 1 else (one if k == 0 else two)),
                h[2] * (sign if k == 2 else (two if k == 0 else one)),
            )
            store3(corner, q, 0, add(c, mat_vec(m, spot)))
        draw_polygon(screen, 4, corner, (m[k], m[3 + k], m[6 + k]), tag + face, kept)


@entry
def rasterise(floats: Floats, ints: Ints, eye: Floats, depth: Floats, tags: Ints) -> None:
    """Write z-depth (h, w) m, inf for nothing, and tag (h, w), -1 for nothing, of what is nearest in each pixel.

    Args: eye (1, 23): see `engine.images.eye.Eye.row`; without distortion.
    """
    state, shape = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.SHAPE)
    shape_kind = ints_of(ints, at.SHAPE_KIND)
    vertex, face = floats_of(floats, ints, at.VERTEX), floats_of(floats, ints, at.FACE)
    polyhedron, span, loop = ints_of(ints, at.POLYHEDRON), ints_of(ints, at.SPAN), ints_of(ints, at.LOOP)
    origin, turn, pinhole = load3(eye, 0, 0), load9(eye, 0, 3), eye[:, 12:17]
    screen = screen_of(pinhole, depth, tags)
    most = 4
    for f in range(len(span)):
        most = max(most, span[f, 1])
    corner, kept = np.empty((most, 3)), np.empty((most + 2, 3))
    for s in range(ints_of(ints, at.COUNT)[0, at.SHAPES]):
        p_WS, axes = shape_pose(state, shape, shape_kind, s)
        c, tag, kind, size = tmat_vec(turn, sub(p_WS, origin)), s * TAGS, shape_kind[s, at.TYPE], load3(shape, s, at.SIZE)
        x, y = tmat_vec(turn, (axes[0], axes[3], axes[6])), tmat_vec(turn, (axes[1], axes[4], axes[7]))
        a = tmat_vec(turn, (axes[2], axes[5], axes[8]))
        m = (x[0], y[0], a[0], x[1], y[1], a[1], x[2], y[2], a[2])
        if kind == at.SPHERE:
            draw_ball(screen, c, size[0], tag)
        elif kind == at.BOX:
            draw_box(screen, c, m, size, tag, corner, kept)
        elif kind == at.CAPSULE:
            draw_capsule(screen, c, a, size[0], size[1], tag)
        elif kind == at.CYLINDER:
            draw_cylinder(screen, c, a, size[0], size[1], tag)
        elif kind == at.ELLIPSOID:
            draw_ellipsoid(screen, c, m, size, tag)
        elif kind == at.PLANE:
            for j in range(depth.shape[0]):
                flat_row(0, depth.shape[1], row_of(screen, j, pinhole[0, 4]), a, dot(a, c), tag)
        elif kind in (at.HULL, at.TRIANGLE):
            # The second face of a triangle is the first, seen from behind.
            for f in range(polyhedron[s, at.FACES] if kind == at.HULL else 1):
                row = polyhedron[s, at.FIRST_FACE] + f
                for k in range(span[row, 1]):
                    store3(corner, k, 0, add(c, mat_vec(m, load3(vertex, loop[span[row, 0] + k, 0], 0))))
                draw_polygon(screen, span[row, 1], corner, mat_vec(m, load3(face, row, 0)), tag + f, kept)
