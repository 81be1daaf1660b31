"""How the scene of a trial departs from its case's: effects switched on or off, damping added.

The case stays what it is, its truth and its checks too; what the departure does to the answer is what a study asks.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from harness.scene import Effect, Scene

__all__ = ["AS_IT_IS", "Alteration"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Alteration:
    """A departure from a scene, by a name that tables show.

    Terms:
        widen, narrow: effects switched on or off whatever the scene says; where one is in both, it is off.
        linear_damping, angular_damping [1/s]: added to what each movable body has.
    """

    name: str = ""
    widen: Effect = Effect.NONE
    narrow: Effect = Effect.NONE
    linear_damping: float = 0.0
    angular_damping: float = 0.0

    def of(self, scene: Scene) -> Scene:
        """The scene as it is under this alteration; the very same one where nothing departs."""
        if self == replace(AS_IT_IS, name=self.name):
            return scene
        bodies = scene.bodies
        if self.linear_damping or self.angular_damping:
            bodies = tuple(
                replace(
                    body,
                    linear_damping=body.linear_damping + self.linear_damping,
                    angular_damping=body.angular_damping + self.angular_damping,
                )
                if body.movable
                else body
                for body in bodies
            )
        return replace(
            scene,
            bodies=bodies,
            widen=(scene.widen | self.widen) & ~self.narrow,
            narrow=(scene.narrow & ~self.widen) | self.narrow,
        )

    def plain(self) -> dict[str, Any]:
        """What departs, as a JSON-ready mapping; empty where nothing does. `from_plain` reads it back."""
        said: dict[str, Any] = {}
        for one in fields(self):
            value = getattr(self, one.name)
            if value != one.default:
                said[one.name] = list(value.names) if isinstance(value, Effect) else value
        return said

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Alteration":
        """Read back what `plain` wrote."""
        said: dict[str, Any] = {name: _effects(value) if isinstance(value, list) else value for name, value in plain.items()}
        return cls(**said)


def _effects(names: list[str]) -> Effect:
    total = Effect.NONE
    for name in names:
        total |= Effect[name.upper()]
    return total


AS_IT_IS = Alteration()
"""No departure."""
