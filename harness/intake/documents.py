"""Files that come from outside, read as a stranger's: what kind of file it is and its size come first.

A parser sees a text only once it is known to be no longer and no fuller than `harness.intake.allowance` says, so that no file
costs more than what it is allowed to hold. What is nested without end the parsers refuse themselves, before it costs anything.
"""

import json
import os
import re
import stat
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Any

from plumbline.harness.intake.allowance import AllowanceError, allowance, beyond
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted, readable

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}

_SCANNER = json.JSONDecoder()
_LONG = r"[0-9](?<![\w\"'].)[0-9_]{{{digits},}}"
"""A number of more digits than that; the look behind it comes second, which lets a search skip to the next digit."""
_PART = r"""(?:[A-Za-z0-9_-]++|"(?:[^"\\\n]++|\\.)*+"|'[^'\n]*+')"""
_DOTTED = rf"(?:(?m:^)[ \t]*+\[{{{{0,2}}}}|[{{{{,])[ \t]*+({_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{{{{depth}},}}}}+)"
"""A key or a header of TOML that has more parts than may lie in each other, at the beginning of a line or in a table in a line:
what reading one costs grows with the square of their number."""
_ELEMENTS = ("bodies", "joints", "sensors")
"""What a scene may have so many of that reading them costs memory."""


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
    if excess := _beyond(text, ending == ".toml"):
        raise InputError(f"{where}: {excess}")
    depth = allowance().depth
    too_deep = beyond("depth", depth + 1, "arrays and tables in each other")
    try:
        table = tomllib.loads(text) if ending == ".toml" else json.loads(text, object_pairs_hook=_once)
    except _Doubled as error:
        raise InputError(f"{where}: {error}") from None
    except RecursionError:
        raise InputError(f"{where}: {too_deep}") from None
    except ValueError as error:
        raise InputError(f"{where}: not readable: {readable(str(error), 300)}") from None
    if _is_deeper(table, depth):
        raise InputError(f"{where}: {too_deep}")
    return table


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


def _beyond(text: str, is_toml: bool) -> str:
    """Where a text goes beyond a limit that its parser would pay for, in words; '' where it does not."""
    limits = allowance()
    if long := re.search(_LONG.format(digits=limits.digits), text):
        before = text[max(0, long.start() - 40) : long.start()].rpartition("\n")[2]
        digits = beyond("digits", len(long[0].replace("_", "")), "digits of a number")
        return f"{_line(text, long)}: {quoted((before + long[0][:20]).strip())}...: {digits}"
    for name in _ELEMENTS:
        if excess := beyond(name, (_headers if is_toml else _listed)(text, name)):
            return f"{name}: at least {excess}"
    if is_toml and (dotted := re.search(_DOTTED.format(depth=limits.depth), text)):
        return f"{_line(text, dotted)}: {beyond('depth', len(re.findall(_PART, dotted[1])), 'tables in each other')}"
    return beyond("parts", text.count("[") + text.count("{"), "arrays and tables")


def _line(text: str, match: re.Match[str]) -> str:
    return f"line {text.count(chr(10), 0, match.end()) + 1}"


def _headers(text: str, name: str) -> int:
    """How many tables of an array of tables of this name a text in TOML has."""
    return sum(1 for _ in re.finditer(rf"(?m)^[ \t]*+\[\[[ \t]*+[\"']?{name}[\"']?[ \t]*+\]\]", text))


def _listed(text: str, name: str) -> int:
    """How many values the first array of this name in a text in JSON has, one more than are allowed at most; none is kept."""
    begun, count = re.search(rf'"{name}"\s*+:\s*+\[\s*+', text), 0
    position, most, next_one = begun.end() if begun else len(text), getattr(allowance(), name), re.compile(r"\s*+,?\s*+")
    with suppress(ValueError, RecursionError):  # which reading it all will say
        while count <= most and not text.startswith("]", position) and position < len(text):
            _, position = _SCANNER.raw_decode(text, position)
            if (after := next_one.match(text, position)) is not None:
                count, position = count + 1, after.end()
    return count


def _is_deeper(value: Any, depth: int) -> bool:
    """Do more arrays and tables than so many lie in each other?"""
    if not isinstance(value, dict | list):
        return False
    return depth == 0 or any(_is_deeper(each, depth - 1) for each in (value.values() if isinstance(value, dict) else value))
