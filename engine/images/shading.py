"""The colours of a rasterised picture: what scatters is lit by the sun and the sky, what does not shows the sky.

Nothing casts a shadow here, and nothing is mirrored but the sky.

Source: Lambert, Photometria, 1760 (even scattering); Deering, Winner, Schediwy, Duffy, Hunt, The Triangle Processor and Normal
Vector Shader, 1988 (colours after visibility).
"""

import math

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.images.rasteriser import TAGS, shape_pose
from plumbline.engine.images.tables import Lighting
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load9, store3, store9
from plumbline.engine.maths.vec import add, dot, mat_vec, neg, norm, scale, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of


@kernel
def patch_normal(kind: int, size: Vec, pose: Floats, face: Floats, first_face: int, s: int, patch: int, x: Vec) -> Vec:
    """The outward normal in W of a patch of shape s at x [m] on it; size [m]: the shape's three."""
    axes = load9(pose, s, 3)
    if kind == at.PLANE:
        n = (0.0, 0.0, 1.0)
    elif kind == at.BOX:
        k, sign = patch // 2, (1.0 if patch % 2 else -1.0)
        n = (sign if k == 0 else 0.0, sign if k == 1 else 0.0, sign if k == 2 else 0.0)
    elif kind >= at.HULL:
        n = load3(face, first_face + patch, 0)
    elif kind == at.CYLINDER and patch > 0:
        n = (0.0, 0.0, 1.0 if patch == 1 else -1.0)
    elif kind == at.ELLIPSOID:
        local = tmat_vec(axes, sub(x, load3(pose, s, 0)))
        away = (local[0] / (size[0] * size[0]), local[1] / (size[1] * size[1]), local[2] / (size[2] * size[2]))
        n = scale(1.0 / norm(away), away)
    else:
        local = tmat_vec(axes, sub(x, load3(pose, s, 0)))
        level = local[2] if kind == at.CYLINDER else min(max(local[2], -size[1]), size[1])
        away = (local[0], local[1], local[2] - level)
        n = scale(1.0 / norm(away), away)
    return mat_vec(axes, n)


@entry
def shade(
    floats: Floats, ints: Ints, eye: Floats, lighting: Lighting, depth: Floats, tags: Ints, body: Ints, colour: Floats
) -> None:
    """Write body (h, w) and colour (h, w, 3) of what `rasterise` found."""
    optics, sun = lighting
    state, shape = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.SHAPE)
    shape_kind = ints_of(ints, at.SHAPE_KIND)
    face, polyhedron = floats_of(floats, ints, at.FACE), ints_of(ints, at.POLYHEDRON)
    origin, turn, towards = load3(eye, 0, 0), load9(eye, 0, 3), load3(sun, 0, 0)
    pose = np.empty((len(shape_kind), 12))
    for s in range(ints_of(ints, at.COUNT)[0, at.SHAPES]):
        p_WS, axes = shape_pose(state, shape, shape_kind, s)
        store3(pose, s, 0, p_WS)
        store9(pose, s, 3, axes)
    for j in range(depth.shape[0]):
        for i in range(depth.shape[1]):
            if tags[j, i] < 0:
                body[j, i] = -1
                for k in range(3):
                    colour[j, i, k] = sun[0, 4]
                continue
            s = tags[j, i] // TAGS
            b = shape_kind[s, at.OWNER]
            body[j, i] = b
            z = depth[j, i]
            way = mat_vec(turn, (z * ((i + 0.5 - eye[0, 14]) / eye[0, 12]), z * ((j + 0.5 - eye[0, 15]) / eye[0, 13]), z))
            kind = shape_kind[s, at.TYPE]
            first = polyhedron[s, at.FIRST_FACE] if kind >= at.HULL else 0
            n = patch_normal(kind, load3(shape, s, at.SIZE), pose, face, first, s, tags[j, i] % TAGS, add(origin, way))
            n = n if dot(n, way) <= 0.0 else neg(n)
            lit = sun[0, 3] / math.pi * max(0.0, dot(n, towards)) + sun[0, 4]
            scattered = (1.0 - optics[b, 3]) * (1.0 - optics[b, 4])
            for k in range(3):
                colour[j, i, k] = scattered * optics[b, k] * lit + (1.0 - scattered) * sun[0, 4]


@entry
def name_bodies(ints: Ints, tags: Ints, body: Ints) -> None:
    """Write the body (h, w) of each tag (h, w), -1 for none."""
    shape_kind = ints_of(ints, at.SHAPE_KIND)
    for j in range(tags.shape[0]):
        for i in range(tags.shape[1]):
            body[j, i] = shape_kind[tags[j, i] // TAGS, at.OWNER] if tags[j, i] >= 0 else -1
