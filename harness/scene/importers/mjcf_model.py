"""A compiled MJCF model as arrays with names: the compiler run in a process of its own, and what it says told by line.

What the compiler would have read in the place of a word that it does not know is told by `mj_printSchema`. It holds a file
against that, but not what stands in a <frame> or <replicate>, which lie outside of it: there a misspelt damping is read as
none. So that is looked at here.
"""

import io
import json
import os
import re
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np

from plumbline.harness.intake.bounded import bounded
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import one_line, quoted, readable
from plumbline.harness.scene.importers import mjcf_compiler
from plumbline.harness.scene.importers.mjcf_text import Prepared

DEADLINE = 60.0
"""Seconds that the compiler may take, its start included."""
_NO_WINDOW = {"MUJOCO_GL": "disable"}
"""The compiler draws nothing: MuJoCo would look for a library of windows, in another process each time."""
_LINE = re.compile(r",? line (\d{1,9})")


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """A compiled model.

    Terms: arrays: by MuJoCo's names. names: by kind, of each element, or ''. enums: by kind, word. source: the file, in words.
    sound: arrays that are known to be finite.
    """

    arrays: dict[str, Any]
    names: dict[str, list[str]]
    enums: dict[str, dict[str, int]]
    version: str
    source: str = ""
    sound: set[str] = field(default_factory=set)

    def __getattr__(self, name: str) -> Any:
        """Raises: RobotError, where it is not finite."""
        try:
            values = self.arrays[name]
        except KeyError:
            raise AttributeError(name) from None
        if values.dtype.kind == "f" and name not in self.sound:
            if not np.isfinite(values).all():
                raise RobotError(f"{self.source}: compiled {name} is not finite, expected finite numbers")
            self.sound.add(name)
        return values

    def word(self, kind: str, value: int) -> str:
        """The compiler's word for a number, like 'hinge' for a joint's type."""
        return next((word for word, number in self.enums[kind].items() if number == value), str(value))

    def name(self, kind: str, place: "int | np.integer[Any]") -> str:
        """The name of an element, made up of its kind and place where the file gives none."""
        return self.names[kind][place] or f"{kind}_{place}"

    def flag(self, word: str) -> bool:
        """Is a part of the physics switched off?"""
        return bool(int(self.arrays["opt_disableflags"]) & self.enums["DisableBit"][word])


_SHORT = {"joint": "jnt", "camera": "cam", "equality": "eq"}
_NAMED = ("body", "joint", "geom", "equality", "actuator", "tendon", "key", "sensor", "camera", "light", "site")


def model_of(archive: bytes, source: str) -> Model:
    """The model in an archive that the compiler's process has left."""
    with np.load(io.BytesIO(archive), allow_pickle=False) as kept:
        arrays = {name: kept[name] for name in kept.files}
    words, blob = json.loads(bytes(arrays.pop("words")).decode()), bytes(arrays.pop("names"))
    starts = {kind: arrays[f"name_{_SHORT.get(kind, kind)}adr"].tolist() for kind in _NAMED}
    names = {kind: [blob[at : blob.index(0, at)].decode(errors="replace") for at in at_all] for kind, at_all in starts.items()}
    return Model(arrays, names, words["enums"], words["version"], source)


def compile_apart(text: Prepared, file: str) -> Model:
    """Compile a prepared text in a bounded process. Raises: RobotError, with the line of the file that is at fault."""
    with TemporaryDirectory(prefix="plumbline-mjcf-") as scratch:
        folder = Path(scratch)
        (folder / "model.xml").write_text(text.text, encoding="utf-8")
        for name, raw in text.assets.items():
            (folder / name).write_bytes(raw)
        command = [sys.executable, "-I", str(Path(mjcf_compiler.__file__)), scratch]
        ended = bounded(command, DEADLINE, cwd=scratch, env=os.environ | _NO_WINDOW)
        if ended.code is None:
            raise RobotError(f"{file}: MuJoCo's compiler {ended.how}; expected a smaller model")
        out, error, known = folder / "out.npz", folder / "error.txt", folder / "schema.txt"
        schema = known.read_text(encoding="utf-8") if known.is_file() else ""
        if out.is_file() and ended.code == 0:
            look_for_misspelt(text, schema)
            return model_of(out.read_bytes(), file)
        if error.is_file():
            raise RobotError(said_of(error.read_text(encoding="utf-8", errors="replace"), text, file, schema))
        words = f": {one_line(ended.last_words, 200)}" if ended.last_words else ""
        raise RobotError(f"{file}: MuJoCo's compiler {ended.how} and left no model{words}")


def look_for_misspelt(text: Prepared, schema: str) -> None:
    """Refuse what the compiler passes over without a word. Raises: RobotError."""
    fault = misspelt(text.text, schema)
    if fault is not None:
        raise RobotError(f"{text.lines[fault[0] - 1]}: {fault[1]}")


def said_of(message: str, text: Prepared, file: str, schema: str) -> str:
    """The compiler's words with the line of the original in the place of that of the text that it was given, and with what
    its schema knows there."""
    match = _LINE.search(message)
    where, valid = file, ""
    if match is not None and 1 <= int(match[1]) <= len(text.lines):
        where = text.lines[int(match[1]) - 1]
        valid = expected(message, text.text, int(match[1]), schema)
        message = message[: match.start()] + message[match.end() :]
    words = readable(" ".join(message.split()), 400)
    if "No module named 'mujoco'" in words:
        return f"{file}: MJCF is read by MuJoCo's own compiler, which is not installed; pip install mujoco"
    return f"{where}: MuJoCo's compiler refuses it: {words}{valid}"


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
    unknown = _UNKNOWN.search(message)
    if unknown is None:
        return ""
    path = next((path for number, path, _ in _elements(text) if number == line), ())
    if not path or path[-1] != unknown[3]:
        return ""
    if unknown[1] == "attribute":
        return _one_of(unknown[2], _attributes(schema, path))
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
