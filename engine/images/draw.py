"""A picture by either renderer."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.optics import Sun
from plumbline.engine.images.eye import Eye, Picture
from plumbline.engine.images.tables import lighting_of
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.rays.hits import Cast, Hits

BLOCK = 1 << 16
"""Pixels that are traced at once: their rays of one generation take some ten megabytes."""


def rasterised(floats: Floats, ints: Ints, bodies: Sequence[Body], sun: Sun, eye: Eye, colour: bool = True) -> Picture:
    """A picture by the z-buffer. Raises: NotSupported for a lens."""
    from plumbline.engine.images.rasteriser import rasterise
    from plumbline.engine.images.shading import name_bodies, shade

    if eye.lens is not None:
        raise NotSupported("lens of a rasterised picture", "a rasteriser draws straight lines; the ray tracer knows lenses")
    size = (eye.height, eye.width)
    depth, tags, body = np.empty(size), np.empty(size, np.int64), np.empty(size, np.int64)
    rasterise(floats, ints, eye.row, depth, tags)
    if not colour:
        name_bodies(ints, tags, body)
        return Picture(depth, body, None)
    painted = np.empty((*size, 3))
    shade(floats, ints, eye.row, lighting_of(bodies, sun), depth, tags, body, painted)
    return Picture(depth, body, painted)


def ray_traced(cast: Cast, bodies: Sequence[Body], sun: Sun, eye: Eye, colour: bool = True) -> Picture:
    """A picture by rays. Raises: ValueError for a lens that shows nothing at some pixel."""
    from plumbline.engine.images.waves import Light, first_wave, follow

    depth, body = np.empty((eye.height, eye.width)), np.empty((eye.height, eye.width), np.int64)
    painted = np.zeros((eye.height, eye.width, 3)) if colour else None
    light = Light(lighting_of(bodies, sun), eye.bounces, eye.sky_rays)
    points = even_points(eye.samples)
    rows = max(1, BLOCK // eye.width)
    for first in range(0, eye.height, rows):
        part = slice(first, min(first + rows, eye.height))
        aim = partial(_aimed, cast, eye, first, part.stop - first)
        origins, directions, hits, depth[part] = aim(0.5, 0.5)
        body[part] = hits.body.reshape(-1, eye.width)
        if painted is None:
            continue
        pixels, radiance = np.arange(len(directions)), np.zeros((len(directions), 3))
        for sample, (x, y) in enumerate(points):
            if eye.samples > 1:
                origins, directions, hits, _ = aim(float(x), float(y))
            for _ in follow(cast, first_wave(origins, directions, hits, pixels), light, sample, radiance):
                pass
        painted[part] = (radiance / eye.samples).reshape(-1, eye.width, 3)
    return Picture(depth, body, painted)


def even_points(count: int) -> Floats:
    """Points (count, 2) that fill the unit square evenly about its middle, the same in every run; one is the middle itself.

    Source: Hammersley, Monte Carlo Methods for Solving Multivariable Problems, 1960.
    """
    k = np.arange(count)
    mirrored, bits = np.zeros(count), max(1, int(count - 1).bit_length())
    for b in range(bits):
        mirrored += (k >> b & 1) / (1 << (b + 1))
    points = np.column_stack([(k + 0.5) / count, mirrored])
    points[:, 1] += 0.5 - points[:, 1].mean()
    return np.asarray(points % 1.0)


def _aimed(cast: Cast, eye: Eye, first: int, rows: int, x: float, y: float) -> tuple[Floats, Floats, Hits, Floats]:
    """The rays through one point (x, y) of each pixel in some rows, and what they meet from the near plane on.

    Returns: origins (n, 3) or (1, 3) m, directions (n, 3), hits, z-depths (rows, w) m.
    Raises: ValueError naming the first pixel at which the lens shows nothing.
    """
    from plumbline.engine.images.lens import look

    origins = np.atleast_2d(np.asarray(eye.p_WE, float))
    directions, length = np.empty((rows * eye.width, 3)), np.empty(rows * eye.width)
    dark = look(eye.row, eye.width, first, rows, x, y, directions, length)
    if dark >= 0:
        raise ValueError(
            f"eye: lens {eye.lens} shows nothing at pixel ({dark % eye.width}, {first + dark // eye.width}), which lies beyond "
            "its fold; expected one that covers the picture"
        )
    hits: Hits = cast(origins, directions)
    depth = hits.distance / length
    early = np.flatnonzero(depth < eye.near)
    if len(early) > 0:
        # What lies before the near plane is not seen: these rays start on it.
        origins = np.repeat(origins, len(directions), axis=0)
        origins[early] += eye.near * directions[early]
        again = cast(origins[early], directions[early])
        hits.distance[early], hits.body[early], hits.normal[early] = again.distance, again.body, again.normal
        depth[early] = eye.near + again.distance / length[early]
    return origins, directions, hits, depth.reshape(rows, eye.width)
