"""What light does at the surface of a body, and where it comes from."""

from collections.abc import Sequence
from dataclasses import dataclass

from plumbline.engine.describe.check import direction, finite, not_negative, number


def _share(label: str, field: str, value: float) -> None:
    """Raises: ValueError unless the value lies between 0 and 1."""
    if not 0.0 <= number(label, field, value) <= 1.0:
        raise ValueError(f"{label}: {field} {value}, expected 0 to 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class Optics:
    """Of the light that arrives, `mirror` is reflected, of the rest `transmission` meets a clear solid, what is left scatters.

    Terms:
        colour [1]: share of scattered light that is sent back evenly (Lambert), linear red, green, blue. mirror [1]: the same
        at all angles. transmission [1]: share of the rest that Fresnel's equations split into reflected and refracted light, at
        a solid of this refractive_index [1] in air of index 1.
    """

    colour: Sequence[float] = (0.8, 0.8, 0.8)
    mirror: float = 0.0
    transmission: float = 0.0
    refractive_index: float = 1.5

    def __post_init__(self) -> None:
        for one in finite("optics", "colour", self.colour, (3,), "1"):
            _share("optics", "colour", float(one))
        _share("optics", "mirror", self.mirror)
        _share("optics", "transmission", self.transmission)
        if not 1.0 <= number("optics", "refractive_index", self.refractive_index) <= 4.0:
            raise ValueError(f"optics: refractive_index {self.refractive_index}, expected 1 to 4")


@dataclass(frozen=True, slots=True, kw_only=True)
class Sun:
    """Light from one direction and from the whole sky.

    Terms:
        towards_W: to the sun, of any length. irradiance [1]: of a surface that faces it; a white one then has the radiance
        irradiance / pi. sky [1]: radiance of the sky, the same everywhere.
    """

    towards_W: Sequence[float] = (0.48, 0.36, 0.8)
    irradiance: float = 1.0
    sky: float = 0.5

    def __post_init__(self) -> None:
        direction("sun", "towards_W", self.towards_W)
        not_negative("sun", "irradiance", self.irradiance, "")
        not_negative("sun", "sky", self.sky, "")
