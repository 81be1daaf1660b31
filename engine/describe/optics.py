"""What light does at the surface of a body, and where it comes from."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from plumbline.engine.describe.check import Described, between, direction, finite, not_negative


def _shares(label: str, field: str, value: Sequence[float]) -> None:
    """Raises: ValueError unless it is three shares."""
    for one in finite(label, field, value, (3,), "1"):
        between(label, field, float(one), 0, 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Optics(Described):
    """Of the light that arrives, `mirror` is reflected, of the rest `transmission` meets a clear solid, what is left scatters.

    Terms:
        colour [1]: share of scattered light that is sent back evenly (Lambert), linear red, green, blue. mirror [1]: the same
        at all angles. transmission [1]: share of the rest that Fresnel's equations split into reflected and refracted light, at
        a solid of this refractive_index [1] in air of index 1.
    """

    colour: Annotated[Sequence[float], _shares] = (0.8, 0.8, 0.8)
    mirror: Annotated[float, between, 0, 1] = 0.0
    transmission: Annotated[float, between, 0, 1] = 0.0
    refractive_index: Annotated[float, between, 1, 4] = 1.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Sun(Described):
    """Light from one direction and from the whole sky.

    Terms:
        towards_W: to the sun, of any length. irradiance [1]: of a surface that faces it; a white one then has the radiance
        irradiance / pi. sky [1]: radiance of the sky, the same everywhere.
    """

    towards_W: Annotated[Sequence[float], direction] = (0.48, 0.36, 0.8)
    irradiance: Annotated[float, not_negative, ""] = 1.0
    sky: Annotated[float, not_negative, ""] = 0.5
