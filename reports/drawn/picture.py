"""A picture of solids: sun and sky on what is met, shadows on it and on the ground, and the page's own colour behind."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from reports.drawn.first_hits import Hits, first_hits
from reports.drawn.solids import Solid
from reports.drawn.stage_set import Ground
from reports.drawn.view import View, seen_from
from reports.pixels import srgb
from reports.recordings.rotation import Floats

__all__ = ["picture"]

SUN = np.array([0.42, -0.50, 0.90]) / np.linalg.norm([0.42, -0.50, 0.90])
"""Towards the sun, in W."""
SUNLIGHT, SKY, BOUNCE = 0.78, 0.42, 0.20
"""Of a surface that faces each: the sun, the sky above, what the ground throws back."""
GLOSS, SHARP = 0.10, 24
SHADOWS = 224
"""Pixels a side of the sun's own picture, which says what lies in shadow."""
GRAIN = 2
"""Samples a side of each pixel."""
GROUND = np.array([0.50, 0.55, 0.62])
GROUND_ALPHA, SHADOW_ALPHA, LINE_ALPHA = 0.16, 0.42, 0.16
"""How much of the page the ground, a shadow on it and its lines hide: right on white and on black."""


def picture(view: View, solids: Sequence[Solid], ground: Ground | None) -> NDArray[np.uint8]:
    """Pixels (h, w, 4) of colour and opacity, as a screen shows them."""
    fine = View(view.R, view.middle, view.pixel / GRAIN, view.width * GRAIN, view.height * GRAIN)
    hits = first_hits(fine, solids)
    met = np.isfinite(hits.height)
    points = _points(fine, hits.height)
    sun = _sun_view(solids, points[met])
    shade = None if sun is None else (sun, first_hits(sun, solids).height)
    colour, alpha = np.zeros((*met.shape, 3)), met.astype(np.float64)
    normal_W = hits.normal[met] @ fine.R
    colour[met] = _lit(hits, met, normal_W, fine.R[2], _sunny(shade, points[met] + normal_W * 2.5 * (sun.pixel if sun else 0)))
    if ground is not None:
        _lay(ground, fine, shade, colour, alpha, ~met)
    return _coarse(colour, alpha)


def _points(view: View, height: Floats) -> Floats:
    """Where pixels lie at a height (h, w) m towards the eye, in W (h, w, 3)."""
    x, y = np.meshgrid(
        (np.arange(view.width) + 0.5 - view.width / 2) * view.pixel,
        (view.height / 2 - np.arange(view.height) - 0.5) * view.pixel,
    )
    seen = np.stack([x, y, np.where(np.isfinite(height), height, 0.0)], axis=-1)
    points: Floats = seen @ view.R + view.middle
    return points


def _sun_view(solids: Sequence[Solid], points: Floats) -> View | None:
    """The sun's view of all that throws a shadow; None where nothing is seen."""
    if not len(points):
        return None
    reach = np.array([solid.p for solid in solids])
    low, high = np.minimum(points.min(axis=0), reach.min(axis=0)), np.maximum(points.max(axis=0), reach.max(axis=0))
    room = 0.05 * (high - low).max()
    return seen_from(SUN, low - room, high + room, SHADOWS, SHADOWS)


def _sunny(shade: tuple[View, Floats] | None, points: Floats) -> Floats:
    """How much of the sun reaches points (n, 3) m: the mean over nine pixels of the sun's picture, so that edges are soft."""
    if shade is None:
        return np.ones(len(points))
    view, height = shade
    seen = view.seen(points)
    u = np.floor(seen[:, 0] / view.pixel + view.width / 2).astype(int)
    v = np.floor(view.height / 2 - seen[:, 1] / view.pixel).astype(int)
    reached = np.zeros(len(points))
    for du in (-1, 0, 1):
        for dv in (-1, 0, 1):
            inside = (u + du >= 0) & (u + du < view.width) & (v + dv >= 0) & (v + dv < view.height)
            over = np.where(
                inside, height[np.clip(v + dv, 0, view.height - 1), np.clip(u + du, 0, view.width - 1)], -np.inf
            )
            reached += over <= seen[:, 2] + 1.5 * view.pixel
    return reached / 9.0


def _lit(hits: Hits, met: Floats, normal: Floats, towards: Floats, sunny: Floats) -> Floats:
    """Linear light (n, 3) of what is met: Lambert under a sun and a sky, with a little gloss (Blinn, 1977)."""
    direct = np.clip(normal @ SUN, 0.0, 1.0) * sunny
    around = SKY * (0.5 + 0.5 * normal[:, 2]) + BOUNCE * (0.5 - 0.5 * normal[:, 2])
    halfway = (SUN + towards) / np.linalg.norm(SUN + towards)
    gloss = GLOSS * np.clip(normal @ halfway, 0.0, 1.0) ** SHARP * sunny
    light: Floats = hits.paint[met] * (SUNLIGHT * direct + around)[:, None] + gloss[:, None]
    return light


def _lay(ground: Ground, view: View, shade: tuple[View, Floats] | None, colour: Floats, alpha: Floats, free: Floats) -> None:
    """The ground where nothing else is met: an even tint, lines, and the shadows of what stands above it."""
    slope = float(ground.normal @ view.R[2])
    if slope < 0.05:
        return
    start = _points(view, np.zeros(free.shape))[free]
    points = start + ((ground.p - start) @ ground.normal / slope)[:, None] * view.R[2]
    side = np.cross(ground.normal, [0.0, 1.0, 0.0] if abs(ground.normal[1]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    flat = np.stack([(points - ground.p) @ side, (points - ground.p) @ np.cross(ground.normal, side)], axis=1)
    spacing = _round_length(view.pixel * view.width / 7)
    from_line = np.abs((flat / spacing + 0.5) % 1.0 - 0.5) * spacing
    line = np.clip(1.3 - from_line.min(axis=1) / view.pixel, 0.0, 1.0)
    tint = GROUND_ALPHA + LINE_ALPHA * line
    dark = SHADOW_ALPHA * _shadow(ground, shade, points)
    alpha[free] = 1.0 - (1.0 - tint) * (1.0 - dark)
    colour[free] = GROUND * (tint * (1.0 - dark) / np.maximum(alpha[free], 1e-9))[:, None]


def _shadow(ground: Ground, shade: tuple[View, Floats] | None, points: Floats) -> Floats:
    """How dark points (n, 3) m of the ground are, 0..1: the sun's picture of what stands above it, blurred once."""
    rise = float(ground.normal @ SUN)
    if shade is None or rise < 0.05:
        return np.zeros(len(points))
    view, height = shade
    start = _points(view, np.zeros(height.shape))
    above = height > (ground.p - start) @ ground.normal / rise + 0.5 * view.pixel
    blurred = np.pad(above.astype(np.float64), 2)
    blurred = sum(np.roll(blurred, k, axis=0) for k in range(-2, 3)) / 5.0
    blurred = sum(np.roll(blurred, k, axis=1) for k in range(-2, 3)) / 5.0
    seen = view.seen(points)
    u = np.clip(np.floor(seen[:, 0] / view.pixel + view.width / 2), -2, view.width + 1).astype(int) + 2
    v = np.clip(np.floor(view.height / 2 - seen[:, 1] / view.pixel), -2, view.height + 1).astype(int) + 2
    dark: Floats = blurred[v, u]
    return dark


def _round_length(length: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten below a length [m]."""
    decade = 10.0 ** np.floor(np.log10(max(length, 1e-9)))
    return float(decade * max(step for step in (1.0, 2.0, 5.0) if step * decade <= length * (1 + 1e-9)))


def _coarse(colour: Floats, alpha: Floats) -> NDArray[np.uint8]:
    """Means over each pixel's samples, weighted by their opacity."""
    high, wide = alpha.shape[0] // GRAIN, alpha.shape[1] // GRAIN
    covered = alpha.reshape(high, GRAIN, wide, GRAIN).mean(axis=(1, 3))
    painted = (colour * alpha[..., None]).reshape(high, GRAIN, wide, GRAIN, 3).mean(axis=(1, 3))
    shown = srgb(painted / np.maximum(covered, 1e-9)[..., None])
    pixels: NDArray[np.uint8] = np.concatenate([shown, np.rint(255 * covered).astype(np.uint8)[..., None]], axis=-1)
    return pixels
