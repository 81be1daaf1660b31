"""A picture of solids: sun and sky on what is met, shadows on it and on the ground, and the page's own colour behind."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plumbline.reports.drawn.backdrop import GRAIN, SUN, Backdrop
from plumbline.reports.drawn.first_hits import FirstHits, first_hits
from plumbline.reports.drawn.solids import DrawnSolid
from plumbline.reports.drawn.view import View
from plumbline.reports.recordings.pixels import srgb
from plumbline.reports.recordings.rotation import Floats

SUNLIGHT, SKY, BOUNCE = 0.78, 0.42, 0.20
"""Of a surface that faces each: the sun, the sky above, what the ground throws back."""
GLOSS, SHARP = 0.10, 24
GROUND = np.array([0.50, 0.55, 0.62])
SHADOW_ALPHA = 0.42
"""How much of the page a shadow on the ground hides."""


def picture(backdrop: Backdrop, solids: Sequence[DrawnSolid]) -> NDArray[np.uint8]:
    """Pixels (h, w, 4) of colour and opacity, as a screen shows them."""
    fine, sun = backdrop.fine, backdrop.sun
    hits, lit_from = first_hits(fine, solids), first_hits(sun, solids, shaded=False).height
    met = np.isfinite(hits.height)
    dark = SHADOW_ALPHA * _shadow(backdrop, lit_from)
    alpha = 1.0 - (1.0 - backdrop.tint) * (1.0 - dark)
    colour = (backdrop.tint * (1.0 - dark))[..., None] * GROUND  # times its opacity, as all that follows
    normal_W = hits.normal[met] @ fine.R
    points = fine.points(np.where(met, hits.height, 0.0))[met]
    colour[met] = _lit(hits, met, normal_W, fine.R[2], _sunny(sun, lit_from, points + normal_W * 2.5 * sun.pixel))
    alpha[met] = 1.0
    return _coarse(colour, alpha)


def _shadow(backdrop: Backdrop, height: Floats) -> Floats:
    """How dark each sample of the ground is, 0..1: the sun's picture of what stands above it, blurred once."""
    if backdrop.above is None:
        return np.zeros(backdrop.tint.shape)
    dark = np.pad((height > backdrop.above).astype(np.float64), 2)
    for axis in (0, 1):
        dark = np.add.reduce([np.roll(dark, k, axis=axis) for k in range(-2, 3)]) / 5.0
    shadow: Floats = dark[backdrop.v, backdrop.u]
    return shadow


def _sunny(view: View, height: Floats, points: Floats) -> Floats:
    """How much of the sun reaches points (n, 3) m: the mean over nine pixels of the sun's picture, so that edges are soft."""
    seen = view.seen(points)
    u = np.clip(np.floor(seen[:, 0] / view.pixel + view.width / 2).astype(int), 1, view.width - 2)
    v = np.clip(np.floor(view.height / 2 - seen[:, 1] / view.pixel).astype(int), 1, view.height - 2)
    near, flat = seen[:, 2] + 1.5 * view.pixel, height.ravel()
    place = v * view.width + u
    reached: Floats = np.zeros(len(points))
    for dv in (-1, 0, 1):
        for du in (-1, 0, 1):
            reached += flat[place + dv * view.width + du] <= near
    return reached / 9.0


def _lit(hits: FirstHits, met: Floats, normal: Floats, towards: Floats, sunny: Floats) -> Floats:
    """Linear light (n, 3) of what is met: Lambert under a sun and a sky, with a little gloss (Blinn, 1977)."""
    direct = np.clip(normal @ SUN, 0.0, 1.0) * sunny
    around = SKY * (0.5 + 0.5 * normal[:, 2]) + BOUNCE * (0.5 - 0.5 * normal[:, 2])
    halfway = (SUN + towards) / np.linalg.norm(SUN + towards)
    gloss = GLOSS * np.clip(normal @ halfway, 0.0, 1.0) ** SHARP * sunny
    light: Floats = hits.paint[met] * (SUNLIGHT * direct + around)[:, None] + gloss[:, None]
    return light


def _coarse(colour: Floats, alpha: Floats) -> NDArray[np.uint8]:
    """Means over each pixel's samples. Args: colour (h, w, 3): linear light times opacity."""
    covered, painted = (
        np.add.reduce([samples[v::GRAIN, u::GRAIN] for v in range(GRAIN) for u in range(GRAIN)]) / GRAIN**2
        for samples in (alpha, colour)
    )
    shown = srgb(painted / np.maximum(covered, 1e-9)[..., None])
    pixels: NDArray[np.uint8] = np.concatenate([shown, np.rint(255 * covered).astype(np.uint8)[..., None]], axis=-1)
    return pixels
