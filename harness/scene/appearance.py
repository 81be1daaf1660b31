"""What light does at a body's surface, and where light comes from."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.values import FROZEN, Axis, NonNegative, Probability


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Appearance:
    """Optics of a surface: of the light that arrives `mirror` is reflected, of the rest `transmission` goes through; the rest
    scatters.

    Terms:
        colour [1]: share of scattered light that is sent back, linear red, green, blue.
        reflectivity [1]: the same at the wavelength of range finders and depth cameras.
        mirror [1]: share reflected at the angle of incidence. transmission [1]: of the rest, the share
        that enters, with Fresnel's reflection beside it, into a solid of this refractive_index [1].
    """

    colour: tuple[Probability, Probability, Probability] = (0.8, 0.8, 0.8)
    reflectivity: Probability = 1.0
    mirror: Probability = 0.0
    transmission: Probability = 0.0
    refractive_index: Annotated[float, Field(ge=1, le=4)] = 1.5

    @property
    def scatters(self) -> float:
        """The share of light that is neither mirrored nor let through."""
        return (1.0 - self.mirror) * (1.0 - self.transmission)


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Sun:
    """Light from one direction and from the whole sky.

    Terms:
        towards_W: to the sun. irradiance [1]: of a surface that faces it; sky [1]: radiance of the sky, the same everywhere, so
        that a white surface under it, with nothing in the way, looks as bright as the sky.
        infrared [1]: sunlight on a surface that faces it over what an active sensor's own light is at 1 m.
    """

    towards_W: Axis = (0.48, 0.36, 0.8)
    irradiance: NonNegative = 1.0
    sky: NonNegative = 0.5
    infrared: NonNegative = 0.0
