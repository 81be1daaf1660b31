"""Refuse bad input at the door, with a sentence that names element, field and value."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import cache
from numbers import Integral, Real
from typing import Any, ClassVar, cast

import numpy as np

from plumbline.engine.maths.arrays import eigenvalues, norm


class Described:
    """A dataclass whose fields are checked when it is made: Annotated[type, check, what the check is told beside the value].

    A field that is None by default may be None. ELEMENT: what errors call it, {0} itself; the words of its type if empty.
    """

    __slots__ = ()
    ELEMENT: ClassVar[str] = ""

    @property
    def label(self) -> str:
        """What errors call it."""
        return self.ELEMENT.format(self) if self.ELEMENT else _words(type(self).__name__)

    def __post_init__(self) -> None:
        self.check_fields()

    def check_fields(self) -> None:
        """Raises: ValueError naming the first field whose value its check refuses."""
        label, kind = self.label, cast(Any, type(self))
        for name, optional, check, args in _checks(kind):
            value = getattr(self, name)
            if not (optional and value is None):
                check(label, name, value, *args)


@cache
def _words(name: str) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower()


@cache
def _checks(kind: Any) -> list[tuple[str, bool, Callable[..., Any], tuple[Any, ...]]]:
    """Of each field of a dataclass that is checked: its name, whether it may be None, its check, and what that is told."""
    found = [(one.name, one.default is None, getattr(one.type, "__metadata__", ())) for one in fields(kind)]
    return [(name, optional, args[0], args[1:]) for name, optional, args in found if args]


def finite(element: str, field: str, value: Any, shape: tuple[int, ...], unit: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The value as an array of the expected shape. Raises: ValueError if it is no numbers, of another shape, or not finite."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{element}: {field} {value!r}, expected numbers of shape {shape}") from error
    if array.shape != shape:
        raise ValueError(f"{element}: {field} has shape {array.shape}, expected {shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{element}: {field} {array.tolist()} {unit} is not finite")
    return array


def number(element: str, field: str, value: Any) -> float:
    """The value. Raises: ValueError unless it is one number; it may be infinite or NaN."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{element}: {field} {value!r}, expected a number")
    return float(value)


def whole(element: str, field: str, value: Any, least: int) -> int:
    """The value. Raises: ValueError unless it is a whole number of at least `least`."""
    if type(value) is int and value >= least:  # what nearly all are, without the question whether they count as one: .7 us
        return value
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise ValueError(f"{element}: {field} {value!r}, expected a whole number of at least {least}")
    return int(value)


def positive(element: str, field: str, value: float, unit: str) -> float:
    """The value. Raises: ValueError unless it is finite and above zero."""
    number(element, field, value)
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{element}: {field} {value} {unit}, expected a finite number above 0")
    return float(value)


def not_negative(element: str, field: str, value: float, unit: str) -> float:
    """The value. Raises: ValueError unless it is finite and at least zero."""
    number(element, field, value)
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(f"{element}: {field} {value} {unit}, expected a finite number of at least 0")
    return float(value)


def lengths(element: str, field: str, value: Any) -> None:
    """Raises: ValueError unless it is three lengths [m] above zero."""
    finite(element, field, value, (3,), "m")
    for one in value:
        positive(element, field, one, "m")


def above_zero(element: str, field: str, value: float) -> None:
    """Raises: ValueError unless it is a number above zero; it may be infinite."""
    if not number(element, field, value) > 0:
        raise ValueError(f"{element}: {field} {value}, expected above 0")


def not_zero(element: str, field: str, value: float, unit: str) -> None:
    """Raises: ValueError unless it is a finite number other than zero."""
    if finite(element, field, value, (), unit) == 0:
        raise ValueError(f"{element}: {field} {value}, expected another than 0")


def between(element: str, field: str, value: float, least: float, most: float) -> None:
    """Raises: ValueError unless it is a number from the least to the most."""
    if not least <= number(element, field, value) <= most:
        raise ValueError(f"{element}: {field} {value}, expected {least:g} to {most:g}")


def one_of(element: str, field: str, value: Any, choices: Sequence[str]) -> None:
    """Raises: ValueError unless it is one of the choices."""
    if value not in choices:
        raise ValueError(f"{element}: {field} {value!r}, expected one of {', '.join(choices)}")


def direction(element: str, field: str, value: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The vector (3,). Raises: ValueError if it has no direction."""
    array = finite(element, field, value, (3,), "1")
    if float(norm(array)) < 1e-12:
        raise ValueError(f"{element}: {field} {tuple(value)}, expected a direction")
    return array


def unit_quaternion(element: str, field: str, value: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The quaternion divided by its length. Raises: ValueError if it is zero or not finite."""
    array = finite(element, field, value, (4,), "1")
    length = float(norm(array))
    if length < 1e-12:
        raise ValueError(f"{element}: {field} {array.tolist()} has no direction, expected a unit quaternion (w, x, y, z)")
    return array if abs(length - 1.0) < 1e-15 else array / length


def spd_inertia(element: str, value: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """An inertia matrix (3, 3) kg m2. Raises: ValueError unless symmetric, positive and within the triangle inequality.

    Source: Wensing, Kim, Slotine, Linear Matrix Inequalities for Physically Consistent Inertial Parameters, 2018, section II.
    """
    array = finite(element, "inertia", value, (3, 3), "kg m2")
    size = float(np.abs(array).max())
    if not np.allclose(array, array.T, rtol=0.0, atol=1e-12 * size):
        raise ValueError(f"{element}: inertia {array.tolist()} kg m2 is not symmetric")
    principal = eigenvalues(array)
    shown = ", ".join(f"{one:g}" for one in principal)
    if principal[0] <= 0.0:
        raise ValueError(f"{element}: inertia with principal moments ({shown}) kg m2 is not positive definite")
    if principal[2] > (principal[0] + principal[1]) * (1 + 1e-9):
        raise ValueError(f"{element}: inertia ({shown}) kg m2 breaks the triangle inequality")
    return (array + array.T) / 2
