"""The document of a file filled into typed fields, strictly: what does not fit is said with place, value and expectation."""

import datetime
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ArgsKwargs

from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted, readable

LARGEST = 1e60
"""Five factors of it are finite, as in m r^2 w^2; the observable universe is 1e27 m across."""


def wrong_size(value: float) -> str:
    """What is expected of a number that is none, or too large; '' where nothing is."""
    if value != value or abs(value) == math.inf:  # of a whole number without end there is no float
        return "expected finite numbers"
    return f"expected at most {LARGEST:g} in size" if abs(value) > LARGEST else ""


Schema = Mapping[str, Any]


def valid_keys(schema: Schema, path: Sequence[str | int]) -> tuple[str, ...]:
    """The keys of the table at a path of keys, indices and tags of unions; none where the schema does not know it."""
    here = list(_forms(schema, schema))
    for key in path:
        here = [form for node in _deeper(here, key) for form in _forms(schema, node)] or here
    return tuple(dict.fromkeys(name for form in here for name in form.get("properties", ())))


def _forms(schema: Schema, node: Schema) -> Iterator[Schema]:
    """What a node may be: itself, or each member of a union."""
    if (reference := node.get("$ref")) is not None:
        node = schema["$defs"][reference.rpartition("/")[2]]
    members = (*node.get("oneOf", ()), *node.get("anyOf", ()))
    if not members:
        yield node
    for member in members:
        yield from _forms(schema, member)


def _deeper(forms: Sequence[Schema], key: str | int) -> list[Schema]:
    """What lies one key or index deeper in these; of a tag, that which it chooses among them."""
    if chosen := [
        form for form in forms if key in (form.get("title"), form.get("properties", {}).get("type", {}).get("const"))
    ]:
        return chosen
    within: list[Schema] = []
    for form in forms:
        listed, others = form.get("prefixItems", ()), form.get("items" if isinstance(key, int) else "additionalProperties")
        if isinstance(key, int) and key < len(listed):
            within.append(listed[key])
        elif key in form.get("properties", {}):
            within.append(form["properties"][key])
        elif isinstance(others, dict):
            within.append(others)
    return within


MOST = 20
"""Troubles of one file that are told; the others are counted."""

UNKNOWN = ("unexpected_keyword_argument", "extra_forbidden")
"""What pydantic calls a key that a table does not have: of a dataclass, of a model."""

_LARGE = re.compile(r"e\+\d{2,3}\b|\d{60}")
"""What a number beyond `LARGEST` is written with, as others may be."""
T = TypeVar("T")
Path = tuple[str | int, ...]


class FieldError(ValueError):
    """A document that does not fit; each line of the message names source, element, field, value and expectation."""


def filled(form: TypeAdapter[T], document: Any, source: str) -> T:
    """The value that a document tells; a text or a truth value is no number, and nothing is turned into another kind.

    Raises: FieldError.
    """
    try:
        text = json.dumps(document)
    except (TypeError, ValueError, RecursionError):
        raise _strange(document, source) from None
    if _LARGE.search(text) and (large := next(_large(document, ()), None)):
        raise FieldError(f"{source}: {_place(document, large[0])}: got {quoted(large[1])}, {wrong_size(large[1])}")
    try:
        return form.validate_json(text, strict=True)
    except ValidationError as error:
        if any(problem["type"] == "json_invalid" for problem in error.errors(include_url=False)):
            raise _strange(document, source) from None
        raise FieldError(worded(form, document, source, error)) from None


def worded(form: TypeAdapter[Any], document: Any, source: str, error: ValidationError) -> str:
    """What does not fit, a line each: source, element, field, value and expectation."""
    return "\n".join(_lines(form, document, source, error.errors(include_url=False)))


def _lines(form: TypeAdapter[Any], document: Any, source: str, problems: Sequence[Any]) -> Iterator[str]:
    told = problems[:MOST]
    schema = form.json_schema() if any(problem["type"] in UNKNOWN for problem in told) else {}
    for problem in told:
        location = _place(document, problem["loc"])
        if problem["type"] in UNKNOWN:
            keys = valid_keys(schema, problem["loc"][:-1])
            hint = did_you_mean(str(problem["loc"][-1]), keys)
            yield f"{source}: {location}: unknown, got {quoted(problem['input'])}, expected one of {', '.join(keys)}{hint}"
            continue
        message = readable(problem["msg"].removeprefix("Value error, "), 600)
        got = problem["input"]
        fits = problem["type"] not in ("missing", "value_error") or not isinstance(got, dict | ArgsKwargs)
        prefix = "" if message.startswith(f"{source}: ") else f"{source}: "
        yield f"{prefix}{location + ': ' if location else ''}{message}{f', got {quoted(got)}' if fits else ''}"
    if len(problems) > MOST:
        yield f"{source}: and {len(problems) - MOST} more of this kind"


def _place(document: Any, path: Path) -> str:
    """A path into the document in words: indices become the names of the elements where they have one."""
    words: list[str] = []
    here = document
    for depth, key in enumerate(path):
        tag = key not in here and depth < len(path) - 1 if isinstance(here, dict) else isinstance(key, str)
        if tag:
            continue  # of a union, which pydantic puts between a field and what stands in it
        try:
            here = here[key]
        except (KeyError, IndexError, TypeError):
            here = None
        if isinstance(key, int) and words:
            name = here.get("name") if isinstance(here, dict) else None
            words[-1] += f"[{key}]" + (f" {quoted(name, 80)}" if isinstance(name, str) else "")
        else:
            words.append(readable(str(key).replace("\n", "\\n"), 80))
    return readable(" > ".join(words), 400)


def _large(value: Any, path: Path) -> Iterator[tuple[Path, float]]:
    """The numbers that are larger than any may be."""
    if isinstance(value, dict | list):
        for name, element in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _large(element, (*path, name))
    elif isinstance(value, int | float) and LARGEST < abs(value) < math.inf:
        yield path, value


def _strange(document: Any, source: str) -> FieldError:
    for path, value, reason in _strangers(document, ()):
        return FieldError(f"{source}: {_place(document, path)}: {reason}, got {quoted(value)}")
    return FieldError(f"{source}: not readable: no values of JSON")


def _strangers(value: Any, path: Path) -> Iterator[tuple[Path, Any, str]]:
    """What JSON has no word for: dates and times of TOML, halves of characters, whole numbers without end."""
    if isinstance(value, dict):
        for name, element in value.items():
            yield from _strangers(name, (*path, name))
            yield from _strangers(element, (*path, name))
    elif isinstance(value, list):
        for index, element in enumerate(value):
            yield from _strangers(element, (*path, index))
    elif isinstance(value, datetime.date | datetime.time):
        yield path, value.isoformat(), "a date or time fits nowhere"
    elif isinstance(value, str) and any("\ud800" <= sign <= "\udfff" for sign in value):
        yield path, value, "half of a character is no text"
    elif isinstance(value, int) and abs(value) >= 10**4000:
        yield path, value, "a number too large"
