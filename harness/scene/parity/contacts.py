"""What touches of two robots, and what rubs on what: shapes by how far they reach, and the pairs that may touch."""

from collections.abc import Mapping

import numpy as np

from plumbline.harness.scene import Plane, Surface
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.robot import Geometry
from plumbline.harness.scene.parity.difference import Difference, Quantity, Value
from plumbline.harness.scene.parity.facts import FIXED, RobotFacts
from plumbline.harness.scene.support import support

_GOLDEN = np.pi * (1 + 5**0.5)
_SHOWN = 6
"""Pairs of links that are named in a row."""


def _ways(count: int = 64) -> Array:
    """Directions spread over a sphere, (count, 3)."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, _GOLDEN * k
    flat = np.sqrt(1 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


_WAYS = _ways()


def _reach(geometry: Geometry) -> Array:
    """How far a shape in W reaches along some directions [m]: one shape in two ways of telling reaches alike."""
    X = geometry.X_LG
    if isinstance(geometry.shape, Plane):
        normal = X.R @ np.array(geometry.shape.normal)
        return np.concatenate([normal, [normal @ X.p]])
    return support(geometry.shape, _WAYS @ X.R) + _WAYS @ X.p


def shape_rows(a: RobotFacts, b: RobotFacts, extent: float, tolerance: float) -> list[Difference]:
    """What touches in one of the two alone, a row for each group of links. Args: extent [m]: that lengths are held against."""
    rows = []
    for name in dict.fromkeys((*a.shapes, *b.shapes)):
        shapes = a.shapes.get(name, ())
        left = [(shape, _reach(shape)) for shape in b.shapes.get(name, ())]
        alone, off = [], 0.0
        for shape in shapes:
            mine = _reach(shape)
            apart = [float(np.abs(mine - other).max()) if len(mine) == len(other) else np.inf for _, other in left]
            nearest = int(np.argmin(apart)) if apart else -1
            if apart and apart[nearest] <= tolerance * extent:
                left.pop(nearest)
            else:
                alone.append(shape)
                off = max(off, min(apart, default=np.inf))
        if not alone and not left:
            continue
        size = off if np.isfinite(off) and len(alone) == len(left) else None
        rows.append(
            Difference(
                quantity="shape", element=f"what '{name}' moves" if name else "what is fixed", value_A=_words(alone),
                value_B=_words([shape for shape, _ in left]), unit="m", tolerance=tolerance, absolute=size,
                relative=None if size is None else size / extent, words="contacts begin elsewhere",
            )
        )  # fmt: skip
    return rows


def _words(shapes: list[Geometry]) -> str:
    kinds = [shape.shape.type.replace("_", " ") for shape in shapes]
    return ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds)) or "none"


_FRICTIONS = ("static_friction", "kinetic_friction", "torsional_friction", "rolling_friction")


def touch_rows(a: RobotFacts, b: RobotFacts, tolerance: float) -> list[Difference]:
    """The pairs that may touch in one of the two alone, and the friction of those that may in both."""
    rows = []
    for mine, other, in_A, in_B in ((a, b, "touch", "never touch"), (b, a, "never touch", "touch")):
        alone = [pair for pair in mine.touches if pair not in other.touches]
        if alone:
            rows.append(
                _row("touch", _named(alone), in_A, in_B, tolerance, words="excluded, masked or a neighbour in one alone")
            )
    for quantity in _FRICTIONS:
        values = {pair: (getattr(a.touches[pair], quantity), getattr(b.touches[pair], quantity)) for pair in _common(a, b)}
        off = {pair: abs(x - y) / max(abs(x), abs(y), 1e-300) for pair, (x, y) in values.items()}
        changed = [pair for pair, relative in off.items() if relative > tolerance]
        if changed:
            worst = max(changed, key=lambda pair: off[pair])
            x, y = values[worst]
            unit = "m" if quantity in ("torsional_friction", "rolling_friction") else "1"
            named = f"{quantity.replace('_', ' ')} of {_named(changed)}"
            words = "times the normal force, they hold or brake by as much more or less"
            rows.append(_row("friction", named, x, y, tolerance, unit, abs(x - y), off[worst], words))
    return rows


def _common(a: RobotFacts, b: RobotFacts) -> list[frozenset[str]]:
    return [pair for pair in a.touches if pair in b.touches]


def _named(pairs: list[frozenset[str]]) -> str:
    shown = [" and ".join(f"'{name}'" if name != FIXED else "what is fixed" for name in sorted(pair)) for pair in pairs]
    more = f" and {len(shown) - _SHOWN} more pairs" if len(shown) > _SHOWN else ""
    return "; ".join(shown[:_SHOWN]) + more


def _row(quantity: Quantity, element: str, value_A: Value, value_B: Value, tolerance: float, unit: str = "",
         size: float | None = None, relative: float | None = None, words: str = "") -> Difference:  # fmt: skip
    return Difference(
        quantity=quantity, element=element, value_A=value_A, value_B=value_B, unit=unit, tolerance=tolerance,
        absolute=size, relative=relative, words=words,
    )  # fmt: skip


def stronger(law: Surface | None, other: Surface) -> Surface:
    """Of two laws between the same two, the one that rubs more."""
    return other if law is None or other.kinetic_friction > law.kinetic_friction else law


def renamed_pairs(touches: Mapping[frozenset[str], Surface], names: Mapping[str, str]) -> dict[frozenset[str], Surface]:
    """The pairs with their joints by other names."""
    return {frozenset(names.get(name, name) for name in pair): law for pair, law in touches.items()}
