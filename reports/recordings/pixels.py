"""Numbers as pixels: linear light in sRGB, depth in shades, and both as a PNG that stands inside a page."""

import base64
import io

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

SHADES = ((253, 231, 37), (94, 201, 98), (33, 145, 140), (59, 82, 139), (68, 1, 84))
"""From near to far: equally spaced anchors of viridis (Smith, van der Walt, 2015), which keeps its order in grey."""
INVALID = (214, 60, 110)
"""A pixel that measured nothing."""
BEYOND = (38, 44, 52)
"""A pixel whose depth lies out of bounds."""


def srgb(linear: NDArray[np.floating]) -> Pixels:
    """Linear red, green, blue in 0..1 as sRGB bytes, shape kept; what is brighter is white, what is no number magenta.

    Source: IEC 61966-2-1:1999, section 4.
    """
    light = np.clip(np.nan_to_num(linear, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    curved = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.power(light, 1 / 2.4) - 0.055)
    pixels: Pixels = np.rint(255.0 * curved).astype(np.uint8)
    pixels[np.isnan(linear).any(axis=-1)] = INVALID
    return pixels


def shaded(depth: NDArray[np.floating], near: float, far: float) -> Pixels:
    """Depth (h, w) m as colours (h, w, 3) from `near` to `far` [m]; NaN and infinities in colours of their own."""
    share = np.clip((np.nan_to_num(depth, nan=far, posinf=far, neginf=near) - near) / max(far - near, 1e-12), 0.0, 1.0)
    anchors = np.linspace(0.0, 1.0, len(SHADES))
    pixels: Pixels = np.rint(
        np.stack([np.interp(share, anchors, channel) for channel in zip(*SHADES, strict=True)], axis=-1)
    ).astype(np.uint8)
    pixels[np.isinf(depth)] = BEYOND
    pixels[np.isnan(depth)] = INVALID
    return pixels


def data_uri(pixels: Pixels) -> str:
    """A picture (h, w, 3) as the address of a PNG that holds itself."""
    from PIL import Image  # late: only a report with pictures needs it

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", optimize=True)
    return f"data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode('ascii')}"
