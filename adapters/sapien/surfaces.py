"""Friction and restitution: numbers for each material whose means are the laws of the pairs; who meets whom."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.touching_kinds import Kind, mean_numbers, touching_kinds
from plumbline.harness.scene import Effect, Scene, Surface

_GROUPS = 32


def materials_of(sapien: Any, scene: Scene) -> dict[Kind, Any]:
    """PhysX's material of each kind of body that touches. Raises: Unsupported."""
    effects = scene.effects
    if Effect.CONTACT not in effects:
        return {}
    pairs = touching_kinds(scene)
    for law in pairs.values():
        where = f"surface {law.between[0]}/{law.between[1]}"
        if Effect.ROLLING_FRICTION in effects and law.rolling_friction > 0:
            raise Unsupported(where, "PhysX has no rolling friction")
        if Effect.FRICTION in effects and law.static_friction > law.kinetic_friction:
            raise Unsupported(where, "PhysX holds a box at a slope of .45 between .4 and .6 and lets it slide at .5")
    rubs, bounces = Effect.FRICTION in effects, Effect.RESTITUTION in effects
    friction = _mean(pairs, "kinetic_friction") if rubs else {}
    restitution = _mean(pairs, "restitution") if bounces else {}
    kinds = {(body.material, body.movable) for body in scene.bodies if body.collision}
    return {k: sapien.physx.PhysxMaterial(*(law.get(k, 0.0) for law in (friction, friction, restitution))) for k in kinds}


def patches_of(scene: Scene) -> dict[Kind, float]:
    """Radii [m] of patches by kind of body: of two the larger times mu N is what brakes a spin. Raises: Unsupported."""
    if Effect.CONTACT | Effect.TORSIONAL_FRICTION not in scene.effects:
        return {}
    levers = {
        pair: law.torsional_friction / law.kinetic_friction if law.torsional_friction > 0 else 0.0
        for pair, law in touching_kinds(scene).items()
        if law.kinetic_friction > 0 or law.torsional_friction == 0
    }
    least: dict[Kind, float] = {}
    for pair, lever in levers.items():
        least |= {kind: min(lever, least.get(kind, lever)) for kind in pair}
    for pair, law in touching_kinds(scene).items():
        if pair not in levers or max(least[kind] for kind in pair) != levers[pair]:
            raise Unsupported(
                f"torsional friction of {law.between[0]}/{law.between[1]}",
                "PhysX takes the larger of two radii, one for each material, times mu N; none give every pair its value",
            )
    return least


def groups_of(scene: Scene) -> dict[str, tuple[int, int]]:
    """By material its type and its affinity, bits that keep it from what stands apart. Raises: Unsupported."""
    materials = sorted({body.material for body in scene.bodies if body.collision})
    if not scene.apart:
        return dict.fromkeys(materials, (1, 1))
    if len(materials) > _GROUPS:
        raise Unsupported(f"apart among {len(materials)} materials", f"SAPIEN has {_GROUPS} types of contact")
    bits = {material: 1 << k for k, material in enumerate(materials)}
    affinity = dict.fromkeys(materials, (1 << _GROUPS) - 1)
    for a, b in scene.apart:
        if a in bits and b in bits:
            affinity[a] &= ~bits[b]
            affinity[b] &= ~bits[a]
    return {material: (bits[material], affinity[material]) for material in materials}


def _mean(pairs: Mapping[tuple[Kind, Kind], Surface], name: str) -> dict[Kind, float]:
    """Numbers with (r_a + r_b)/2 = value for each pair. Raises: Unsupported."""
    numbers, missed = mean_numbers(pairs, name)
    if missed is not None:
        raise Unsupported(
            f"{name.replace('_', ' ')} of {missed.between[0]}/{missed.between[1]}",
            "SAPIEN takes the mean of two numbers, one for each material; none give every pair its value",
        )
    return numbers
