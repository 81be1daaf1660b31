"""Rays, cast one by one by the engine's own query pipeline."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from plumbline.harness.adapter.what_goes_in import check_rays
from plumbline.harness.trajectory import Floats, Hits


def caster(rapier: Any, world: Any, origins: Floats, directions: Floats, reach: float) -> Callable[[], list[Any]]:
    """A function that casts these rays into the bodies as they lie now. Raises: ValueError."""
    check_rays(origins, directions, reach)
    world.update_query_pipeline()
    meets = world.query_pipeline.cast_ray_and_get_normal
    rays = [rapier.Ray(o, d) for o, d in zip(origins.tolist(), directions.tolist(), strict=True)]
    return lambda: [meets(ray, reach, False) for ray in rays]


def cast(rapier: Any, world: Any, owners: Mapping[int, int], origins: Floats, directions: Floats, reach: float) -> Hits:
    """First hits, see `Simulation.cast`.

    From within a solid Rapier gives the exit with a normal against the ray: it is turned about where the ray starts within what
    it meets.

    Args: owners: by the index of a collider, the place of its body.
    """
    crossings = caster(rapier, world, origins, directions, reach)()
    hits = Hits(np.full(len(crossings), np.inf), np.full(len(crossings), -1, dtype=np.int64), np.zeros((len(crossings), 3)))
    around: dict[tuple[float, ...], set[int]] = {}
    for k, hit in enumerate(crossings):
        if hit is None or hit[1].toi > reach:
            continue
        collider, crossing = hit
        start = tuple(origins[k].tolist())
        if start not in around:
            within: set[int] = set()
            world.query_pipeline.intersect_point(start, lambda handle, within=within: within.add(handle.index) or True)
            around[start] = within
        normal = np.array((crossing.normal.x, crossing.normal.y, crossing.normal.z))
        inside = collider.index in around[start]
        hits.distance[k], hits.body[k] = crossing.toi, owners[collider.index]
        hits.normal_W[k] = normal if inside == (normal @ directions[k] > 0) else -normal
    return hits
