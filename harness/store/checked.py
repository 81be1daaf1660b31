"""What a file of the store says, checked against a form before anybody uses it: a right checksum makes no content right."""

from functools import cache
from typing import Any, TypeVar

T = TypeVar("T")


@cache
def _form(of: Any) -> Any:
    from pydantic import TypeAdapter  # late: a listing reads no store

    return TypeAdapter(of)


def checked(form: type[T], value: object, what: str) -> T:
    """The value as one of a dataclass, each field of its type; fields that are not known are passed over.

    Args: value: of JSON or TOML. Raises: ValueError, with the field that is none.
    """
    try:
        typed: T = _form(form).validate_python(value)  # type: ignore[arg-type]  # a class can be hashed
    except ValueError as error:
        first = error.errors(include_url=False)[0]  # type: ignore[attr-defined]  # of pydantic, which is loaded late
        where = ".".join(map(str, first["loc"])) or what
        raise ValueError(f"holds no {what}: {where}: {first['msg']}, got {str(first['input'])[:80]!r}") from None
    return typed
