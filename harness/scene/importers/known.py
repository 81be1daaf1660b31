"""The importers that there are: by walking `formats`, and third parties' by the entry point group `plumbline.importers`.

A third party's importer that cannot be loaded, takes an ending that has one already, or is none, is left out, with the
reason; it costs no other one.
"""

import importlib
import pkgutil
from functools import cache
from pathlib import Path

from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.strangers import points, trouble
from plumbline.harness.scene.importers.importer import Importer

GROUP = "plumbline.importers"
OWN_ENDINGS = (".toml", ".json")
"""Of our own scene files, which no importer may take."""


def importers() -> dict[str, Importer]:
    """All importers by name, the built-in ones first."""
    return _found()[0]


def left_out() -> dict[str, str]:
    """Third parties' importers that are not taken, each with the reason."""
    return _found()[1]


def robot_endings() -> tuple[str, ...]:
    """The endings of robot files, with their dots."""
    return tuple(ending for importer in importers().values() for ending in importer.endings)


def importer_of(path: Path) -> Importer:
    """The importer of a file, by its ending. Raises: RobotError, with the endings that there are."""
    ending = path.suffix.lower()
    for importer in importers().values():
        if ending in importer.endings:
            return importer
    lost = "".join(f"; importer {quoted(name, 80)} is left out: {why}" for name, why in left_out().items())
    raise RobotError(f"{named(path)}: ending {quoted(path.suffix)}, expected one of {', '.join(robot_endings())}{lost}")


@cache
def _found() -> tuple[dict[str, Importer], dict[str, str]]:
    import plumbline.harness.scene.importers.formats as package

    known: dict[str, Importer] = {}
    for module in pkgutil.iter_modules(package.__path__):
        importer = importlib.import_module(f"{package.__name__}.{module.name}").IMPORTER
        if reason := _wrong(module.name, importer, known):
            raise TypeError(f"{package.__name__}.{module.name}: {reason}")
        known[module.name] = importer
    lost = {}
    for name, point in points(GROUP).items():
        reason = trouble(point)
        importer = None if reason else point.load()
        reason = reason or _wrong(name, importer, known)
        if reason:
            lost[name] = reason
        else:
            known[name] = importer  # type: ignore[assignment]  # `_wrong` has looked
    return known, lost


def _wrong(name: str, importer: object, known: dict[str, Importer]) -> str:
    """What is wrong with an importer beside those that are known; '' for nothing."""
    if not isinstance(importer, Importer):
        return f"got {type(importer).__name__}, expected an Importer"
    if importer.name != name or name in known:
        return f"its name is {quoted(importer.name, 80)}, expected {quoted(name, 80)}, which no other has"
    taken = {*OWN_ENDINGS, *(ending for other in known.values() for ending in other.endings)}
    for ending in importer.endings:
        if not ending.startswith(".") or ending != ending.lower() or ending in taken:
            return f"ending {quoted(ending, 40)}, expected one in lower case with its dot that no other has"
    return "" if importer.endings else "it has no endings, expected one at least"
