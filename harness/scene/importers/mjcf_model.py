"""A compiled MJCF model as arrays with names: the compiler run in a process of its own, and what it says told by line."""

import io
import json
import os
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from plumbline.harness.intake.bounded import bounded
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import one_line, readable
from plumbline.harness.scene.importers import mjcf_compiler
from plumbline.harness.scene.importers.mjcf_schema import expected, misspelt
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
