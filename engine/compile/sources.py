"""What the engine is made of: digests of its sources, so that a result and a compiled function name the code behind them."""

import hashlib
import os
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

_PACKAGE = "plumbline.engine"
_IMPORT = re.compile(
    rb"^[ \t]*(?:from[ \t]+(plumbline\.engine[\w.]*)[ \t]+import[ \t]*(\([^)]*\)|[^\n]*)"
    rb"|import[ \t]+(plumbline\.engine[\w.]*))",
    re.MULTILINE,
)
"""Every import of a module of this package, wherever in a file it stands."""


def source_digest() -> str:
    """Sixteen hexadecimal digits of every source file of this package, by name and content."""
    return _digest(_modules(_root()).values())


def closure_digest(path: Path) -> str:
    """Sixteen hexadecimal digits of a source file and of all of this package that it imports, itself or through others."""
    return _digest(closure(path))


def closure(path: Path) -> frozenset[str]:
    """The paths of a source file, of all of this package that it imports, itself or through others, and of their rooms.

    The face of the package, which imports everything, belongs to what imports the face alone.
    """
    found: set[str] = set()
    inner = path.parents[: len(path.parts) - len(Path(_root()).parts) - 1] if path.is_relative_to(_root()) else ()
    waiting = [str(path), *(str(room / "__init__.py") for room in inner)]
    while waiting:
        one = waiting.pop()
        if one not in found:
            found.add(one)
            waiting += _imported(one)
    return frozenset(found)


def _root() -> str:
    return str(Path(__file__).parents[1])


@cache
def _modules(root: str) -> Mapping[str, str]:
    """By name, the files of the modules of this package."""
    found = {}
    for folder, _, files in os.walk(root):
        room = ".".join((_PACKAGE, *Path(folder).relative_to(root).parts))
        for name in sorted(files):
            if name.endswith(".py"):
                found[room if name == "__init__.py" else f"{room}.{name.removesuffix('.py')}"] = os.path.join(folder, name)  # noqa: PTH118
    return found


@cache
def _content(path: str) -> bytes:
    return Path(path).read_bytes()


@cache
def _imported(path: str) -> tuple[str, ...]:
    """The files of this package that a file imports; names that are no modules are taken for what a module holds."""
    known, found = _modules(_root()), dict[str, None]()
    for package, names, plain in _IMPORT.findall(_content(path)):
        module = (package or plain).decode()
        inner = [f"{module}.{name.decode()}" for name in re.findall(rb"\w+", names)]
        rooms = [module[:place] for place, letter in enumerate(module) if letter == "." and place > len(_PACKAGE)]
        found |= dict.fromkeys(known[one] for one in (module, *inner, *rooms) if one in known)
    return tuple(found)


def _digest(files: Iterable[str]) -> str:
    digest, root = hashlib.sha256(), _root() + os.sep
    for path in sorted(files):
        digest.update(path.removeprefix(root).encode())
        digest.update(_content(path))
    return digest.hexdigest()[:16]
