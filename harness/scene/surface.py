"""The law of contact between a pair of materials."""

from typing import Self

from pydantic.dataclasses import dataclass

from plumbline.harness.scene.values import FROZEN, Name, NonNegative, Probability


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Surface:
    """What happens where two materials touch: a value per pair, so that no engine's combination rule decides.

    Terms:
        between: the two materials; order does not matter.
        static_friction, kinetic_friction [1]: Coulomb's coefficients, static >= kinetic.
        restitution [1]: normal speed after an impact over the speed before it, 0..1.
        rolling_friction, torsional_friction [m]: greatest moment over normal force, about axes in and across the plane.
    """

    between: tuple[Name, Name] = ("default", "default")
    static_friction: NonNegative = 0.0
    kinetic_friction: NonNegative = 0.0
    restitution: Probability = 0.0
    rolling_friction: NonNegative = 0.0
    torsional_friction: NonNegative = 0.0

    @classmethod
    def rough(cls, friction: float, between: tuple[str, str] = ("default", "default"), **fields: float) -> Self:
        """A surface with one coefficient, static and kinetic. Args: fields: the others of a surface."""
        return cls(between=between, static_friction=friction, kinetic_friction=friction, **fields)

    def __post_init__(self) -> None:
        if self.static_friction < self.kinetic_friction:
            raise ValueError(
                f"surface {self.between[0]}/{self.between[1]}: static_friction {self.static_friction} "
                f"lies below kinetic_friction {self.kinetic_friction}"
            )

    @property
    def pair(self) -> frozenset[str]:
        """The two materials without order."""
        return frozenset(self.between)
