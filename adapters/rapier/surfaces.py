"""The law of contact of each pair: numbers on the colliders where all pairs have the same, a hook of the solver elsewhere."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.touching_kinds import touching_kinds
from plumbline.harness.scene import Effect, Scene

Law = tuple[float, float]
"""Friction and restitution."""
_GROUPS = 32


def laws_of(scene: Scene) -> dict[frozenset[str], Law]:
    """Friction and restitution by pair of materials that can touch. Raises: Unsupported."""
    effects, laws = scene.effects, dict[frozenset[str], Law]()
    if Effect.CONTACT not in effects:
        return laws
    for law in touching_kinds(scene).values():
        where = f"surface {law.between[0]}/{law.between[1]}"
        if Effect.ROLLING_FRICTION in effects and law.rolling_friction > 0:
            raise Unsupported(where, "Rapier has no rolling friction")
        if Effect.TORSIONAL_FRICTION in effects and law.torsional_friction > 0:
            raise Unsupported(where, "Rapier has no coefficient of torsional friction")
        if Effect.FRICTION in effects and law.static_friction > law.kinetic_friction:
            raise Unsupported(where, "Rapier has one coefficient of friction; static and kinetic differ")
        mu = law.kinetic_friction if Effect.FRICTION in effects else 0.0
        laws[law.pair] = mu, law.restitution if Effect.RESTITUTION in effects else 0.0
    return laws


def groups_of(rapier: Any, scene: Scene) -> dict[str, Any]:
    """By material, the interaction groups that keep it from those that stand apart from it. Raises: Unsupported."""
    if not scene.apart:
        return {}
    materials = sorted({body.material for body in scene.bodies if body.collision})
    if len(materials) > _GROUPS:
        raise Unsupported(f"apart among {len(materials)} materials", f"Rapier has {_GROUPS} groups of interaction")
    bit = {material: 1 << k for k, material in enumerate(materials)}
    shunned = dict.fromkeys(materials, 0)
    for a, b in scene.apart:
        for own, other in ((a, b), (b, a)):
            if own in shunned and other in bit:
                shunned[own] |= bit[other]
    both = (1 << _GROUPS) - 1
    return {
        m: rapier.InteractionGroups(rapier.Group(bit[m]), rapier.Group(both & ~shunned[m]), rapier.InteractionTestMode.AND)
        for m in materials
    }


@dataclass(slots=True)
class PairLaws:
    """The vendor's hooks: what is asked of each pair that touches, in each step.

    Terms: laws: by pair of materials. materials: by the index of a collider.
    """

    laws: Mapping[frozenset[str], Law]
    materials: Mapping[int, str]
    solved: Any

    def filter_contact_pair(self, _pair: Any) -> Any:
        """Every pair that the groups let through is solved."""
        return self.solved

    def filter_intersection_pair(self, _pair: Any) -> bool:
        """There are no sensors."""
        return True

    def modify_solver_contacts(self, pair: Any) -> None:
        """Give a pair its law."""
        both = frozenset((self.materials[pair.collider1.index], self.materials[pair.collider2.index]))
        pair.friction, pair.restitution = self.laws.get(both, (0.0, 0.0))
