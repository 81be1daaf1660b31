"""Files that come from outside, read as a stranger's: what kind of file it is, its size, its depth and its counts come first.

A parser sees a text only once it is known to be no longer, no deeper and no fuller than `harness.intake.allowance` says, so
that no file costs more than what it is allowed to hold.
"""

import json
import os
import re
import stat
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from plumbline.harness.intake.allowance import Allowance, AllowanceError, allowance, beyond
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted, readable

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}
_COUNTED = ("bodies", "joints", "sensors")

_STRING = r'"(?:[^"\\]++|\\.)*+"?'
_LONG = r"(?<![0-9_])[0-9][0-9_]{{{digits},}}"
_BARE = r"[A-Za-z0-9_-]++"
_TOML_STRING = (
    r'"""(?:[^"\\]++|\\.|"(?!""))*+"*+',
    r"'''(?:[^']++|'(?!''))*+'*+",
    r'"(?:[^"\\\n]++|\\.)*+"?',
    r"'[^'\n]*+'?",
)
_PART = rf"(?:{_BARE}|{_TOML_STRING[2]}|{_TOML_STRING[3]})"
_CHAIN = rf"(?<![A-Za-z0-9_-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{3,}}+"
"""A dotted key of four parts or more: shorter ones may as well be numbers, of which there are many."""


class InputError(PlumblineError, ValueError):
    """A file that cannot be read, or holds more than is allowed; the message names it, the place and what was expected."""


def document(path: Path) -> Any:
    """What a file ending in .toml or .json says. Raises: InputError."""
    if path.suffix not in {".toml", ".json"}:
        raise InputError(f"{named(path)}: ending {quoted(path.suffix)}, expected .toml or .json")
    return parsed(read(path), named(path), path.suffix)


def named(path: Path | str) -> str:
    """A path in words."""
    return readable(str(path).replace("\n", "\\n").replace("\t", "\\t"), 300)


def read(path: Path) -> str:
    """The text of a regular file in UTF-8 of at most `bytes`, which is looked at before it is opened. Raises: InputError."""
    where = named(path)
    try:
        _check(where, path.stat())
        # Between the two looks it may have become another file: a pipe without a writer must not stop us.
        with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC), "rb") as file:
            _check(where, os.fstat(file.fileno()))
            content = file.read(allowance().bytes + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError | AllowanceError):
            raise
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{where}: not readable: {reason}; expected a file") from None
    _check_size(where, len(content))
    try:
        return content.decode()
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{where}: line {line}: byte 0x{content[error.start]:02x} at {error.start} is no UTF-8 ({error.reason}); "
            "expected a text file in UTF-8"
        ) from None


def regular(path: Path) -> None:
    """Check that a path is a regular file, of any size. Raises: InputError, OSError."""
    _check_kind(named(path), path.stat())


def _check(where: str, status: os.stat_result) -> None:
    _check_kind(where, status)
    _check_size(where, status.st_size)


def _check_kind(where: str, status: os.stat_result) -> None:
    kind = stat.S_IFMT(status.st_mode)
    if kind != stat.S_IFREG:
        raise InputError(f"{where}: is {_KINDS.get(kind, 'no regular file')}, expected a file")


def _check_size(where: str, size: int) -> None:
    if excess := beyond("bytes", size):
        raise InputError(f"{where}: {excess}")


def parsed(text: str, where: str, ending: str) -> Any:
    """What a text says in TOML or JSON, by the ending. Raises: InputError."""
    for line, excess in (_toml_outline if ending == ".toml" else _json_outline)(text):
        raise InputError(f"{where}: {f'line {line}: ' if line else ''}{excess}")
    try:
        return tomllib.loads(text) if ending == ".toml" else json.loads(text, object_pairs_hook=_once)
    except _Doubled as error:
        raise InputError(f"{where}: {error}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: not readable: {readable(str(error), 300)}") from None


class _Doubled(Exception):
    """A key that stands twice in an object, in words."""


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        seen: dict[str, Any] = {}
        for name, value in pairs:
            if name in seen:
                of = f" of {quoted(made['name'], 80)}" if isinstance(made.get("name"), str) else ""
                both = f"with {quoted(seen[name], 60)} and {quoted(value, 60)}"
                raise _Doubled(f"key {quoted(name, 80)}{of} stands twice, {both}; expected once")
            seen[name] = value
    return made


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


def _too_long(text: str, matched: re.Match[str]) -> str:
    before = text[max(0, matched.start() - 40) : matched.start()].rpartition("\n")[2]
    digits = len(matched[0].replace("_", ""))
    return f"{quoted((before + matched[0][:20]).strip())}...: {beyond('digits', digits, 'digits of a number')}"


class _Nest:
    """The arrays and tables around a place in a text.

    Terms: open: their brackets. within: the top-level key of the outermost. parts, counts: how many there were so far.
    """

    def __init__(self) -> None:
        self.open: list[str] = []
        self.within = ""
        self.parts = 0
        self.counts = dict.fromkeys(_COUNTED, 0)
        self.limits = allowance()

    def push(self, bracket: str, top: int) -> str:
        """One more is opened; what is wrong with that, in words. `top`: how many are open where top-level keys stand."""
        self.open.append(bracket)
        self.parts += 1
        if len(self.open) > self.limits.depth:
            return beyond("depth", len(self.open), "arrays and tables in each other")
        if self.parts > self.limits.parts:
            return beyond("parts", self.parts, "arrays and tables")
        if bracket == "{" and len(self.open) == top + 2 and self.open[top] == "[":
            return self.count(self.within)
        return ""

    def count(self, key: str) -> str:
        """One more element of a top-level array; what is wrong with that, in words."""
        if key not in self.counts:
            return ""
        self.counts[key] += 1
        number = self.counts[key]
        # The rest is not counted: what is refused is refused at once.
        return f"{key}: at least {beyond(key, number)}" if number > getattr(self.limits, key) else ""


def _json_outline(text: str) -> Iterator[tuple[int, str]]:
    """Where a JSON text goes beyond a limit, by line."""
    nest, string = _Nest(), ""
    for matched in re.finditer(rf"{_STRING}|[\[\]{{}}]|{_LONG.format(digits=nest.limits.digits)}", text, re.DOTALL):
        token = matched[0]
        excess = ""
        if token[0] == '"':
            string = token if len(nest.open) == 1 else string
        elif token in "[{":
            if len(nest.open) == 1:
                nest.within = string.strip('"')
            excess = nest.push(token, 1)
        elif token in "]}":
            del nest.open[-1:]
        else:
            excess = _too_long(text, matched)
        if excess:
            yield _line(text, matched.start()), excess
            return


def _toml_outline(text: str) -> Iterator[tuple[int, str]]:
    """Where a TOML text goes beyond a limit, by line."""
    nest = _Nest()
    header = rf"(?P<header>(?m:^)[ \t]*+\[\[?[ \t]*+{_PART}(?:[ \t]*+\.[ \t]*+{_PART})*+[ \t]*+\])"
    long = _LONG.format(digits=nest.limits.digits)
    others = "|".join(
        (
            rf"(?P<skipped>{'|'.join(_TOML_STRING[:2])}|#[^\n]*+)",
            rf"(?P<long>{long})",
            rf"(?P<chain>{_CHAIN})",
            rf"(?P<string>{'|'.join(_TOML_STRING[2:])})",
            r"(?P<bracket>[\[\]{}])",
        )
    )
    outside, inside = (re.compile(pattern, re.DOTALL) for pattern in (f"{header}|{others}", others))
    position = 0
    while matched := (inside if nest.open else outside).search(text, position):
        token, position, excess = matched[0], matched.end(), ""
        match matched.lastgroup:
            case "header":
                names = re.findall(_PART, token)
                nest.parts += 1
                excess = _deep(names, nest.limits)
                if token.lstrip().startswith("[[") and len(names) == 1:
                    excess = excess or nest.count(names[0].strip("\"'"))
            case "chain":
                tail = re.compile(long).search(text, matched.start(), matched.end())
                excess = _deep(re.findall(_PART, token), nest.limits) or (_too_long(text, tail) if tail else "")
            case "long":
                excess = _too_long(text, matched)
            case "bracket" if token in "[{":
                if not nest.open:
                    nest.within = _key_before(text, matched.start())
                excess = nest.push(token, 0)
            case "bracket":
                del nest.open[-1:]
        if excess:
            yield _line(text, matched.start()), excess
            return


def _deep(names: list[str], limits: Allowance) -> str:
    """What is wrong with a dotted key of these parts, in words."""
    return beyond("depth", len(names), "tables in each other") if len(names) > limits.depth else ""


def _key_before(text: str, place: int) -> str:
    """The key whose value begins at a place outside of all arrays and tables."""
    line = text[max(text.rfind("\n", 0, place) + 1, place - 100) : place]
    return line.partition("=")[0].strip(" \t\"'")
