"""Where a picture of a scene is taken from: an orthographic view that holds a box, broadside to what lies in it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.reports.recordings.camera import eye_direction
from plumbline.reports.recordings.layout import Floats

Spheres = Sequence[tuple[Floats, Floats]]
"""Centres (n, 3) m and radii (n,) m of what moves, of each run; what most runs hold is shown."""
MARGIN = 1.08
"""How much larger the picture is than what it has to hold."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Parallel rays.

    Terms: R (3, 3): right, up and towards the eye in W. middle (3,) m. pixel [m]: the side of one. low, high (3,) m: the
    corners of what it holds.
    """

    R: Floats
    middle: Floats
    pixel: float
    width: int
    height: int
    low: Floats
    high: Floats

    def seen(self, points: Floats) -> Floats:
        """Points (..., 3) m of W in the view's own axes, from its middle."""
        moved: Floats = (points - self.middle) @ self.R.T
        return moved

    def points(self, height: Floats) -> Floats:
        """Where the middles of pixels lie at a height (h, w) m towards the eye, in W (h, w, 3)."""
        x, y = np.meshgrid(
            (np.arange(self.width) + 0.5 - self.width / 2) * self.pixel,
            (self.height / 2 - np.arange(self.height) - 0.5) * self.pixel,
        )
        found: Floats = np.stack([x, y, height], axis=-1) @ self.R + self.middle
        return found


def framed(low: Floats, high: Floats, width: int, height: int, spheres: Spheres = ()) -> View:
    """The view that holds the box between two corners (3,) m, or of it what lies within spheres where there are any."""
    return seen_from(eye_direction(np.maximum(high - low, 1e-6)), low, high, width, height, spheres)


def seen_from(towards: Floats, low: Floats, high: Floats, width: int, height: int, spheres: Spheres = ()) -> View:
    """The same from a direction (3,) that points from the box to the eye, and not straight up."""
    right = np.cross([0.0, 0.0, 1.0], towards)
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(towards, right), towards])
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]) @ R.T
    least, most = corners.min(axis=0), corners.max(axis=0)
    if spheres:
        seen = [(centres @ R.T, radii[:, None]) for centres, radii in spheres]
        least = np.maximum(least, np.median([(p - r).min(axis=0) for p, r in seen], axis=0))
        most = np.minimum(most, np.median([(p + r).max(axis=0) for p, r in seen], axis=0))
    wide = np.maximum(most - least, 1e-9)
    pixel = MARGIN * max(wide[0] / width, wide[1] / height)
    return View(R, R.T @ ((least + most) / 2), float(pixel), width, height, low, high)
