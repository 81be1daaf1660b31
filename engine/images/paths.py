"""The ways of single rays of light through mirrors and clear solids, to look at one by one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.optics import Sun
from plumbline.engine.images.tables import lighting_of
from plumbline.engine.maths.arrays import unit
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.rays.hits import Cast

KINDS = ("given", "mirrored", "reflected", "refracted")


@dataclass(frozen=True, slots=True)
class Paths:
    """Straight pieces of light's way, generation after generation.

    Terms:
        parent (k,): the piece before, -1 for a given ray; kind (k,): given, mirrored, reflected or refracted; start (k, 3) m;
        direction (k, 3), unit; end (k, 3) m, infinite if nothing is met; body (k,): what is met, -1 for nothing; weight (k,):
        share of the light of the given ray.
    """

    parent: Ints
    kind: NDArray[np.str_]
    start: Floats
    direction: Floats
    end: Floats
    body: Ints
    weight: Floats


def traced_paths(cast: Cast, bodies: Sequence[Body], origins: Floats, directions: Floats, bounces: int) -> Paths:
    """All pieces of rays with origins (r, 3) m and directions (r, 3) over so many surfaces; scattering ends a way."""
    from plumbline.engine.images.waves import Light, first_wave, follow

    light = Light(lighting_of(bodies, Sun(irradiance=0.0)), bounces, 0)
    count = len(directions)
    wave, radiance = first_wave(origins, directions, cast(origins, directions), np.arange(count)), np.zeros((count, 3))
    waves = list(follow(cast, wave, light, 0, radiance))
    sizes = [len(one.rays.directions) for one in waves]
    shift = np.repeat(np.cumsum([0, 0, *sizes])[: len(sizes)], sizes)
    way = np.concatenate([one.rays.directions for one in waves])
    way = unit(way)
    start, roots = np.concatenate([one.rays.origins for one in waves]), np.concatenate([one.rays.roots for one in waves])
    distance = np.concatenate([one.hits.distance for one in waves])
    with np.errstate(invalid="ignore"):
        end = np.where(np.isfinite(distance)[:, None], start + distance[:, None] * way, np.inf)
    return Paths(
        parent=np.where(roots[:, 1] < 0, -1, roots[:, 1] + shift),
        kind=np.array(KINDS)[roots[:, 2]],
        start=start,
        direction=way,
        end=end,
        body=np.concatenate([one.hits.body for one in waves]),
        weight=np.concatenate([one.rays.light[:, 0] for one in waves]),
    )
