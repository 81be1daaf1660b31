"""The planted faults of pictures: each spoils what a camera is told, or one channel of what it saw."""

from dataclasses import replace

import numpy as np

from harness.conformance.faults.plant import Wrapped
from harness.scene import Camera
from harness.trajectory import Floats, Image

__all__ = [
    "DistantNearPlane",
    "EncodedColours",
    "HalfAPixelOff",
    "MisnamedBodies",
    "RangeForDepth",
    "ShadowsLeftOut",
]


class RangeForDepth(Wrapped):
    """Gives the distance from the pinhole where the depth along the axis is meant."""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """As inside, each depth times the length of its pixel's direction."""
        seen = self.inner.render(camera, colour)
        u = (np.arange(camera.width) + 0.5 - camera.centre_x) / camera.focal_x
        v = (np.arange(camera.height) + 0.5 - camera.centre_y) / camera.focal_y
        long: Floats = np.sqrt(1.0 + u[None, :] ** 2 + v[:, None] ** 2)
        return replace(seen, depth=seen.depth * long)


class HalfAPixelOff(Wrapped):
    """Takes the centre of the first pixel to be at (0, 0)."""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """As inside, of a camera moved by half a pixel."""
        moved = replace(camera, centre_x=camera.centre_x + 0.5, centre_y=camera.centre_y + 0.5)
        return self.inner.render(moved, colour)


class MisnamedBodies(Wrapped):
    """Counts bodies from 1, as engines do whose first number is the world's."""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """As inside, the numbers moved up by one."""
        seen = self.inner.render(camera, colour)
        return replace(seen, body=np.where(seen.body >= 0, seen.body + 1, -1))


class DistantNearPlane(Wrapped):
    """Cuts what lies nearer than half a metre."""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """As inside, without what is near."""
        seen = self.inner.render(camera, colour)
        near = seen.depth < 0.5
        return replace(seen, depth=np.where(near, np.inf, seen.depth), body=np.where(near, -1, seen.body))


class EncodedColours(Wrapped):
    """Gives colours as screens want them."""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """As inside, to the power of 1 / 2.2."""
        seen = self.inner.render(camera, colour)
        return seen if seen.colour is None else replace(seen, colour=seen.colour ** (1 / 2.2))


class ShadowsLeftOut(Wrapped):
    """Draws by its rasteriser whatever is asked for."""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """As inside, rasterised."""
        return self.inner.render(replace(camera, renderer="rasterised", distortion=None), colour)
