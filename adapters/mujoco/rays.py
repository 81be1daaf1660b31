"""Rays through the shapes that collide."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from plumbline.adapters.mujoco.shapes import BOTH_GROUP, COLLISION_GROUP
from plumbline.adapters.mujoco.vendor import refuse
from plumbline.adapters.mujoco.world import World
from plumbline.harness.adapter.what_goes_in import check_rays
from plumbline.harness.trajectory import Floats, Hits


def cast(world: World, origins: Floats, directions: Floats, max_range: float) -> Hits:
    """First hit of each ray, one native call for each run of equal origins."""
    m = world.model
    geom, distance, normal = caster(world, origins, directions, max_range)()
    # The engine's cutoff leaves out whole shapes, not hits.
    hit = (geom >= 0) & (distance >= 0) & (distance <= max_range)
    body = np.where(hit, world.indices.owner[np.where(hit, geom, 0)] if m.ngeom else -1, -1)
    return Hits(np.where(hit, distance, np.inf), body.astype(np.int64), np.where(hit[:, None], normal, 0.0))


def caster(world: World, origins: Floats, directions: Floats, max_range: float) -> Callable[[], tuple[Any, Floats, Floats]]:
    """A function that casts these rays and gives geoms (r,), distances (r,) m, -1 for none, and normals (r, 3)."""
    check_rays(origins, directions, max_range)
    mj, m, d = world.mj, world.model, world.state
    start = np.ascontiguousarray(origins, dtype=np.float64)
    ray = np.ascontiguousarray(directions, dtype=np.float64)
    r = len(ray)
    geom, distance, normal = np.full(r, -1, dtype=np.int32), np.full(r, -1.0), np.zeros((r, 3))
    seen = np.array([group in (BOTH_GROUP, COLLISION_GROUP) for group in range(6)], dtype=np.uint8)
    turns = np.flatnonzero((start[1:] != start[:-1]).any(axis=1)) + 1
    runs = [
        (start[a], ray[a:b].reshape(-1), geom[a:b], distance[a:b], normal[a:b].reshape(-1), b - a)
        for a, b in pairwise([0, *turns.tolist(), r] if r else [])
    ]

    if "normal" not in str(mj.mj_multiRay.__doc__):
        refuse(mj, "the normals of rays")

    def cast() -> tuple[Any, Floats, Floats]:
        mj.mj_kinematics(m, d)
        for origin, rays, geoms, distances, normals, count in runs:
            mj.mj_multiRay(m, d, origin, rays, seen, True, -1, geoms, distances, normals, count, max_range)
        return geom, distance, normal

    return cast
