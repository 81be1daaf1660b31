"""The colours of a rasterised picture: what scatters is lit by the sun and the sky, what does not shows the sky.

Nothing casts a shadow here, and nothing is mirrored but the sky.

Source: Lambert, Photometria, 1760 (even scattering); Deering, Winner, Schediwy, Duffy, Hunt, The Triangle Processor and Normal
Vector Shader, 1988 (colours after visibility).
"""

import math

from plumbline.engine.compile.jit import entry
from plumbline.engine.images.rasteriser import TAGS, shape_poses
from plumbline.engine.images.tables import Lighting
from plumbline.engine.maths.rows import Floats, Ints, load3, load9
from plumbline.engine.maths.vec import add, dot, mat_vec, neg, scale, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.rays.streams import normal_at


@entry
def shade(
    floats: Floats, ints: Ints, eye: Floats, lighting: Lighting, depth: Floats, tags: Ints, body: Ints, colour: Floats
) -> None:
    """Write body (h, w) and colour (h, w, 3) of what `rasterise` found."""
    optics, sun = lighting
    shape, shape_kind, pose = floats_of(floats, ints, at.SHAPE), ints_of(ints, at.SHAPE_KIND), shape_poses(floats, ints)
    face, polyhedron = floats_of(floats, ints, at.FACE), ints_of(ints, at.POLYHEDRON)
    origin, turn, towards = load3(eye, 0, 0), load9(eye, 0, 3), load3(sun, 0, 0)
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
            z, kind = depth[j, i], shape_kind[s, at.TYPE]
            way = mat_vec(turn, (z * ((i + 0.5 - eye[0, 14]) / eye[0, 12]), z * ((j + 0.5 - eye[0, 15]) / eye[0, 13]), z))
            axes = load9(pose, s, 3)
            k = tags[j, i] % TAGS
            if kind == at.BOX:
                n = scale(1.0 if k % 2 else -1.0, (axes[k // 2], axes[3 + k // 2], axes[6 + k // 2]))
            elif kind >= at.HULL:
                n = mat_vec(axes, load3(face, polyhedron[s, at.FIRST_FACE] + k, 0))
            else:
                x = tmat_vec(axes, sub(add(origin, way), load3(pose, s, 0)))
                n = mat_vec(axes, normal_at(kind, load3(shape, s, at.SIZE), x))
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
