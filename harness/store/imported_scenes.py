"""What robots of a run became: scene, companion and fidelity table of each import, sealed, in a folder named by its content;
and what a comparison of robot files came to.
"""

import hashlib
import json
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from errno import ENOENT
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import tomli_w
from pydantic import FiniteFloat, TypeAdapter
from typing_extensions import TypedDict

from plumbline.harness.case.undropped import OWN
from plumbline.harness.case.undropped import beside as undropped_beside
from plumbline.harness.scene import PlacedShape
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.scene.importers.fidelity import plain
from plumbline.harness.scene.importers.imported import Imported
from plumbline.harness.scene.importers.replay import Log
from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile, refuse_links
from plumbline.harness.store.record import checked
from plumbline.harness.store.seal import Damaged, read_sealed, sealed_json, sealed_toml
from plumbline.harness.store.store import read_plain, write_json

FOLDER = "scenes"
MINIMAL = "minimal"
"""The folder of scenes that the audit of effects proposes; made from the rest, like a report."""
CURE = "run the robot's file again into this folder with --resume"
"""What to do about a file here that is not as it was written."""
_TABLE = "fidelity.json"
_LOOKS = "looks.json"
_STATES = "states.json"
_SHAPES: TypeAdapter[dict[str, tuple[PlacedShape, ...]]] = TypeAdapter(dict[str, tuple[PlacedShape, ...]])
_UNSAFE = re.compile(r"[^A-Za-z0-9_-]+")


class Measured(TypedDict):
    """What a log said of joints, from its first line on. Terms: source: the file, in words. time [s]; positions by joint."""

    source: str
    time: list[FiniteFloat]
    positions: dict[str, list[FiniteFloat]]


def keep(folder: Path, imported: Imported, states: Log | None = None) -> Path:
    """Write an import into a run folder; the same one is written once. Returns: the scene file.

    Raises: OSError; StoreError, where the run folder is not its own.

    Args: states: positions of its joints that were measured, to compare with.
    """
    name = _UNSAFE.sub("_", imported.name).strip("_")[:80] or "scene"
    table = {
        "name": imported.name,
        "source": imported.source,
        "dropped": list(imported.dropped),
        "coordinates": dict(imported.coordinates),
        "links": dict(imported.links),
        "rows": [plain(row) for row in imported.fidelity],
    }
    wishes = {key: value for key in ("duration", "dt", "seed") if (value := getattr(imported, key)) is not None}
    if imported.look_at:
        wishes["look_at"] = list(imported.look_at)
    scene = dump_toml(imported.scene)
    whole = [] if imported.undropped is None else [dump_toml(imported.undropped)]
    measured = None if states is None else _plain_log(states)
    whole += [] if measured is None else [json.dumps(measured)]
    digest = hashlib.sha256(json.dumps([scene, table, wishes, *whole]).encode()).hexdigest()[:12]
    refuse_links(folder)
    directory = folder / FOLDER / digest
    disk.make_folder(directory)
    files = {f"{name}.toml": sealed_toml(f"{name}.toml", scene), _TABLE: sealed_json(_TABLE, table)}
    for text in whole[: imported.undropped is not None]:
        file = undropped_beside(directory / f"{name}.toml").name
        files[file] = sealed_toml(file, text)
    if measured is not None:
        files[_STATES] = sealed_json(_STATES, measured)
    if imported.looks:
        files[_LOOKS] = sealed_json(_LOOKS, _SHAPES.dump_python(dict(imported.looks), mode="json"))
    if wishes:
        files[f"{name}.plumb.toml"] = sealed_toml(f"{name}.plumb.toml", tomli_w.dumps(wishes))
    for file, content in files.items():
        if not (directory / file).exists() or disk.read(directory / file) != content:
            disk.write_atomically(directory / file, content)
    return directory / f"{name}.toml"


def _plain_log(log: Log) -> Measured:
    start = log.time[0]
    columns = {joint: list(values) for (joint, _), values in log.columns.items()}
    return {"source": log.source, "time": [t - start for t in log.time], "positions": columns}


def states_of(folder: Path, case: str) -> Measured | None:
    """What was measured of the robot that a case is made of: source, time [s], positions by joint; None without.

    Raises: DamagedFile.
    """
    path = folder / FOLDER / Path(case).parent.name / _STATES
    table = read_plain(path) if case.startswith(OWN) else {}
    if not table:
        return None
    try:
        stored = checked(Measured, table, "states")
        lengths = {len(values) for values in stored["positions"].values()} - {len(stored["time"])}
        if lengths or not stored["time"] or any(later <= earlier for earlier, later in pairwise(stored["time"])):
            raise ValueError("holds no states: time: expected rising times, and as many positions of each joint")
    except ValueError as error:
        raise DamagedFile(path, str(error), CURE) from None
    return stored


def kept_by(folder: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """The fidelity tables of a run folder, each with the name and source of its robot, by the folder that it lies in.

    Raises: DamagedFile.
    """
    for path in sorted((folder / FOLDER).glob(f"*/{_TABLE}")):
        yield path.parent.name, read_plain(path)


def looks_of(folder: Path, case: str) -> dict[str, Any]:
    """By body, what is drawn of a robot that a case is made of, as a scene file has it; empty where that is not known.

    Raises: DamagedFile.
    """
    return read_plain(folder / FOLDER / Path(case).parent.name / _LOOKS) if case.startswith(OWN) else {}


def fidelity_of(folder: Path) -> list[dict[str, Any]]:
    """The rows of all fidelity tables of a run folder, each with its robot. Raises: DamagedFile."""
    return [{"robot": table["name"], **row} for _, table in kept_by(folder) for row in table["rows"]]


def unsound(folder: Path) -> Iterator[tuple[Path, str]]:
    """The files of the folder that are not as they were written, each with what is wrong."""
    for path in sorted((folder / FOLDER).glob("*/*")):
        if path.suffix not in (".toml", ".json") or not path.is_file():
            yield path, "belongs to no import"
            continue
        try:
            read_sealed(path)
        except Damaged as error:
            yield path, str(error)


FILE = "parity.json"
SCHEMA = 1
Verdict = Literal["same", "differs", "refused"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ParitySide:
    """What the first file is held against.

    Terms:
        name: the loader's, or the other file's. engine: '' for a file. source: with its version, in words. refused: why there
        is nothing; '' where there is. rows: what differs, each as `harness.scene.parity.difference.plain` gives it. notes: in
        words. matrix_gap: the largest difference of an engine's own mass matrix from that of what it tells, relative.
    """

    name: str
    engine: str = ""
    source: str = ""
    refused: str = ""
    rows: tuple[dict[str, Any], ...] = ()
    notes: tuple[str, ...] = ()
    matrix_gap: float | None = None

    @property
    def verdict(self) -> Verdict:
        """In a word."""
        return "refused" if self.refused else "differs" if self.rows else "same"


@dataclass(frozen=True, slots=True, kw_only=True)
class ParityRecord:
    """A comparison.

    Terms:
        file: the first one's name. joints: how many it has. root: how it is held. tolerance, seed: as asked. sides: one for
        each loader, or one for the other file. parting: the fields of `harness.scene.parity.parting.Parting`, and `move`, what
        moved both; None where that was not asked.
    """

    file: str
    joints: int
    root: str
    tolerance: float
    seed: int
    sides: tuple[ParitySide, ...]
    parting: dict[str, Any] | None = None


def write(folder: Path, record: ParityRecord) -> Path:
    """`folder/parity.json`, sealed. Raises: OSError."""
    disk.make_folder(folder)
    write_json(folder / FILE, {"schema": SCHEMA, **asdict(record)})
    return folder / FILE


def read(folder: Path) -> ParityRecord:
    """What `write` has written. Raises: OSError, DamagedFile."""
    path = folder / FILE
    if not path.is_file():
        raise FileNotFoundError(ENOENT, "no comparison of robot files", str(path))
    table = read_plain(path)
    try:
        if (schema := table.pop("schema", None)) != SCHEMA:
            raise ValueError(f"has schema {schema}, this program reads {SCHEMA}")
        return checked(ParityRecord, table, "comparison")
    except ValueError as error:
        raise DamagedFile(path, str(error), "compare the files again") from None
