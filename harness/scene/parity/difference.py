"""One row of a comparison: what differs, by how much, what that is worth, and what a loader did that made it."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from plumbline.harness.scene.importers.poses import Array

Value = str | float | tuple[float, ...] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """A quantity in which A and B differ beyond the tolerance.

    Terms:
        element: the joint, or what moves with it. value_A, value_B, unit: None is unbounded or not there. absolute: size in
        the unit; relative: what is held against the tolerance; both None for what has no size. torque: what has to be
        exerted on A, at the worst of the states and joints, for it to accelerate as with B's value, in torque_unit. kind: what
        a loader did, in words of importers; '' in a comparison of two files. documented: where the loader's documentation
        says so; '' for nowhere known. words: the consequence.
    """

    quantity: str
    element: str
    value_A: Value
    value_B: Value
    unit: str
    tolerance: float
    absolute: float | None = None
    relative: float | None = None
    torque: float | None = None
    torque_unit: str = ""
    kind: str = ""
    documented: str = ""
    words: str = ""


def plain(row: Difference) -> dict[str, Any]:
    """The row as a flat mapping."""
    return asdict(row)


_SMALLEST = 1e-300


@dataclass(frozen=True, slots=True)
class Yardstick:
    """What differences are held against. Terms: tolerance: relative. extent [m]: of the robot, for lengths."""

    tolerance: float
    extent: float

    def rows(
        self, quantity: str, element: str, a: Value, b: Value, *, unit: str = "", size: float | None = None,
        scale: float = 1.0, **more: Any,
    ) -> list[Difference]:  # fmt: skip
        """The row of two values that differ; none within the tolerance.

        Args: size: of the difference, in the unit, None where it has none; scale: what it is held against. more: of the row.
        """
        relative = None if size is None else size / max(scale, _SMALLEST)
        if relative is not None and relative <= self.tolerance:
            return []
        return [
            Difference(
                quantity=quantity, element=element, value_A=a, value_B=b, unit=unit, tolerance=self.tolerance,
                absolute=size, relative=relative, **more,
            )
        ]  # fmt: skip

    def lengths(self, unit: str) -> float:
        """What coordinates of a unit are held against: lengths against the extent, angles as they are."""
        return self.extent if unit == "m" else 1.0


_DROPPED = {
    "damping": "damping dropped",
    "friction_loss": "friction dropped",
    "armature": "armature ignored",
    "stiffness": "spring dropped",
    "effort": "effort ignored",
    "speed": "speed ignored",
}


def kind_of(row: Difference) -> str:
    """The kind of a row of a comparison of the file (A) with what a loader made of it (B); '' where no kind fits."""
    if row.quantity in _DROPPED:
        return _DROPPED[row.quantity] if not row.value_B else f"{row.quantity.replace('_', ' ')} changed"
    if row.quantity in ("lower", "upper"):
        return "limit ignored" if row.value_B is None else "limit made up" if row.value_A is None else "limit changed"
    if row.quantity == "joint":
        return "joint lost" if row.value_B == "absent" else "joint made up"
    if row.quantity == "law":
        if row.value_B != "absent":
            return "law made up" if row.value_A == "absent" else "law changed"
        return {"mimic": "mimic made free", "closure": "loop opened"}.get(row.element.partition(" ")[0], "law lost")
    if row.quantity == "axis" and isinstance(row.value_A, tuple) and isinstance(row.value_B, tuple):
        a, b = np.array(row.value_A), np.array(row.value_B)
        turned = np.linalg.norm(np.cross(a, b)) / max(float(np.linalg.norm(b)), _SMALLEST)
        return "axis not normalised" if turned <= row.tolerance else "axis changed"
    if row.quantity == "inertia" and isinstance(row.value_A, tuple) and isinstance(row.value_B, tuple):
        return _of_inertia(_tensor(row.value_A), _tensor(row.value_B), row.tolerance)
    return {
        "ratio": "mimic changed",
        "offset": "mimic changed",
        "point": "loop changed",
        "anchor": "frame moved",
        "centre": "centre moved",
        "mass": "mass changed",
    }.get(row.quantity, "")


def _of_inertia(a: Array, b: Array, tolerance: float) -> str:
    """Equal moments about other axes are a rotation that was lost; products alone that are gone, a diagonal."""
    size = float(np.linalg.norm(a, 2)) or 1.0
    if np.abs(np.linalg.eigvalsh(a) - np.linalg.eigvalsh(b)).max() <= tolerance * size:
        return "rotation of the inertia lost"
    if np.abs(np.diag(a) - np.diag(b)).max() <= tolerance * size and np.abs(b - np.diag(np.diag(b))).max() <= tolerance * size:
        return "inertia made diagonal"
    return "inertia replaced"


def six(tensor: Array) -> tuple[float, ...]:
    """xx, yy, zz, xy, xz, yz."""
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return tuple(float(tensor[index]) for index in places)


def _tensor(numbers: tuple[float, ...]) -> Array:
    xx, yy, zz, xy, xz, yz = numbers
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
