"""A camera that takes colour pictures: pinhole, lens distortion, and the renderer that draws what it sees."""

from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.mount import Mount
from plumbline.harness.scene.values import FROZEN, Finite, Positive

Pixels = Annotated[int, Field(ge=1, le=16384)]
Renderer = Literal["rasterised", "ray_traced"]
"""A z-buffer, or rays with shadows, reflection and refraction."""


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Distortion:
    """Lens distortion of normalised image coordinates (x, y) at r^2 = x^2 + y^2.

    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), y' = y (...) + p1 (r^2 + 2 y^2) + 2 p2 x y.
    Source: Brown, Decentering Distortion of Lenses, Photogrammetric Engineering 32 (1966) 444.
    """

    k1: Finite = 0.0
    k2: Finite = 0.0
    k3: Finite = 0.0
    p1: Finite = 0.0
    p2: Finite = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Pinhole(Mount):
    """Looks along +z of S with x right and y down; the centre of pixel (0, 0) lies at (0.5, 0.5). All numbers in pixels."""

    width: Pixels = 640
    height: Pixels = 480
    focal_x: Positive = 500.0
    focal_y: Positive = 500.0
    centre_x: Finite = 320.0
    centre_y: Finite = 240.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Camera(Pinhole):
    """A pinhole camera looking along +z of S with x right and y down; the centre of pixel (0, 0) lies at (0.5, 0.5).

    Terms:
        rate [Hz]; width, height [pixels]; focal_x, focal_y, centre_x, centre_y [pixels]; distortion: none is a pinhole.
        renderer: what draws the picture. samples [1]: rays a pixel, for a renderer that traces them.
    """

    distortion: Distortion | None = None
    renderer: Renderer = "rasterised"
    samples: Annotated[int, Field(ge=1, le=1024)] = 1
    type: Literal["camera"] = "camera"

    def __post_init__(self) -> None:
        if self.distortion is not None and self.renderer == "rasterised":
            raise ValueError(f"sensor '{self.name}': a rasteriser draws straight lines; expected renderer 'ray_traced'")
