"""What a loader did to a robot, by the difference that it makes: kinds of importers' changes, as typed words."""

import numpy as np

from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.parity.difference import Difference

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
        turned = np.linalg.norm(np.cross(a, b)) / max(float(np.linalg.norm(b)), 1e-300)
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


def _tensor(six: tuple[float, ...]) -> Array:
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
