"""An audit of importers: what each engine's own loader makes of a robot file, beside what the file states.

Each loader runs in a process of its own with a deadline: vendors' parsers crash and hang.
"""

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from plumbline.harness.adapter import Unsupported
from plumbline.harness.intake.import_wishes import Root, Wishes
from plumbline.harness.intake.safe_text import one_line
from plumbline.harness.scene.parity.comparison import compare
from plumbline.harness.scene.parity.difference import Difference
from plumbline.harness.scene.parity.facts import RobotFacts
from plumbline.harness.scene.parity.kinds import kind_of
from plumbline.harness.scene.parity.loaded import Loaded, Request, restored
from plumbline.harness.scene.parity.stated import audited
from plumbline.harness.study import plugins

DEADLINE = 120.0
"""Seconds that a loader may take, its engine's import included."""
_DERIVED = ("gravity torque", "mass matrix", "acceleration")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reading:
    """What one loader made of the file.

    Terms:
        engine, way: as in `Adapter.loaders`. stated: what the file states. source: the loader with its version, in words.
        refused: why it made nothing; '' where it did. rows: what differs. matrix_gap: as in Loaded. notes: in words.
    """

    engine: str
    way: str
    stated: RobotFacts
    root: Root
    source: str = ""
    refused: str = ""
    rows: tuple[Difference, ...] = ()
    matrix_gap: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """Engine and way."""
        return f"{self.engine} {self.way}".strip()

    @property
    def undocumented(self) -> tuple[Difference, ...]:
        """The rows that are no default which the engine's documentation tells."""
        return tuple(row for row in self.rows if not row.documented)


def audit(file: Path, wishes: Wishes, tolerance: float, seed: int = 0) -> Iterator[Reading]:
    """One reading for each way of each engine that reads robot files. Raises: RobotError."""
    stated, root = audited(file, wishes)
    for engine in plugins.names("adapters"):
        adapter = plugins.adapter(engine)
        for way in adapter.loaders:
            reading = Reading(engine=engine, way=way, stated=stated, root=root)
            try:
                loaded = loaded_apart(engine, Request(way=way, root=root, packages=wishes.packages), file)
            except Unsupported as error:
                yield replace(reading, refused=str(error))
                continue
            rows = [replace(row, kind=kind_of(row)) for row in compare(stated, loaded.facts, tolerance, seed)]
            yield replace(
                reading,
                source=loaded.facts.source,
                rows=_documented(rows, adapter.loader_defaults.get((way, file.suffix.lower()), {})),
                matrix_gap=loaded.matrix_gap,
                notes=loaded.notes,
            )


def _documented(rows: list[Difference], defaults: Mapping[str, str]) -> tuple[Difference, ...]:
    """The rows, each with the place that documents it; what follows from documented rows alone is documented too."""
    marked = [replace(row, documented=defaults.get(row.quantity, "")) for row in rows]
    causes = [row for row in marked if row.quantity not in _DERIVED]
    if not causes or not all(row.documented for row in causes):
        return tuple(marked)
    return tuple(replace(row, documented=row.documented or causes[0].documented) for row in marked)


def loaded_apart(name: str, request: Request, path: Path) -> Loaded:
    """What an engine's loader makes of a file. Raises: Unsupported, with why it does not."""
    with TemporaryDirectory(prefix="plumbline-loader-") as scratch:
        out = Path(scratch) / "loaded.json"
        packages = [f"{package}={folder.resolve()}" for package, folder in request.packages.items()]
        asked = [name, str(path.resolve()), str(out), request.way, request.root, *packages]
        command = [sys.executable, "-m", "plumbline.harness.run.loader_child", *asked]
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=DEADLINE, check=False)
        except subprocess.TimeoutExpired:
            raise Unsupported("the file", f"the loader did not end within {DEADLINE:g} s") from None
        if done.returncode != 0 or not out.is_file():
            message = one_line(done.stderr.decode("utf-8", "replace").strip()[-300:], 300)
            raise Unsupported("the file", f"the loader died with code {done.returncode}: {message}")
        answer = json.loads(out.read_text(encoding="utf-8"))
    if "why" in answer:
        raise Unsupported(answer["what"], one_line(answer["why"], 400))
    return restored(answer)
