"""Rays of light followed surface by surface, all of one generation at once, so that each generation is one cast.

The order of rays, and with it every sum, depends on the picture alone: any number of threads gives the same bits.

Source: Wald, Slusallek, Benthin, Wagner, Interactive Rendering with Coherent Ray Tracing, 2001 (rays in groups); Whitted, An
Improved Illumination Model for Shaded Display, 1980.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.images.scatter import AIR, GIVEN, add_unshaded, scatter

__all__ = ["Light", "Wave", "first_wave", "follow"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Cast = Callable[[FloatArray, FloatArray], Any]
"""World.cast of origins and directions."""


@dataclass(frozen=True, slots=True)
class Wave:
    """One generation of rays: origins (n, 3) or (1, 3) m, directions (n, 3), light (n, 5), roots (n, 3), and what they hit."""

    origins: FloatArray
    directions: FloatArray
    light: FloatArray
    roots: IntArray
    hits: Any


@dataclass(frozen=True, slots=True)
class Light:
    """How light goes on: optics (bodies, 6), sun (1, 5), most surfaces one after the other, rays to the sky."""

    optics: FloatArray
    sun: FloatArray
    bounces: int
    sky_rays: int


def first_wave(origins: FloatArray, directions: FloatArray, hits: Any, pixels: IntArray) -> Wave:
    """Rays of weight 1 in air, each for the pixel of its own."""
    light = np.ones((len(directions), 5))
    light[:, 3:] = AIR
    roots = np.column_stack([pixels, np.full(len(pixels), -1), np.full(len(pixels), GIVEN)])
    return Wave(origins, directions, light, roots, hits)


def follow(cast: Cast, wave: Wave, light: Light, sample: int, radiance: FloatArray) -> Iterator[Wave]:
    """Yield each generation, adding to radiance (pixels, 3) what the rays bring."""
    for bounce in range(light.bounces + 1):
        n, hits = len(wave.directions), wave.hits
        last = bounce == light.bounces
        room = 0 if last else n * (3 + light.sky_rays)
        origins, directions, weights = np.empty((room, 3)), np.empty((room, 3)), np.empty((room, 5))
        roots, lit, gain, lit_root = np.empty((room, 3), np.int64), np.empty((n, 3)), np.empty((n, 3)), np.empty(n, np.int64)
        more, asking = scatter(
            wave.origins, wave.directions, wave.light, wave.roots, hits.distance, hits.body, hits.normal, light.optics,
            light.sun, last, light.sky_rays, sample, radiance, origins, directions, weights, roots, lit, gain, lit_root,
        )  # fmt: skip
        if asking > 0:
            towards = np.broadcast_to(light.sun[0, :3], (asking, 3)).copy()
            add_unshaded(cast(lit[:asking], towards).distance, gain, lit_root, radiance)
        yield wave
        if more == 0:
            return
        origins, directions = origins[:more], directions[:more]
        wave = Wave(origins, directions, weights[:more], roots[:more], cast(origins, directions))
