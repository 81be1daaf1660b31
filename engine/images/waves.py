"""Rays of light followed surface by surface, all of one generation at once, so that each generation is one cast.

The order of rays, and with it every sum, depends on the picture alone: any number of threads gives the same bits.

Source: Wald, Slusallek, Benthin, Wagner, Interactive Rendering with Coherent Ray Tracing, 2001 (rays in groups); Whitted, An
Improved Illumination Model for Shaded Display, 1980.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from plumbline.engine.images.scatter import AIR, GIVEN, Generation, ShadowRays, add_unshaded, scatter
from plumbline.engine.images.tables import Lighting
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.rays.hits import Cast, Hits


@dataclass(frozen=True, slots=True)
class Wave:
    """One generation of rays, and what they hit."""

    rays: Generation
    hits: Hits


@dataclass(frozen=True, slots=True)
class Light:
    """How light goes on: at surfaces and from the sun, most surfaces one after the other, rays to the sky."""

    lighting: Lighting
    bounces: int
    sky_rays: int


def first_wave(origins: Floats, directions: Floats, hits: Hits, pixels: Ints) -> Wave:
    """Rays of weight 1 in air, each for the pixel of its own."""
    light = np.ones((len(directions), 5))
    light[:, 3:] = AIR
    roots = np.column_stack([pixels, np.full(len(pixels), -1), np.full(len(pixels), GIVEN)])
    return Wave(Generation(origins, directions, light, roots), hits)


def follow(cast: Cast, wave: Wave, light: Light, sample: int, radiance: Floats) -> Iterator[Wave]:
    """Yield each generation, adding to radiance (pixels, 3) what the rays bring."""
    for bounce in range(light.bounces + 1):
        n = len(wave.rays.directions)
        room = 0 if bounce == light.bounces else n * (3 + light.sky_rays)
        after = Generation(np.empty((room, 3)), np.empty((room, 3)), np.empty((room, 5)), np.empty((room, 3), np.int64))
        shadow = ShadowRays(np.empty((n, 3)), np.empty((n, 3)), np.empty(n, np.int64))
        more, asking = scatter(wave.rays, wave.hits, light.lighting, light.sky_rays, sample, radiance, after, shadow)
        if asking > 0:
            towards = np.broadcast_to(light.lighting.sun[0, :3], (asking, 3)).copy()
            add_unshaded(cast(shadow.origins[:asking], towards).distance, shadow, radiance)
        yield wave
        if more == 0:
            return
        rays = Generation(after.origins[:more], after.directions[:more], after.light[:more], after.roots[:more])
        wave = Wave(rays, cast(rays.origins, rays.directions))
