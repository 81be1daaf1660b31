"""Which texts decide an answer: the files that a plug-in's module imports, directly or through others, and their digests.

Nothing is listed by hand: the import statements of each file are read without running it, and followed as long as they lead
into our packages or the plug-in's own. What other packages do is covered by their versions.
"""

import ast
import hashlib
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
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
MOVING = ("adapter", "stepping", "acting", "libraries")
"""The sources of an answer that move the run; all others only judge it. 'acting' is that of a case whose code runs while an
engine steps."""
ORIGINS = {
    "adapter": "the adapter's source",
    "stepping": "the harness that steps",
    "case": "the case's source",
    "harness": "the harness that measures",
    "truth": "the engine that makes the truth",
}
"""What sources are called; 'acting' is told as the case's."""
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
def _named(statement: str) -> tuple[tuple[str, str, int], ...]:
    """What a statement imports: a module, the name that is taken from it, '' for itself, and the dots before; nothing where it
    is none."""
    try:
        (parsed,) = ast.parse(dedent(statement)).body
    except (SyntaxError, ValueError):
        return ()
    if isinstance(parsed, ast.Import):
        return tuple((alias.name, "", 0) for alias in parsed.names)
    if not isinstance(parsed, ast.ImportFrom):
        return ()
    return tuple((parsed.module or "", alias.name, parsed.level) for alias in parsed.names)


def _statements(module: str) -> list[str]:
    path = _file(module)
    return [] if path is None else _STATEMENT.findall(_text(path).decode("utf-8", "replace"))


@cache
def _asked(module: str) -> frozenset[tuple[str, str]]:
    """What a module imports of our packages and its own, wherever in the file: a module, and a name of it or ''."""
    path = _file(module)
    package = module.split(".") if path is not None and path.name == "__init__.py" else module.split(".")[:-1]
    asked = set()
    for statement in _statements(module):
        for base, name, level in _named(statement):
            whole = ".".join([*package[: len(package) - level + 1], base]).strip(".") if level else base
            if whole.partition(".")[0] in (module.partition(".")[0], _OURS):
                asked.add((whole, name))
    return frozenset(asked)


def _with_packages(name: str) -> Iterator[str]:
    """A dotted name, and those of the packages that it lies in."""
    parts = name.split(".")
    return (".".join(parts[:count]) for count in range(1, len(parts) + 1))


def _there(names: Iterable[str]) -> frozenset[str]:
    """Those of dotted names that are modules which may decide an answer."""
    return frozenset(name for name in names if not keeps(name) and _file(name) is not None)


@cache
def imported(module: str) -> frozenset[str]:
    """The modules of our packages and its own that one imports, wherever in the file, and the packages that these lie in."""
    return _there(dotted for base, name in _asked(module) for dotted in _with_packages(f"{base}.{name}".strip(".")))


def named(modules: Iterable[str], package: str) -> frozenset[str]:
    """The inner modules of another package that these import from, wherever in the file; `scipy.stats`, say."""
    found = set[str]()
    for module in modules:
        for base, name, _ in (each for statement in _statements(module) for each in _named(statement)):
            found.update(dotted for dotted in (base, f"{base}.{name}".strip(".")) if dotted.startswith(f"{package}."))
    return frozenset(name for name in found if not any(name.startswith(f"{other}.") for other in found))


def keeps(module: str) -> bool:
    """Does a module of ours only find, plan, store or show? The package that holds all of them does nothing."""
    return module == _OURS or any(f"{module}.".startswith(f"{room}.") for room in _KEEPING)


def closure(modules: Iterable[str]) -> frozenset[str]:
    """The modules that these import, directly or through others, of our packages and theirs, but those that only keep."""
    return _reached(modules, imported)


def _reached(modules: Iterable[str], step: Callable[[str], Iterable[str]]) -> frozenset[str]:
    waiting, reached = [*modules], set[str]()
    while waiting:
        module = waiting.pop()
        if module not in reached:
            reached.add(module)
            waiting += _whole() if f"{module}.".startswith(f"{_WHOLE}.") else step(module)
    return frozenset(reached)


def needed(modules: Iterable[str]) -> frozenset[str]:
    """As `closure`, but of a package that only hands on names of its modules those modules alone that names are asked from.

    Such a package is among them too: its text says what it hands on.
    """
    return _reached(modules, _needed_by)


@cache
def _needed_by(module: str) -> frozenset[str]:
    """What `imported` gives, without what packages hand on that nobody here asks for."""
    if _handed_on(module):
        return frozenset()
    return _there(
        dotted
        for base, name in _asked(module)
        for source in _origins(f"{base}.{name}".strip("."))
        for dotted in _with_packages(source)
    )


def _origins(name: str) -> frozenset[str]:
    """The modules that a dotted name leads to: of a name in a package that hands it on, the one that it comes from, of such a
    package all that it hands on, else the module itself or the one that the name is in."""
    if _file(name) is not None:
        return frozenset({name}).union(*(_origins(each.rpartition(".")[0]) for each in _handed_on(name).values()))
    package = name.rpartition(".")[0]
    if not package:
        return frozenset()
    return _origins(_handed_on(package).get(name, package)) | {package}


@cache
def _handed_on(package: str) -> Mapping[str, str]:
    """By the dotted name, where each name comes from that a package has which does nothing but import names from its own
    modules; empty for any other module."""
    path, origins = _file(package), dict[str, str]()
    if path is None or path.name != "__init__.py":
        return {}
    for node in ast.parse(_text(path)).body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{package}."):
            origins |= {f"{package}.{alias.asname or alias.name}": f"{node.module}.{alias.name}" for alias in node.names}
        elif not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)) and not _lists_names(node):
            return {}
    return origins


def _lists_names(node: ast.stmt) -> bool:
    """Is it `__all__ = [...]`?"""
    return isinstance(node, ast.Assign) and [ast.unparse(target) for target in node.targets] == ["__all__"]


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
