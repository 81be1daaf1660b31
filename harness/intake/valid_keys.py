"""The keys that a table may have, at any place of a document: read off the JSON schema of the form that it fills."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

Schema = Mapping[str, Any]


def valid_keys(schema: Schema, path: Sequence[str | int]) -> tuple[str, ...]:
    """The keys of the table at a path of keys, indices and tags of unions; none where the schema does not know it."""
    here = [schema]
    for key in path:
        here = [deeper for node in here for deeper in _within(schema, node, key)] or here
    return tuple(dict.fromkeys(name for node in here for form in _forms(schema, node) for name in form.get("properties", ())))


def _named(schema: Schema, node: Schema) -> Schema:
    reference = node.get("$ref")
    return node if reference is None else schema["$defs"][reference.rpartition("/")[2]]


def _forms(schema: Schema, node: Schema) -> Iterator[Schema]:
    """What a node may be: itself, or each member of a union."""
    node = _named(schema, node)
    members = (*node.get("oneOf", ()), *node.get("anyOf", ()))
    if not members:
        yield node
    for member in members:
        yield from _forms(schema, member)


def _within(schema: Schema, node: Schema, key: str | int) -> Iterator[Schema]:
    """What lies one key, index or tag deeper."""
    chosen = list(_tagged(schema, node, key))
    if chosen:
        yield from chosen
        return
    for form in _forms(schema, node):
        if isinstance(key, int):
            listed = form.get("prefixItems", ())
            if key < len(listed):
                yield listed[key]
            elif isinstance(form.get("items"), dict):
                yield form["items"]
        elif key in form.get("properties", {}):
            yield form["properties"][key]
        elif isinstance(form.get("additionalProperties"), dict):
            yield form["additionalProperties"]
        elif form.get("title") == key:
            yield form


def _tagged(schema: Schema, node: Schema, tag: str | int) -> Iterator[Schema]:
    """The member of a union that a tag chooses, also where the union stands in another."""
    node = _named(schema, node)
    mapping = node.get("discriminator", {}).get("mapping", {})
    if tag in mapping:
        yield {"$ref": mapping[tag]}
    for member in node.get("anyOf", ()):
        yield from _tagged(schema, member, tag)
