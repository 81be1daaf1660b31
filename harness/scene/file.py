"""Scene files: TOML and JSON in and out, and the JSON schema, by pydantic."""

import dataclasses
import gc
import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import TypeAdapter

from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.documents import InputError, document, named, parsed
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import FieldError, filled
from plumbline.harness.scene.scene import Scene, SceneError

_ADAPTER: TypeAdapter[Scene] = TypeAdapter(Scene)
TEMPLATE = Path(__file__).with_name("template.toml")
"""A scene file to begin with: a pendulum above a ball on the ground, with what else can be said in comments."""


@contextmanager
def uncollected() -> Iterator[None]:
    """Without the collector of cycles, of which scenes have none: it would go through all that they are again and again."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _plain(scene: Scene) -> dict[str, Any]:
    plain: dict[str, Any] = _ADAPTER.dump_python(scene, mode="json", exclude_none=True)
    return plain


def dump_json(scene: Scene) -> str:
    """The scene as JSON text; `parse` reads it back to an equal scene."""
    return json.dumps(_plain(scene), allow_nan=False)


@uncollected()
def dump_toml(scene: Scene) -> str:
    """The scene as TOML text; `parse` reads it back to an equal scene."""
    return tomli_w.dumps(_plain(scene))


def to_toml(scene: Scene) -> str:
    """The scene as a person would write it: values that differ from their defaults alone, a list of numbers in a line.

    `parse` reads it back to an equal scene. Raises: SceneError, where it is none.
    """
    if not isinstance(scene, Scene):
        raise SceneError(f"to_toml: {quoted(scene)}, expected Scene")
    return _NUMBERS.sub(
        lambda listed: f"[{', '.join(listed[1].split()).replace(',,', ',').rstrip(',')}]",
        tomli_w.dumps(_brief(scene, _plain(scene))),
    )


_NUMBERS = re.compile(r"\[\n([^\[\]{}\"']*)\]")
"""A list without lists or texts in it, over several lines."""


def _brief(value: Any, plain: Any) -> Any:
    """What a value is dumped as, without what is as its field has it anyway."""
    if dataclasses.is_dataclass(value):
        fields = [
            f
            for f in dataclasses.fields(value)
            if f.name in plain and (f.name == "type" or getattr(value, f.name) != f.default)
        ]
        return {f.name: _brief(getattr(value, f.name), plain[f.name]) for f in fields}
    if isinstance(value, tuple):
        return [_brief(each, of_it) for each, of_it in zip(value, plain, strict=True)]
    return plain


def schema() -> dict[str, Any]:
    """The JSON schema of a scene file."""
    return _ADAPTER.json_schema()


def _listed(table: Any, key: str) -> list[Any]:
    """The list under a key of what should be a table; nothing where either is something else."""
    entries = table.get(key) if isinstance(table, dict) else None
    return entries if isinstance(entries, list) else []


def _beyond(table: Any) -> str:
    """What of a scene goes beyond a limit, in words; '' where nothing does."""
    for kind in ("bodies", "joints", "sensors"):
        if excess := beyond(kind, len(_listed(table, kind))):
            return f"{kind}: {excess}"
    counts = {"vertices": 0, "faces": 0}
    for place, body in enumerate(_listed(table, "bodies")):
        for placed in (*_listed(body, "collision"), *_listed(body, "visual")):
            shape = placed.get("shape") if isinstance(placed, dict) else None
            for kind in counts:
                counts[kind] += len(_listed(shape, kind))
                if excess := beyond("vertices", counts[kind], kind):
                    return f"bodies[{place}] {quoted(body.get('name'), 80)}: with it the scene has {excess}"
    return ""


def _scene(table: Any, source: str) -> Scene:
    if excess := _beyond(table):
        raise SceneError(f"{source}: {excess}")
    try:
        return filled(_ADAPTER, table, source)
    except FieldError as error:
        raise SceneError(str(error)) from None


def parse(text: str, source: str = "scene.json") -> Scene:
    """Read a scene from JSON or TOML text; the ending of `source` says which.

    Raises:
        SceneError: naming source, element, field, value and expectation.
    """
    try:
        table = parsed(text, source, ".toml" if source.endswith(".toml") else ".json")
    except InputError as error:
        raise SceneError(str(error)) from None
    return _scene(table, source)


def load(path: Path) -> Scene:
    """Read a scene file ending in .toml or .json. Raises: SceneError, where it cannot be read or is no scene."""
    try:
        table = document(path)
    except InputError as error:
        raise SceneError(str(error)) from None
    return _scene(table, named(path))
