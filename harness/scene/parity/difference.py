"""One row of a comparison: what differs, by how much, and what that is worth."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

Quantity = Literal[
    "joint", "type", "parent", "axis", "anchor", "lower", "upper", "damping", "stiffness", "rest", "armature",
    "friction_loss", "effort", "speed", "mass", "centre", "inertia", "law", "ratio", "offset", "point", "gravity",
    "drive stiffness", "drive damping", "drive target", "drive rate", "drive force", "drive push", "drive limit", "shape",
    "touch", "friction", "own value", "gravity torque", "mass matrix", "acceleration",
]  # fmt: skip
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

    quantity: Quantity
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
