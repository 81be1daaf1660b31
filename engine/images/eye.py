"""The camera that a picture is taken with, and the picture."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Annotated

import numpy as np

from plumbline.engine.describe.check import Described, finite, not_negative, number, positive, unit_quaternion, whole
from plumbline.engine.maths.types import Floats, Ints

WIDEST = 16384


def _pixels(element: str, field: str, value: int) -> None:
    """Raises: ValueError unless it is a whole number from 1 to the widest."""
    if whole(element, field, value, 1) > WIDEST:
        raise ValueError(f"{element}: {field} {value} pixels, expected at most {WIDEST}")


def _centre(element: str, field: str, value: float) -> None:
    """Raises: ValueError unless it is a finite number."""
    not_negative(element, f"|{field}|", abs(number(element, field, value)), "pixels")


@dataclass(frozen=True, slots=True, kw_only=True)
class Lens(Described):
    """Radial (k1, k2, k3) and tangential (p1, p2) distortion [1] of normalised image coordinates.

    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), and y' alike with p1 and p2 exchanged.
    Source: Brown, Decentering Distortion of Lenses, Photogrammetric Engineering 32, 1966.
    """

    k1: Annotated[float, finite, (), "1"] = 0.0
    k2: Annotated[float, finite, (), "1"] = 0.0
    k3: Annotated[float, finite, (), "1"] = 0.0
    p1: Annotated[float, finite, (), "1"] = 0.0
    p2: Annotated[float, finite, (), "1"] = 0.0

    @property
    def fold(self) -> float:
        """The radius [1] up to which the radial part grows: beyond it the lens would show two things at one place."""
        squares = np.roots([7 * self.k3, 5 * self.k2, 3 * self.k1, 1.0])
        real = squares.real[(np.abs(squares.imag) <= 1e-9 * np.abs(squares)) & (squares.real > 0)]
        return float(np.sqrt(real.min())) if len(real) else np.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Eye(Described):
    """A pinhole, or a pinhole behind a lens, that looks along z of its frame E with x right and y down.

    Terms:
        p_WE [m], q_WE (w, x, y, z); width, height, focal_x, focal_y, centre_x, centre_y [pixels], the centre of pixel (0, 0) at
        (0.5, 0.5); near [m]: z-depth before which nothing is seen; lens: straight lines stay straight without.
        Of the ray tracer: samples [1] a pixel; bounces [1]: surfaces after which a ray that is not scattered is given up, and
        what it would have brought is taken to be the sky's; sky_rays [1]: directions in which a scattering point looks for the
        sky, 0 if all of it is taken to be in view.
    """

    p_WE: Annotated[Sequence[float], finite, (3,), "m"] = (0.0, 0.0, 0.0)
    q_WE: Annotated[Sequence[float], unit_quaternion] = (1.0, 0.0, 0.0, 0.0)
    width: Annotated[int, _pixels] = 640
    height: Annotated[int, _pixels] = 480
    focal_x: Annotated[float, positive, "pixels"] = 500.0
    focal_y: Annotated[float, positive, "pixels"] = 500.0
    centre_x: Annotated[float, _centre] = 320.0
    centre_y: Annotated[float, _centre] = 240.0
    near: Annotated[float, positive, "m"] = 1e-3
    lens: Lens | None = None
    samples: Annotated[int, whole, 1] = 1
    bounces: Annotated[int, whole, 0] = 12
    sky_rays: Annotated[int, whole, 0] = 0

    def __post_init__(self) -> None:
        self.check_fields()
        if self.lens is not None and not isinstance(self.lens, Lens):
            raise ValueError(f"eye: lens {self.lens!r}, expected a Lens or None")

    @property
    def axes(self) -> Floats:
        """R_WE (3, 3): right, down and ahead as columns."""
        from plumbline.engine.build.solids import quat_mat  # late: it loads the compiler

        return quat_mat(unit_quaternion("eye", "q_WE", self.q_WE))

    @property
    def row(self) -> Floats:
        """(1, 23) for compiled code: p_WE, R_WE by rows, focal lengths, centre, near, then k1, k2, k3, p1, p2 and the fold."""
        lens = self.lens or Lens()
        pinhole = (self.focal_x, self.focal_y, self.centre_x, self.centre_y, self.near)
        return np.array([[*self.p_WE, *self.axes.ravel(), *pinhole, *astuple(lens), lens.fold]], float)


@dataclass(frozen=True, slots=True)
class Picture:
    """What an eye sees.

    Terms:
        depth (h, w) m along its z axis, at the centres of the pixels, inf where nothing is; body (h, w): index, -1 for nothing;
        colour (h, w, 3): radiance, linear red, green, blue, averaged over the pixel where it is sampled; None if not wanted.
    """

    depth: Floats
    body: Ints
    colour: Floats | None
