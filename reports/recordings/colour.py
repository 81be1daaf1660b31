"""Colours as rerun takes them: red, green, blue and opacity, 0..255."""

from plumbline.reports.charts.palette import BACKGROUNDS

Rgba = tuple[int, int, int, int]

GHOST: Rgba = (226, 226, 236, 90)
"""The truth: a pale shape that engines are seen through."""

GROUND: Rgba = (74, 82, 94, 255)
"""What never moves."""

GRID: Rgba = (104, 114, 128, 255)
"""Lines on a ground plane, against which motion is seen."""


FLOOR: Rgba = (140, 150, 165, 70)
"""The grid below a motion in free space."""


def rgba(colour: str, opacity: int = 255) -> Rgba:
    """'#rrggbb' as numbers."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue, opacity


BACKGROUND: Rgba = rgba(BACKGROUNDS["dark"])
"""The dark page of the report, against which the engines' colours keep their contrast."""
