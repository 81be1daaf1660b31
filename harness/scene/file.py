"""Scene files: TOML and JSON in and out, and the JSON schema, by pydantic."""

import json
import tomllib
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import TypeAdapter, ValidationError

from harness.scene.scene import Scene, SceneError

__all__ = ["MAX_BYTES", "dump_json", "dump_toml", "load", "parse", "schema"]

MAX_BYTES = 64 * 1024 * 1024
"""A larger scene file is refused before it is read."""

_ADAPTER: TypeAdapter[Scene] = TypeAdapter(Scene)


def _plain(scene: Scene) -> dict[str, Any]:
    plain: dict[str, Any] = _ADAPTER.dump_python(scene, mode="json", exclude_none=True)
    return plain


def dump_json(scene: Scene) -> str:
    """The scene as JSON text; `parse` reads it back to an equal scene."""
    return json.dumps(_plain(scene), allow_nan=False)


def dump_toml(scene: Scene) -> str:
    """The scene as TOML text; `parse` reads it back to an equal scene."""
    return tomli_w.dumps(_plain(scene))


def schema() -> dict[str, Any]:
    """The JSON schema of a scene file."""
    return _ADAPTER.json_schema()


def _place(document: Any, path: tuple[str | int, ...]) -> str:
    """A path into the document in words: indices become the names of the elements where they have one."""
    words: list[str] = []
    here = document
    for depth, part in enumerate(path):
        if isinstance(here, dict) and part not in here and depth < len(path) - 1:
            continue  # the tag of a union, which pydantic puts between a field and what stands in it
        try:
            here = here[part]
        except (KeyError, IndexError, TypeError):
            here = None
        if isinstance(part, int) and words:
            name = here.get("name") if isinstance(here, dict) else None
            words[-1] += f"[{part}]" + (f" '{name}'" if isinstance(name, str) else "")
        else:
            words.append(str(part))
    return " > ".join(words)


def _explain(source: str, document: Any, error: ValidationError) -> SceneError:
    lines = []
    for problem in error.errors(include_url=False):
        place = _place(document, problem["loc"])
        message = problem["msg"].removeprefix("Value error, ")
        got = problem["input"]
        shown = f", got {got!r:.120}" if isinstance(got, str | int | float | bool | list | type(None)) else ""
        lines.append(f"{source}: {place + ': ' if place else ''}{message}{shown}")
    return SceneError("\n".join(lines))


def parse(text: str, source: str = "scene.json") -> Scene:
    """Read a scene from JSON or TOML text; the ending of `source` says which.

    Raises:
        SceneError: naming source, element, field, value and expectation.
    """
    try:
        document = tomllib.loads(text) if source.endswith(".toml") else json.loads(text)
    except (tomllib.TOMLDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise SceneError(f"{source}: not readable: {error}") from error
    try:
        return _ADAPTER.validate_python(document)
    except ValidationError as error:
        raise _explain(source, document, error) from error


def load(path: Path) -> Scene:
    """Read a scene file ending in .toml or .json.

    Raises:
        SceneError: where the file is no scene. OSError: where it cannot be read.
    """
    if path.suffix not in {".toml", ".json"}:
        raise SceneError(f"{path}: ending {path.suffix!r}, expected .toml or .json")
    size = path.stat().st_size
    if size > MAX_BYTES:
        raise SceneError(f"{path}: {size} bytes, expected at most {MAX_BYTES}")
    return parse(path.read_text(encoding="utf-8"), str(path))
