"""Numbers at the door: finite scalars, vectors, unit quaternions and names, each with the bound that a scene puts on it."""

import math
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field

FROZEN = ConfigDict(extra="forbid", allow_inf_nan=False, ser_json_inf_nan="strings")
"""Every value of a scene: unknown fields, NaN and infinity are refused."""


def _as_tuple(value: Any) -> Any:
    """Let NumPy arrays, and the lists of files, stand where a tuple is expected."""
    listed = value.tolist() if hasattr(value, "tolist") else value
    return tuple(_as_tuple(element) for element in listed) if isinstance(listed, list) else listed


def _unit(q: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    norm = math.sqrt(sum(c * c for c in q))
    if abs(norm - 1.0) > 1e-6:
        raise ValueError(f"quaternion {q} has norm {norm:.9g}, expected 1 (order w, x, y, z)")
    if abs(norm - 1.0) <= 4e-16:
        return q
    return (q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm)


def _direction(v: tuple[float, float, float]) -> tuple[float, float, float]:
    norm = math.sqrt(sum(c * c for c in v))
    if norm < 1e-9:
        raise ValueError(f"direction {v} is zero, expected a vector of length above 1e-9")
    if abs(norm - 1.0) <= 4e-16:
        return v
    return (v[0] / norm, v[1] / norm, v[2] / norm)


def _name(text: str) -> str:
    if not text or len(text) > 200 or not text.isprintable() or text != text.strip():
        raise ValueError("a name is 1 to 200 printable characters without blanks at its ends")
    return text


Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Probability = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Name = Annotated[str, AfterValidator(_name)]
Vector3 = Annotated[tuple[float, float, float], BeforeValidator(_as_tuple)]
Axis = Annotated[tuple[float, float, float], BeforeValidator(_as_tuple), AfterValidator(_direction)]
Quaternion = Annotated[tuple[float, float, float, float], BeforeValidator(_as_tuple), AfterValidator(_unit)]
Matrix3 = Annotated[
    tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]], BeforeValidator(_as_tuple)
]
