"""What robots of a run became: scene, companion and fidelity table of each import, sealed, in a folder named by its content;
and what a comparison of robot files came to.
"""

import hashlib
import json
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import tomli_w
from pydantic import FiniteFloat, TypeAdapter, ValidationError
from typing_extensions import TypedDict

from plumbline.harness.case.undropped import OWN
from plumbline.harness.case.undropped import beside as undropped_beside
from plumbline.harness.scene import PlacedShape
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.scene.importers.fidelity import Imported, plain
from plumbline.harness.scene.importers.replay import Log
from plumbline.harness.store import disk
from plumbline.harness.store.disk import make_folder, write_atomically
from plumbline.harness.store.journal import refuse_links
from plumbline.harness.store.seal import Damaged, check_seal, require_seal, sealed_json, sealed_toml

FOLDER = "scenes"
MINIMAL = "minimal"
"""The folder of scenes that the audit of effects proposes; made from the rest, like a report."""
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


_MEASURED: TypeAdapter[Measured] = TypeAdapter(Measured)


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

    Raises: Damaged.
    """
    path = folder / FOLDER / Path(case).parent.name / _STATES
    if not case.startswith(OWN) or not path.is_file():
        return None
    content = disk.read(path)
    if not check_seal(path, content):
        raise Damaged(f"{path}: it has no checksum")
    try:
        stored = _MEASURED.validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        raise Damaged(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from None
    lengths = {len(values) for values in stored["positions"].values()} - {len(stored["time"])}
    if lengths or not stored["time"] or any(later <= earlier for earlier, later in pairwise(stored["time"])):
        raise Damaged(f"{path}: time: expected rising times, and as many positions of each joint")
    return stored


def kept(folder: Path) -> Iterator[dict[str, Any]]:
    """The fidelity tables of a run folder, each with the name and source of its robot. Raises: Damaged."""
    for _, table in kept_by(folder):
        yield table


def kept_by(folder: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """The same by the name of the folder that each lies in. Raises: Damaged."""
    for path in sorted((folder / FOLDER).glob(f"*/{_TABLE}")):
        content = disk.read(path)
        if not check_seal(path, content):
            raise Damaged(f"{path}: it has no checksum")
        table: dict[str, Any] = json.loads(content)
        yield path.parent.name, table


def looks_of(folder: Path, case: str) -> dict[str, Any]:
    """By body, what is drawn of a robot that a case is made of, as a scene file has it; empty where that is not known."""
    path = folder / FOLDER / Path(case).parent.name / _LOOKS
    if not case.startswith(OWN) or not path.is_file():
        return {}
    content = disk.read(path)
    if not check_seal(path, content):
        raise Damaged(f"{path}: it has no checksum")
    kept_looks: dict[str, Any] = json.loads(content)
    kept_looks.pop("checksum", None)
    return kept_looks


def fidelity_of(folder: Path) -> list[dict[str, Any]]:
    """The rows of all fidelity tables of a run folder, each with its robot. Raises: Damaged."""
    return [{"robot": table["name"], **row} for table in kept(folder) for row in table["rows"]]


def unsound(folder: Path) -> Iterator[tuple[Path, str]]:
    """The files of the folder that are not as they were written, each with what is wrong."""
    for path in sorted((folder / FOLDER).glob("*/*")):
        if path.suffix not in (".toml", ".json") or not path.is_file():
            yield path, "belongs to no import"
            continue
        try:
            require_seal(path, disk.read(path))
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
    make_folder(folder)
    path = folder / FILE
    write_atomically(path, sealed_json(FILE, {"schema": SCHEMA, **asdict(record)}))
    return path


def read(folder: Path) -> ParityRecord:
    """What `write` has written. Raises: OSError, Damaged."""
    path = folder / FILE
    content = path.read_bytes()
    if not check_seal(path, content):
        raise Damaged("it has no seal, expected one at its end")
    table = json.loads(content)
    if table.pop("schema") != SCHEMA:
        raise Damaged(f"its schema is not {SCHEMA}")
    del table["checksum"]
    sides = (ParitySide(**{**side, "rows": tuple(side["rows"]), "notes": tuple(side["notes"])}) for side in table.pop("sides"))
    return ParityRecord(**table, sides=tuple(sides))
