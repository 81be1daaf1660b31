"""An audit of importers: what each engine's own loader makes of a robot file, beside what the file states.

Each loader runs in a process of its own with a deadline: vendors' parsers crash and hang.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from plumbline.harness.adapter import Unavailable, Unsupported
from plumbline.harness.intake.apart import NoAnswer, apart
from plumbline.harness.intake.import_wishes import Root, Wishes
from plumbline.harness.intake.safe_text import one_line
from plumbline.harness.scene.parity.canonical import Canonical, canonical, stated
from plumbline.harness.scene.parity.comparison import compare
from plumbline.harness.scene.parity.difference import Difference, kind_of
from plumbline.harness.scene.parity.loaded import Loaded, Own, Request
from plumbline.harness.study import plugins

DEADLINE = 120.0
"""Seconds that a loader may take, its engine's import included."""
_DERIVED = ("gravity torque", "mass matrix", "acceleration")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoaderReading:
    """What one loader made of the file.

    Terms:
        engine, way: as in `Adapter.loaders`. stated: what the file states. source: the loader with its version, in words.
        refused: why it made nothing; '' where it did. rows: what differs. own: what the loader gives that the file has no word
        for, a row a quantity; it counts as no difference. matrix_gap: as in Loaded. notes: in words.
    """

    engine: str
    way: str
    stated: Canonical
    root: Root
    source: str = ""
    refused: str = ""
    rows: tuple[Difference, ...] = ()
    own: tuple[Difference, ...] = ()
    matrix_gap: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """Engine and way."""
        return f"{self.engine} {self.way}".strip()

    @property
    def own_words(self) -> str:
        """What the loader gives that the file has no word for, in words; '' for nothing."""
        return ", ".join(f"{row.element} {_numbers(row)}".rstrip() for row in self.own)

    @property
    def undocumented(self) -> tuple[Difference, ...]:
        """The rows that are no default which the engine's documentation tells."""
        return tuple(row for row in self.rows if not row.documented)


def audit(file: Path, wishes: Wishes, tolerance: float, seed: int = 0) -> Iterator[LoaderReading]:
    """One reading for each way of each engine that reads robot files. Raises: RobotError."""
    robot, root = stated(file, wishes)
    for engine in plugins.names("adapters"):
        adapter = plugins.adapter(engine)
        for way in adapter.loaders:
            reading = LoaderReading(engine=engine, way=way, stated=robot, root=root)
            try:
                loaded = loaded_apart(engine, Request(way=way, root=root, packages=wishes.packages), file)
            except Unsupported as error:
                yield replace(reading, refused=str(error))
                continue
            made = canonical(loaded.robot, read_back=True)
            rows = [replace(row, kind=kind_of(row)) for row in compare(robot, made, tolerance, seed)]
            yield replace(
                reading,
                source=loaded.robot.source,
                rows=_documented(rows, adapter.loader_defaults.get((way, file.suffix.lower()), {})),
                own=tuple(_own(each, tolerance) for each in loaded.own if file.suffix.lower() == ".urdf"),
                matrix_gap=loaded.matrix_gap,
                notes=loaded.notes,
            )


def _numbers(row: Difference) -> str:
    values = row.value_B if isinstance(row.value_B, tuple) else (row.value_B,)
    return f"{' or '.join(f'{value:g}' for value in values)} {'' if row.unit == '1' else row.unit}"


def _own(given: Own, tolerance: float) -> Difference:
    value = given.values[0] if len(given.values) == 1 else given.values
    return Difference(
        quantity="own value", element=given.quantity, value_A=None, value_B=value, unit=given.unit, tolerance=tolerance,
        kind="own value", words="the file has no word for it",
    )  # fmt: skip


def _documented(rows: list[Difference], defaults: Mapping[str, str]) -> tuple[Difference, ...]:
    """The rows, each with the place that documents it; what follows from documented rows alone is documented too."""
    marked = [replace(row, documented=defaults.get(row.quantity, "")) for row in rows]
    causes = [row for row in marked if row.quantity not in _DERIVED]
    if not causes or not all(row.documented for row in causes):
        return tuple(marked)
    return tuple(replace(row, documented=row.documented or causes[0].documented) for row in marked)


@dataclass(frozen=True, slots=True, kw_only=True)
class LoaderAnswer:
    """What a loader made of a file; or, by `what` and `why`, that it made nothing."""

    loaded: Loaded | None = None
    what: str = ""
    why: str = ""


def loaded_apart(name: str, request: Request, path: Path) -> Loaded:
    """What an engine's loader makes of a file. Raises: Unsupported, with why it does not."""
    packages = {package: folder.resolve() for package, folder in request.packages.items()}
    try:
        answer = apart(LoaderAnswer, DEADLINE, loader_answer, name, path.resolve(), replace(request, packages=packages))
    except NoAnswer as error:
        raise Unsupported("the file", f"the loader {one_line(str(error), 300)}") from None
    if answer.loaded is None:
        raise Unsupported(answer.what, one_line(answer.why, 400))
    return answer.loaded


def loader_answer(name: str, path: Path, request: Request) -> dict[str, Any]:
    """What a loader made of a file as an LoaderAnswer in plain values; in its own process."""
    try:
        answer = LoaderAnswer(loaded=plugins.adapter(name).load_robot(path, request))
    except Unsupported as error:
        answer = LoaderAnswer(what=error.what, why=error.why)
    except Unavailable as error:
        answer = LoaderAnswer(what="the engine", why=str(error))
    plain: dict[str, Any] = TypeAdapter(LoaderAnswer).dump_python(answer, mode="json")
    return plain
