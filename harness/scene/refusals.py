"""What a scene's parts say if they are built in Python with a value that does not fit: the same as a scene file would."""

from collections.abc import Iterable
from functools import wraps
from typing import Any

from pydantic import TypeAdapter, ValidationError

from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import worded
from plumbline.harness.scene.scene import SceneError


def refuse_in_words(nouns: Iterable[type]) -> None:
    """Have the constructors of these pydantic dataclasses raise `SceneError`, with element, field, value and expectation."""
    for noun in nouns:
        noun.__init__ = _in_words(noun, noun.__init__)  # type: ignore[misc]


def _in_words(noun: type, construct: Any) -> Any:
    @wraps(construct)
    def __init__(self: Any, *arguments: Any, **fields: Any) -> None:  # noqa: N807  # it takes the place of one
        try:
            construct(self, *arguments, **fields)
        except ValidationError as error:
            name = fields.get("name")
            source = noun.__name__.lower() + (f" {quoted(name, 80)}" if isinstance(name, str) else "")
            raise SceneError(worded(TypeAdapter(noun), fields, source, error)) from None

    return __init__
