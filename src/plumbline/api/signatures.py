"""Signatures for people: types without what validates them, so that `help(plumbline.Body)` can be read."""

import inspect
import types
from typing import Annotated, Any, Literal, Union, Unpack, get_args, get_origin


class _Text(str):
    """An annotation that is shown as it reads, without quotes."""

    __slots__ = ()
    __repr__ = str.__str__


def readable(value: Any) -> inspect.Signature:
    """The signature of a class or a function."""
    signature = inspect.signature(value)
    parameters = [each.replace(annotation=_shown(each.annotation)) for each in signature.parameters.values()]
    return signature.replace(parameters=parameters, return_annotation=_shown(signature.return_annotation))


def _shown(annotation: Any) -> Any:
    return annotation if annotation is inspect.Parameter.empty else _Text(words(annotation))


def words(annotation: Any) -> str:
    """'tuple[float, float, float]', 'Box | Sphere | None'."""
    origin, args = get_origin(annotation), get_args(annotation)
    if origin in (Annotated, Unpack):
        return words(args[0])
    if origin in (Union, types.UnionType):
        return " | ".join(map(words, args))
    if origin is Literal:
        return " | ".join(map(repr, args))
    if annotation in (None, type(None)):
        return "None"
    if annotation is Ellipsis:
        return "..."
    if origin is not None and args:
        return f"{words(origin)}[{', '.join(map(words, args))}]"
    return str(getattr(annotation, "__name__", annotation))
