"""What MuJoCo's compiler would have read in the place of a word that it does not know, by `mj_printSchema`.

The compiler holds a file against its schema, but not what stands in a <frame> or <replicate>, which lie outside of it: there a
misspelt damping is read as none. So that is looked at here.
"""

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import cast

from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted

BODY = "(world)body"
RECURSIVE = ("body", "frame", "replicate")
"""What the schema calls a body stands for these too, and each of them may hold the others."""
_POSE = ("axisangle", "euler", "pos", "quat", "xyaxes", "zaxis")
OUTSIDE = {"frame": ("childclass", "name", *_POSE), "replicate": ("childclass", "count", "euler", "offset", "sep")}
"""Elements outside of the schema, with their attributes after MuJoCo's XML reference."""

_ROW = re.compile(r"( *)([\w()]+) +\((.)\) *(.*)")
_UNKNOWN = re.compile(r"unrecognized (?:model )?(attribute|element)(?::? '([^']*)')?\s+Element '([^']*)'")


@dataclass
class _Element:
    attributes: list[str] = field(default_factory=list)
    children: dict[str, "_Element"] = field(default_factory=dict)

    def child(self, tag: str) -> "_Element | None":
        return self if tag in RECURSIVE and self.children.get(tag) is None else self.children.get(tag)


def expected(message: str, text: str, line: int, schema: str) -> str:
    """The end of a refusal: what may stand where the compiler found something unknown; '' where that is not what it says.

    Args:
        message: the compiler's words. text: what it was given, sound XML. line: of the element, from 1.
    """
    found = _UNKNOWN.search(message)
    if found is None:
        return ""
    path = next((path for number, path, _ in _elements(text) if number == line), ())
    if not path or path[-1] != found[3]:
        return ""
    if found[1] == "attribute":
        return _one_of(found[2], _attributes(schema, path))
    return _one_of(path[-1], _children(schema, path[:-1]), "<{}>")


def misspelt(text: str, schema: str) -> tuple[int, str] | None:
    """Line and fault of the first element within a <frame> or <replicate> that has an attribute unknown to the schema."""
    if not any(f"<{tag}" in text for tag in OUTSIDE):
        return None
    for number, path, attributes in _elements(text):
        if OUTSIDE.keys().isdisjoint(path):
            continue
        valid = _attributes(schema, path)
        for name in attributes:
            if valid and name not in valid:
                return number, f"attribute {quoted(name, 60)} is unknown{_one_of(name, valid)}"
    return None


def _one_of(name: str, valid: Sequence[str], form: str = "{}") -> str:
    return f", expected one of {', '.join(valid)}{did_you_mean(name, valid, form)}" if valid else ""


def _attributes(schema: str, path: Sequence[str]) -> Sequence[str]:
    """Those that an element may have; none where the schema does not know it."""
    node = _node(schema, path)
    return OUTSIDE.get(path[-1]) or (node.attributes if node else ())


def _children(schema: str, path: Sequence[str]) -> Sequence[str]:
    """What may stand in an element."""
    node = _node(schema, path)
    if node is None:
        return ()
    return (*node.children, *RECURSIVE) if path[-1] in ("worldbody", *RECURSIVE) else tuple(node.children)


def _node(schema: str, path: Sequence[str]) -> _Element | None:
    node: _Element | None = _tree(schema)
    for tag in path[1:]:
        node = node and node.child(tag)
    return node


@lru_cache(maxsize=1)
def _tree(schema: str) -> _Element:
    """The root of the schema; a row is indented by three a level, and what follows without a name belongs to the row above."""
    above = [_Element()]
    for row in schema.splitlines():
        told = _ROW.fullmatch(row)
        if told is None:
            above[-1].attributes += row.split()
            continue
        del above[len(told[1]) // 3 + 1 :]
        name = "worldbody" if told[2] == BODY else told[2]
        above.append(above[-1].children.setdefault(name, _Element()))
        above[-1].attributes += told[4].split()
        if told[2] == "default":
            above[-1].children["default"] = above[-1]
    return above[1] if len(above) > 1 else above[0]


def _elements(text: str) -> Iterator[tuple[int, tuple[str, ...], Sequence[str]]]:
    """Each element of a sound text: the line on which its tag ends, the tags from the root to it, its attributes."""
    parser: ElementTree.XMLPullParser[ElementTree.Element] = ElementTree.XMLPullParser(("start", "end"))
    path: tuple[str, ...] = ()
    for number, row in enumerate(text.splitlines(keepends=True), 1):
        parser.feed(row)
        for event, element in cast("Iterator[tuple[str, ElementTree.Element]]", parser.read_events()):
            if event == "end":
                path = path[:-1]
                continue
            path = (*path, element.tag)
            yield number, path, tuple(element.attrib)
