"""The door of the interface: arguments are of the kinds that a function's annotations say, or are refused by name and value."""

import os
import sys
from collections.abc import Callable, Mapping
from functools import cache, wraps
from inspect import Parameter, signature
from os import PathLike
from typing import Any, TypeVar, get_type_hints

import numpy as np
from pydantic import ConfigDict, TypeAdapter, ValidationError

from plumbline.api.signatures import words
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted

Call = TypeVar("Call", bound=Callable[..., Any])


class ArgumentError(PlumblineError, ValueError):
    """An argument of another kind, or outside of its range; the message names function, argument, value and expectation."""


@cache
def _forms(function: Callable[..., Any]) -> Mapping[str, tuple[TypeAdapter[Any], str]]:
    """By argument, what checks it and what it is called; those behind ** are checked where they are read."""
    hints, loose = get_type_hints(function), ConfigDict(arbitrary_types_allowed=True)
    named = [each.name for each in signature(function).parameters.values() if each.kind is not Parameter.VAR_KEYWORD]
    return {name: (_form(hints[name], loose), words(hints[name])) for name in named}


def _form(hint: Any, loose: ConfigDict) -> TypeAdapter[Any]:
    try:
        return TypeAdapter(hint, config=loose)
    except Exception:  # pydantic takes no configuration beside a type that has its own
        return TypeAdapter(hint)


def checked(function: Call) -> Call:
    """The function with its arguments checked; NumPy's numbers become Python's.

    What it refuses is told without the calls within Plumbline, which `python -X dev` shows.
    """
    heads = signature(function)

    @wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        bound = heads.bind(*arguments, **named)
        for name, (form, kind) in _forms(function).items():
            if name not in bound.arguments:
                continue
            value = bound.arguments[name]
            bound.arguments[name] = value.item() if isinstance(value, np.generic) else value
            if isinstance(value, str | PathLike) and not _can_be_a_name(value):
                raise ArgumentError(
                    f"{function.__name__}: {name}: {quoted(str(value), 80)}, expected what a file can be called"
                )
            try:
                form.validate_python(bound.arguments[name], strict=True)
            except ValidationError:
                raise ArgumentError(f"{function.__name__}: {name}: {quoted(value)}, expected {kind}") from None
        try:
            return function(*bound.args, **bound.kwargs)
        except PlumblineError as error:
            if not sys.flags.dev_mode:
                error.__traceback__ = None
            raise

    return call  # type: ignore[return-value]


def _can_be_a_name(value: "str | PathLike[str]") -> bool:
    names = os.fsencode(value).split(b"/")
    return not any(b"\0" in name or len(name) > 255 for name in names)


def within(name: str, value: float | None, low: float, high: float) -> None:
    """Refuse a number outside of low..high; None is none. Raises: ArgumentError."""
    if value is not None and not low <= value <= high:
        raise ArgumentError(f"{name}: {value:g}, expected {low:g} to {high:g}")
