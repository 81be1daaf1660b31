"""Which texts decide an answer: the files that a plug-in's module imports, directly or through others, and their digests.

Nothing is listed by hand: the import statements of each file are read without running it, and followed as long as they lead
into our packages or the plug-in's own. What other packages do is covered by their versions.
"""

import ast
import hashlib
import os
import re
from collections.abc import Iterable
from functools import cache
from importlib.machinery import PathFinder
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from textwrap import dedent

_OURS = "plumbline"
_WHOLE = f"{_OURS}.engine"
"""A package that counts as one: its modules load each other on first use."""
_KEEPING = tuple(f"{_OURS}.{room}" for room in ("harness.store", "harness.study", "harness.cli", "reports"))
"""What finds, plans, stores and shows, and decides no answer; what of it enters one is in a trial's name by value."""
_LIBRARIES = ("numpy", "scipy", "numba")
_STATEMENT = re.compile(r"^[ \t]*(?:from|import)\b[^\n(;]*(?:\([^)]*\))?", re.MULTILINE)
"""What may be an import; prose that looks like one does not parse."""


_ROOT = Path(__file__).parents[2]


@cache
def _package(name: str) -> Path | None:
    """The folder or file of a top-level package; None for one that has none."""
    if name == _OURS:
        return _ROOT
    spec = PathFinder.find_spec(name)
    if spec is None or spec.origin is None:
        return None
    return Path(spec.origin).parent if spec.submodule_search_locations else Path(spec.origin)


@cache
def _file(module: str) -> Path | None:
    """The file of a module of a package that is followed; None where there is none."""
    top, *inner = module.split(".")
    package = _package(top)
    if package is None or (package.is_file() and inner):
        return None
    if package.is_file():
        return package
    path = os.path.join(package, *inner)  # noqa: PTH118  # a thousand names are looked up: ten times as fast
    for candidate in (f"{path}.py", f"{path}/__init__.py"):
        if os.path.isfile(candidate):  # noqa: PTH113  # the same
            return Path(candidate)
    return None


@cache
def _text(path: Path) -> bytes:
    return path.read_bytes()


@cache
def _named(statement: str) -> tuple[tuple[str, int], ...]:
    """What a statement imports, each with the number of dots before it; nothing where it is none."""
    try:
        (parsed,) = ast.parse(dedent(statement)).body
    except (SyntaxError, ValueError):
        return ()
    if isinstance(parsed, ast.Import):
        return tuple((alias.name, 0) for alias in parsed.names)
    if not isinstance(parsed, ast.ImportFrom):
        return ()
    base = parsed.module or ""
    names = (f"{base}.{alias.name}".strip(".") for alias in parsed.names)
    return tuple((name, parsed.level) for name in (base, *names) if name)


@cache
def imported(module: str) -> frozenset[str]:
    """The modules of our packages and its own that one imports, wherever in the file, and the packages that these lie in."""
    path = _file(module)
    if path is None:
        return frozenset()
    package = module.split(".") if path.name == "__init__.py" else module.split(".")[:-1]
    top = module.partition(".")[0]
    modules = set[str]()
    for statement in _STATEMENT.findall(_text(path).decode("utf-8", "replace")):
        for name, level in _named(statement):
            whole = [*package[: len(package) - level + 1], *name.split(".")] if level else name.split(".")
            if whole[0] in (top, _OURS):
                modules.update(".".join(whole[:count]) for count in range(1, len(whole) + 1))
    return frozenset(dotted for dotted in modules if not keeps(dotted) and _file(dotted) is not None)


def named(modules: Iterable[str], package: str) -> frozenset[str]:
    """The inner modules of another package that these import from, wherever in the file; `scipy.stats`, say."""
    found = set[str]()
    for module in modules:
        path = _file(module)
        for statement in _STATEMENT.findall("" if path is None else _text(path).decode("utf-8", "replace")):
            found.update(name for name, _ in _named(statement) if name.startswith(f"{package}."))
    return frozenset(name for name in found if not any(name.startswith(f"{other}.") for other in found))


def keeps(module: str) -> bool:
    """Does a module of ours only find, plan, store or show? The package that holds all of them does nothing."""
    return module == _OURS or any(f"{module}.".startswith(f"{room}.") for room in _KEEPING)


def closure(modules: Iterable[str]) -> frozenset[str]:
    """The modules that these import, directly or through others, of our packages and theirs, but those that only keep."""
    waiting, reached = [*modules], set[str]()
    while waiting:
        module = waiting.pop()
        if module not in reached:
            reached.add(module)
            waiting += _whole() if f"{module}.".startswith(f"{_WHOLE}.") else imported(module)
    return frozenset(reached)


@cache
def _whole() -> tuple[str, ...]:
    return tuple(map(_module, sorted((_ROOT / "engine").rglob("*.py"))))


def _module(path: Path) -> str:
    parts = (_OURS, *path.relative_to(_ROOT).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def short_name(module: str) -> str:
    """The file of a module as people call it: harness/trial/accuracy.py."""
    path = _file(module)
    folder = module.removeprefix(f"{_OURS}.").replace(".", "/")
    return f"{folder}/__init__.py" if path is not None and path.name == "__init__.py" else f"{folder}.py"


@cache
def _digest(module: str) -> str:
    path = _file(module)
    return "" if path is None else hashlib.sha256(_text(path)).hexdigest()[:16]


def file_digests(modules: Iterable[str]) -> dict[str, str]:
    """By the short name of each module's file, the digest of its text."""
    return {short_name(module): _digest(module) for module in sorted(modules)}


@cache
def digest_of(modules: frozenset[str]) -> str:
    """Sixteen hexadecimal digits of all their names and texts."""
    return hashlib.sha256("".join(f"{m} {_digest(m)}\n" for m in sorted(modules)).encode()).hexdigest()[:16]


@cache
def libraries() -> str:
    """The versions of the numeric libraries that answers pass through."""
    return ", ".join(f"{name} {known or 'none'}" for name, known in library_versions().items())


def library_versions() -> dict[str, str]:
    """The same by name, '' for one that is not installed."""

    def version_here(name: str) -> str:
        try:
            return version(name)
        except PackageNotFoundError:
            return ""

    return {name: version_here(name) for name in _LIBRARIES}
