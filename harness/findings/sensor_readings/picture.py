"""The first picture of a camera, and the truth's, small enough to stand on a page beside those of other engines."""

from dataclasses import dataclass

import numpy as np

from plumbline.harness.findings.sensor_readings.channel import Channel
from plumbline.harness.trajectory import Floats

WIDEST = 240
"""Pixels of a picture's longer side."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraPicture:
    """What was seen: colour (h, w, 3), linear, or depth (h, w) m; the ideal depth beside it where noise was laid over it, and
    the truth where it is told. height, width: of the camera's own picture."""

    seen: Floats
    ideal: Floats | None
    truth: Floats | None
    height: int
    width: int


def first_picture(channel: Channel) -> CameraPicture | None:
    """Of a colour or depth channel; None for any other, or where nothing was seen."""
    if channel.channel not in ("colour", "depth") or len(channel.read) == 0:
        return None
    height, width = channel.read.shape[1:3]
    noisy = not np.array_equal(channel.read[0], channel.ideal[0], equal_nan=True)
    return CameraPicture(
        small(channel.read[0]),
        small(channel.ideal[0]) if noisy else None,
        None if channel.truth is None else small(channel.truth[0]),
        height,
        width,
    )


def small(pixels: Floats) -> Floats:
    """At most WIDEST pixels a side: colours are averaged, of depths one in so many is kept, since a mean of two is none."""
    factor = -(-max(pixels.shape[:2]) // WIDEST)
    if factor == 1:
        return pixels.astype(np.float32)
    if pixels.ndim == 2:
        return pixels[factor // 2 :: factor, factor // 2 :: factor].astype(np.float32)
    height, width = (side // factor * factor for side in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // factor, factor, width // factor, factor, 3)
    averaged: Floats = blocks.mean(axis=(1, 3)).astype(np.float32)
    return averaged
