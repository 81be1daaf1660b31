"""Rays through the shapes of a model."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from plumbline.adapters.newton.vendor import Vendor, view
from plumbline.harness.adapter.what_goes_in import check_rays
from plumbline.harness.trajectory import Floats, Hits


def cast(
    vendor: Vendor,
    model: Any,
    owners: Sequence[int],
    shown: Callable[[], Any],
    origins: Floats,
    directions: Floats,
    max_range: float,
) -> Hits:
    """First hit of each ray within max_range [m]. Args: shown: gives the state whose poses count."""
    distance, shape, normal = caster(vendor, model, shown, origins, directions, max_range)()
    far, number, n = (view(array).copy() for array in (distance, shape, normal))
    met = (number >= 0) & (far >= 0.0) & (far <= max_range)
    body = np.where(met, np.asarray([*owners, -1])[np.where(met, number, -1)], -1)
    long = np.where(met, far, np.inf).astype(np.float64)
    return Hits(long, body.astype(np.int64), np.where(met[:, None], n, 0.0).astype(np.float64))


def caster(
    vendor: Vendor, model: Any, shown: Callable[[], Any], origins: Floats, directions: Floats, max_range: float
) -> Callable[[], tuple[Any, Any, Any]]:
    """A function that casts these rays and gives distances, shapes and normals as arrays of Warp."""
    check_rays(origins, directions, max_range)
    warp, count = vendor.warp, len(directions)
    starts = warp.array(origins.astype(np.float32), dtype=warp.vec3, device="cpu")
    ways = warp.array(directions.astype(np.float32), dtype=warp.vec3, device="cpu")
    worlds = warp.zeros(count, dtype=warp.int32, device="cpu")
    distance, shape = warp.full(count, -1.0, dtype=float, device="cpu"), warp.full(count, -1, dtype=warp.int32, device="cpu")
    normal = warp.zeros(count, dtype=warp.vec3, device="cpu")

    def meet() -> tuple[Any, Any, Any]:
        if model.shape_count and count:
            model.bvh_refit_shapes(shown())
            vendor.newton.intersect_ray(
                model,
                ray_origins=starts,
                ray_directions=ways,
                ray_worlds=worlds,
                out_dist=distance,
                out_shape_id=shape,
                out_normal=normal,
                fast_math=False,
            )
        return distance, shape, normal

    return meet
