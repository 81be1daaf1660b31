"""What all pictures of one view share: its finer grain, the sun's own view, and the ground before shadows fall on it."""

from dataclasses import dataclass

import numpy as np

from plumbline.reports.drawn.stage_set import GroundPlane
from plumbline.reports.drawn.view import View, seen_from
from plumbline.reports.recordings.rotation import Floats

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
