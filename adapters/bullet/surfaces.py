"""The law of contact: what each kind of body carries so that Bullet's products give each pair of kinds its value."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.touching_kinds import Kind, touching_kinds
from plumbline.harness.scene import Effect, Scene, Surface

GREATEST_FRICTION = 10.0
"""btManifoldResult clamps every combined coefficient to this."""


@dataclass(frozen=True, slots=True)
class Coefficients:
    """The numbers that one kind of body carries, so that Bullet's combination gives each pair its value."""

    friction: float = 0.0
    restitution: float = 0.0
    rolling: float = 0.0
    torsional: float = 0.0


def _pairs(scene: Scene) -> dict[tuple[Kind, Kind], Surface]:
    """The kinds that can touch, with their law, whatever the order of the bodies."""
    return dict(sorted(touching_kinds(scene).items()))


def _factors(values: Mapping[tuple[Kind, Kind], float], what: str) -> dict[Kind, float]:
    """Numbers x >= 0 with x_a x_b = value for every pair; a linear problem in logarithms. Raises: Unsupported."""
    kinds = sorted({kind for pair in values for kind in pair})
    positive = sorted({kind for pair, value in values.items() if value > 0 for kind in pair})
    for (a, b), value in values.items():
        if value == 0 and a in positive and b in positive:
            raise Unsupported(
                f"surface {a[0]}/{b[0]}", f"Bullet multiplies the {what} of the two bodies; both are above 0 elsewhere"
            )
    rows = [(pair, value) for pair, value in values.items() if value > 0]
    if not rows:
        return dict.fromkeys(kinds, 0.0)
    column = {kind: k for k, kind in enumerate(positive)}
    matrix, logarithms = np.zeros((len(rows), len(positive))), np.zeros(len(rows))
    for row, ((a, b), value) in enumerate(rows):
        matrix[row, column[a]] += 1
        matrix[row, column[b]] += 1
        logarithms[row] = math.log(value)
    solution = np.linalg.lstsq(matrix, logarithms, rcond=None)[0]
    misfit = np.abs(matrix @ solution - logarithms)
    if misfit.max() > 1e-12:
        (a, b), value = rows[int(misfit.argmax())]
        raise Unsupported(
            f"surface {a[0]}/{b[0]}",
            f"Bullet multiplies the {what} of the two bodies; no numbers give {value:g} and the other pairs",
        )
    return {kind: math.exp(solution[column[kind]]) if kind in column else 0.0 for kind in kinds}


def _levers(values: Mapping[tuple[Kind, Kind], float], friction: Mapping[Kind, float], what: str) -> dict[Kind, float]:
    """Numbers r >= 0 with r_a mu_b + r_b mu_a = value [m] for every pair (btManifoldResult). Raises: Unsupported."""
    kinds = sorted({kind for pair in values for kind in pair})
    if not any(values.values()):
        return dict.fromkeys(kinds, 0.0)
    from scipy.optimize import nnls  # late: only what rolls or spins against friction pays for it

    column = {kind: k for k, kind in enumerate(kinds)}
    matrix, target = np.zeros((len(values), len(kinds))), np.zeros(len(values))
    for row, ((a, b), value) in enumerate(values.items()):
        matrix[row, column[a]] += friction[b]
        matrix[row, column[b]] += friction[a]
        target[row] = value
    solution, misfit = nnls(matrix, target)
    if misfit > 1e-12 * target.max():
        raise Unsupported(what, "Bullet combines it as r_a mu_b + r_b mu_a; no numbers give every pair its value")
    return {kind: float(solution[column[kind]]) for kind in kinds}


def coefficients(scene: Scene) -> dict[Kind, Coefficients]:
    """The coefficients of each kind of body. Raises: Unsupported."""
    effects = scene.effects
    if Effect.CONTACT not in effects:
        return {}
    pairs = _pairs(scene)

    def values(effect: Effect, name: str) -> dict[tuple[Kind, Kind], float]:
        return {pair: getattr(law, name) if effect in effects else 0.0 for pair, law in pairs.items()}

    kinetic = values(Effect.FRICTION, "kinetic_friction")
    for (a, b), law in pairs.items():
        where = f"surface {a[0]}/{b[0]}"
        if Effect.FRICTION in effects and law.static_friction > law.kinetic_friction:
            raise Unsupported(where, "Bullet has one coefficient of friction; static and kinetic differ")
        if kinetic[a, b] > GREATEST_FRICTION:
            raise Unsupported(where, f"Bullet clamps friction to {GREATEST_FRICTION:g}")
    friction = _factors(kinetic, "friction")
    restitution = _factors(values(Effect.RESTITUTION, "restitution"), "restitution")
    rolling = _levers(values(Effect.ROLLING_FRICTION, "rolling_friction"), friction, "rolling friction")
    torsional = _levers(values(Effect.TORSIONAL_FRICTION, "torsional_friction"), friction, "torsional friction")
    return {kind: Coefficients(friction[kind], restitution[kind], rolling[kind], torsional[kind]) for kind in friction}


def braked(scene: Scene) -> frozenset[Kind]:
    """The kinds of body that rolling or torsional friction acts on; which body of a pair carries its lever does not matter."""
    acting = [
        name
        for effect, name in (
            (Effect.ROLLING_FRICTION, "rolling_friction"),
            (Effect.TORSIONAL_FRICTION, "torsional_friction"),
        )
        if effect in scene.effects
    ]
    if not acting or Effect.CONTACT not in scene.effects:
        return frozenset()
    return frozenset(
        kind for pair, law in _pairs(scene).items() if any(getattr(law, name) > 0 for name in acting) for kind in pair
    )
