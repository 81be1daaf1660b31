"""Friction and restitution: numbers for each kind of body from which a solver makes the law of each pair."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.touching_kinds import Kind, mean_numbers, touching_kinds
from plumbline.harness.scene import Effect, Scene, Surface


@dataclass(frozen=True, slots=True)
class Numbers:
    """What a shape is told, by the kind of its body: a coefficient of friction and one of restitution."""

    friction: Mapping[Kind, float]
    restitution: Mapping[Kind, float]


def rebounds(scene: Scene) -> bool:
    """Does some pair that can touch give back a part of its speed?"""
    if Effect.CONTACT not in scene.effects or Effect.RESTITUTION not in scene.effects:
        return False
    return any(law.restitution > 0 for law in touching_kinds(scene).values())


def numbers_of(scene: Scene, solver: str) -> Numbers:
    """The numbers of each kind of body that touches. Raises: Unsupported."""
    effects = scene.effects
    if Effect.CONTACT not in effects:
        return Numbers({}, {})
    pairs = touching_kinds(scene)
    for law in pairs.values():
        where = f"surface {law.between[0]}/{law.between[1]}"
        if Effect.ROLLING_FRICTION in effects and law.rolling_friction > 0:
            raise Unsupported(where, "the adapter tells Newton no rolling friction")
        if Effect.TORSIONAL_FRICTION in effects and law.torsional_friction > 0:
            raise Unsupported(where, "the adapter tells Newton no torsional friction")
        if Effect.FRICTION in effects and law.static_friction > law.kinetic_friction:
            raise Unsupported(where, "Newton has one coefficient of friction; static and kinetic differ")
    rule = _greater if solver == "mujoco" else _mean
    friction = rule(pairs, "kinetic_friction") if Effect.FRICTION in effects else {}
    restitution = _mean(pairs, "restitution") if solver == "xpbd" and Effect.RESTITUTION in effects else {}
    return Numbers(friction, restitution)


def _greater(pairs: Mapping[tuple[Kind, Kind], Surface], name: str) -> dict[Kind, float]:
    """Numbers r >= 0 with max(r_a, r_b) = value for each pair, MuJoCo's rule. Raises: Unsupported."""
    numbers: dict[Kind, float] = {}
    for pair, law in pairs.items():
        for kind in pair:
            numbers[kind] = min(numbers.get(kind, np.inf), getattr(law, name))
    for (a, b), law in pairs.items():
        if max(numbers[a], numbers[b]) < getattr(law, name):
            what = f"{name.replace('_', ' ')} of {law.between[0]}/{law.between[1]}"
            raise Unsupported(what, "MuJoCo-Warp takes the greater of two numbers; none give every pair its value")
    return numbers


def _mean(pairs: Mapping[tuple[Kind, Kind], Surface], name: str) -> dict[Kind, float]:
    """Numbers with (r_a + r_b)/2 = value for each pair. Raises: Unsupported."""
    numbers, missed = mean_numbers(pairs, name)
    if missed is not None:
        raise Unsupported(
            f"{name.replace('_', ' ')} of {missed.between[0]}/{missed.between[1]}",
            "XPBD takes the mean of two numbers, one for each shape; none give every pair its value",
        )
    return numbers
