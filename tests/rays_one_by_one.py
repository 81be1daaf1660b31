"""The first hit of each ray among the shapes with closed forms, one ray and one shape after the other: the oracle of the tiles.

A ray that starts inside a solid hits its exit; the normal points out of the shape.

Source: Ericson, Real-Time Collision Detection, sections 5.3.1 (plane), 5.3.2 (sphere, and ellipsoid by
scaling), 5.3.3 (box), 5.3.7 (cylinder).
"""

import math
from typing import Any

import numpy as np

from plumbline import engine
from plumbline.engine.broad.bounds import pose_shape
from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.arrays import unit
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load9, store3
from plumbline.engine.maths.vec import axpy, dot, mat_vec, norm, scale, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.tables import shapes_of
from plumbline.engine.rays.cast import as_rays, check_rays
from plumbline.engine.rays.hits import Hits, room_for
from plumbline.engine.rays.polyhedra import cast_on_polyhedra
from plumbline.engine.rays.tree import ray_tree

__all__ = ["cast_one_by_one"]

MISS = math.inf
UP = (0.0, 0.0, 1.0)


@kernel
def ray_sphere(o: Vec, d: Vec, radius: float) -> tuple[float, Vec]:
    """|o + t d| = radius, with the discriminant taken from the ray's distance to the centre, which does not cancel."""
    b = dot(o, d)
    side = axpy(-b, d, o)
    root = radius * radius - dot(side, side)
    if root < 0.0:
        return MISS, UP
    root = math.sqrt(root)
    t = -b - root
    if t < 0.0:
        t = -b + root
    if t < 0.0:
        return MISS, UP
    hit = axpy(t, d, o)
    return t, scale(1.0 / norm(hit), hit)


@kernel
def ray_plane(o: Vec, d: Vec) -> tuple[float, Vec]:
    """The half space z <= 0."""
    if d[2] == 0.0:
        return MISS, UP
    t = -o[2] / d[2]
    return (t, UP) if t >= 0.0 else (MISS, UP)


@kernel
def ray_box(o: Vec, d: Vec, h: Vec) -> tuple[float, Vec]:
    """Slabs: the last entry, or the first exit from inside."""
    enter, leave, first, last = -math.inf, math.inf, 0, 0
    for k in range(3):
        if d[k] == 0.0:
            if abs(o[k]) > h[k]:
                return MISS, UP
            continue
        reach = math.copysign(h[k], d[k])
        near, far = (-reach - o[k]) / d[k], (reach - o[k]) / d[k]
        if near > enter:
            enter, first = near, k
        if far < leave:
            leave, last = far, k
    if enter > leave or leave < 0.0:
        return MISS, UP
    t, k, sign = (enter, first, -1.0) if enter >= 0.0 else (leave, last, 1.0)
    sign = math.copysign(sign, sign * d[k])
    return t, (sign if k == 0 else 0.0, sign if k == 1 else 0.0, sign if k == 2 else 0.0)


@kernel
def tube(o: Vec, d: Vec, radius: float) -> tuple[float, float]:
    """Entry and exit of the infinite cylinder about z; (inf, -inf) for a miss, (-inf, inf) for a ray inside along it."""
    a = d[0] * d[0] + d[1] * d[1]
    if a < 1e-30:
        if o[0] * o[0] + o[1] * o[1] <= radius * radius:
            return -math.inf, math.inf
        return math.inf, -math.inf
    b = (o[0] * d[0] + o[1] * d[1]) / a
    x, y = o[0] - b * d[0], o[1] - b * d[1]
    root = (radius * radius - x * x - y * y) / a
    if root < 0.0:
        return math.inf, -math.inf
    root = math.sqrt(root)
    return -b - root, -b + root


@kernel
def ray_cylinder(o: Vec, d: Vec, radius: float, half: float) -> tuple[float, Vec]:
    """The tube cut by the two caps."""
    enter, leave = tube(o, d, radius)
    first_cap, last_cap = False, False
    if d[2] == 0.0:
        if abs(o[2]) > half:
            return MISS, UP
    else:
        reach = math.copysign(half, d[2])
        near, far = (-reach - o[2]) / d[2], (reach - o[2]) / d[2]
        if near > enter:
            enter, first_cap = near, True
        if far < leave:
            leave, last_cap = far, True
    if enter > leave or leave < 0.0:
        return MISS, UP
    t, cap = (enter, first_cap) if enter >= 0.0 else (leave, last_cap)
    if cap:
        outward = -d[2] if enter >= 0.0 else d[2]
        return t, (0.0, 0.0, math.copysign(1.0, outward))
    hit = axpy(t, d, o)
    return t, (hit[0] / radius, hit[1] / radius, 0.0)


@kernel
def ray_capsule(o: Vec, d: Vec, radius: float, half: float) -> tuple[float, Vec]:
    """The union of the tube between the caps and the two end spheres: first entry, or last exit from inside."""
    nearest = closest_distance2(o, half)
    inside = nearest < radius * radius
    best, normal = (-1.0 if inside else MISS), UP
    enter, leave = tube(o, d, radius)
    if enter <= leave:
        t = leave if inside else enter
        z = o[2] + t * d[2]
        if abs(z) <= half and t >= 0.0 and math.isfinite(t):
            hit = axpy(t, d, o)
            best, normal = t, (hit[0] / radius, hit[1] / radius, 0.0)
    for end in (-1.0, 1.0):
        centre = (o[0], o[1], o[2] - end * half)
        b = dot(centre, d)
        side = axpy(-b, d, centre)
        root = radius * radius - dot(side, side)
        if root >= 0.0:
            root = math.sqrt(root)
            t = -b + root if inside else -b - root
            if t >= 0.0 and ((t > best) if inside else (t < best)):
                hit = axpy(t, d, centre)
                best, normal = t, scale(1.0 / norm(hit), hit)
    return (best, normal) if best >= 0.0 else (MISS, UP)


@kernel
def ray_ellipsoid(o: Vec, d: Vec, semi_axes: Vec) -> tuple[float, Vec]:
    """The unit sphere, met in coordinates that are divided by the semi-axes."""
    p = (o[0] / semi_axes[0], o[1] / semi_axes[1], o[2] / semi_axes[2])
    u = (d[0] / semi_axes[0], d[1] / semi_axes[1], d[2] / semi_axes[2])
    length2 = dot(u, u)
    middle = dot(p, u) / length2
    side = axpy(-middle, u, p)
    root = (1.0 - dot(side, side)) / length2
    if root < 0.0:
        return MISS, UP
    root = math.sqrt(root)
    t = -middle - root
    if t < 0.0:
        t = -middle + root
    if t < 0.0:
        return MISS, UP
    hit = axpy(t, u, p)
    outward = (hit[0] / semi_axes[0], hit[1] / semi_axes[1], hit[2] / semi_axes[2])
    return t, scale(1.0 / norm(outward), outward)


@kernel
def closest_distance2(o: Vec, half: float) -> float:
    """Squared distance of o from the segment |z| <= half."""
    z = o[2] - min(max(o[2], -half), half)
    return o[0] * o[0] + o[1] * o[1] + z * z


@entry
def cast_rays(floats: Floats, ints: Ints, origins: Floats, directions: Floats, max_range: float, hits: Hits) -> None:
    """Write the first hits, for finite origins (r, 3) and unit directions (r, 3)."""
    shape, pose = floats_of(floats, ints, at.SHAPE), floats_of(floats, ints, at.POSE)
    shape_kind, count = ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.COUNT)
    shapes = count[0, at.SHAPES]
    for s in range(shapes):
        pose_shape(floats_of(floats, ints, at.STATE), shape_kind[s, at.OWNER], shapes_of(floats, ints), s)
    for r in range(origins.shape[0]):
        o, d = load3(origins, r, 0), load3(directions, r, 0)
        best, facing, hit_shape = max_range, UP, -1
        for s in range(shapes):
            away = sub(o, load3(pose, s, 0))
            bound = shape[s, at.BALL_RADIUS]
            if bound < math.inf:
                along = dot(away, d)
                miss2 = dot(away, away) - along * along
                if miss2 > bound * bound * (1.0 + 1e-9) + 1e-12 * dot(away, away) or -along - bound > best or along > bound:
                    continue
            kind = shape_kind[s, at.TYPE]
            m = load9(pose, s, 3)
            lo, ld = tmat_vec(m, away), tmat_vec(m, d)
            t, n = MISS, UP
            if kind == at.SPHERE:
                t, n = ray_sphere(lo, ld, shape[s, at.SIZE])
            elif kind == at.BOX:
                t, n = ray_box(lo, ld, load3(shape, s, at.SIZE))
            elif kind == at.CAPSULE:
                t, n = ray_capsule(lo, ld, shape[s, at.SIZE], shape[s, at.SIZE + 1])
            elif kind == at.CYLINDER:
                t, n = ray_cylinder(lo, ld, shape[s, at.SIZE], shape[s, at.SIZE + 1])
            elif kind == at.ELLIPSOID:
                t, n = ray_ellipsoid(lo, ld, load3(shape, s, at.SIZE))
            elif kind == at.PLANE:
                t, n = ray_plane(lo, ld)
            if t < MISS and (t < best or (t == best and hit_shape < 0)):
                best, facing, hit_shape = t, mat_vec(m, n), s
        hit = hit_shape >= 0
        hits.distance[r] = best if hit else math.inf
        store3(hits.normal, r, 0, facing if hit else (0.0, 0.0, 0.0))
        hits.body[r] = shape_kind[hit_shape, at.OWNER] if hit else -1
        hits.shape[r] = shape_kind[hit_shape, at.PART] if hit else -1


def cast_one_by_one(world: engine.World, origins: Any, directions: Any, max_range: float = math.inf) -> Hits:
    """As `World.cast`."""
    floats, ints = world.save()
    o, d = as_rays(origins, directions)
    check_rays(o, d)
    hits, d = room_for(len(d)), unit(d)
    cast_rays(floats, ints, np.broadcast_to(o, d.shape).copy(), d, max_range, hits)
    if (at.int_table(ints, at.SHAPE_KIND)[:, at.TYPE] >= at.HULL).any():
        cast_on_polyhedra(floats, ints, ray_tree(floats, ints), o, d, max_range, hits)
    return hits
