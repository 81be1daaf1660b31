"""A picture of solids: sun and sky on what is met, shadows on it and on the ground, and the page's own colour behind.

What all pictures of one view share: its finer grain, the sun's own view, and the ground before shadows fall on it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.reports.drawn.first_hits import FirstHits, first_hits
from plumbline.reports.drawn.solids import DrawnSolid, GroundPlane
from plumbline.reports.drawn.view import View, seen_from
from plumbline.reports.recordings.layout import Floats
from plumbline.reports.recordings.pixels import srgb

SUN = np.array([0.42, -0.50, 0.90]) / np.linalg.norm([0.42, -0.50, 0.90])
"""Towards the sun, in W."""
SHADOWS = 224
"""Pixels a side of the sun's own picture, which says what lies in shadow."""
GRAIN = 2
"""Samples a side of each pixel."""
GROUND_ALPHA, LINE_ALPHA = 0.16, 0.16
"""How much of the page the ground and its lines hide: right on white and on black."""


@dataclass(frozen=True, slots=True, eq=False)
class Backdrop:
    """Terms: fine: the view with its samples. sun: of all that throws shadows.

    tint (h, w): how much of the page the ground hides, 0 where there is none. u, v (h, w): where samples of the ground lie in
    the sun's picture. above (s, s) m: the height there beyond which something stands above the ground.
    """

    fine: View
    sun: View
    tint: Floats
    u: Floats
    v: Floats
    above: Floats | None


def backdrop_of(view: View, ground: GroundPlane | None) -> Backdrop:
    """The backdrop of a view; a ground that is seen edge-on is none."""
    fine = View(view.R, view.middle, view.pixel / GRAIN, view.width * GRAIN, view.height * GRAIN, view.low, view.high)
    room = 0.05 * float((view.high - view.low).max())
    sun = seen_from(SUN, view.low - room, view.high + room, SHADOWS, SHADOWS)
    size = (fine.height, fine.width)
    slope = 0.0 if ground is None else float(ground.normal @ view.R[2])
    if ground is None or slope < 0.05:
        nowhere = np.zeros(size, dtype=np.int64)
        return Backdrop(fine, sun, np.zeros(size), nowhere, nowhere, None)
    points = fine.points(np.zeros(size))
    points += ((ground.p - points) @ ground.normal / slope)[..., None] * view.R[2]
    seen = sun.seen(points)
    u = np.clip(np.floor(seen[..., 0] / sun.pixel + sun.width / 2), -2, sun.width + 1).astype(np.int64) + 2
    v = np.clip(np.floor(sun.height / 2 - seen[..., 1] / sun.pixel), -2, sun.height + 1).astype(np.int64) + 2
    rise = float(ground.normal @ SUN)
    start = sun.points(np.zeros((SHADOWS, SHADOWS)))
    above = None if rise < 0.05 else (ground.p - start) @ ground.normal / rise + 0.5 * sun.pixel
    return Backdrop(fine, sun, GROUND_ALPHA + LINE_ALPHA * _lines(ground, fine, points), u, v, above)


def _lines(ground: GroundPlane, view: View, points: Floats) -> Floats:
    """How much of each point (h, w, 3) m of the ground a line of its grid covers, 0..1."""
    side = np.cross(ground.normal, [0.0, 1.0, 0.0] if abs(ground.normal[1]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    spacing = _round_length(view.pixel * view.width / 7)
    flat = np.stack([(points - ground.p) @ side, (points - ground.p) @ np.cross(ground.normal, side)], axis=-1) / spacing
    from_line = np.abs((flat + 0.5) % 1.0 - 0.5).min(axis=-1) * spacing
    covered: Floats = np.clip(1.3 - from_line / view.pixel, 0.0, 1.0)
    return covered


def _round_length(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten up to a length [m]."""
    decade = 10.0 ** np.floor(np.log10(max(length, 1e-9)))
    return float(decade * max(step for step in (1.0, 2.0, 5.0) if step * decade <= length * (1 + 1e-9)))


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
