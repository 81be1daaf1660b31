"""What robots of a run became: scene, companion and fidelity table of each import, sealed, in a folder named by its content."""

import hashlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import TypeAdapter

from plumbline.harness.case.own_titles import OWN
from plumbline.harness.case.undropped import beside as undropped_beside
from plumbline.harness.scene import PlacedShape
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.scene.importers.commands import Log
from plumbline.harness.scene.importers.fidelity import plain
from plumbline.harness.scene.importers.imported import Imported
from plumbline.harness.store import disk
from plumbline.harness.store.seal import Damaged, check_seal, require_seal, sealed_json, sealed_toml

FOLDER = "scenes"
MINIMAL = "minimal"
"""The folder of scenes that the audit of effects proposes; made from the rest, like a report."""
_TABLE = "fidelity.json"
_LOOKS = "looks.json"
_STATES = "states.json"
_SHAPES: TypeAdapter[dict[str, tuple[PlacedShape, ...]]] = TypeAdapter(dict[str, tuple[PlacedShape, ...]])
_UNSAFE = re.compile(r"[^A-Za-z0-9_-]+")


def keep(folder: Path, imported: Imported, states: Log | None = None) -> Path:
    """Write an import into a run folder; the same one is written once. Returns: the scene file. Raises: OSError.

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


def _plain_log(log: Log) -> dict[str, Any]:
    start = log.time[0]
    columns = {joint: list(values) for (joint, _), values in log.columns.items()}
    return {"source": log.source, "time": [t - start for t in log.time], "positions": columns}


def states_of(folder: Path, case: str) -> dict[str, Any] | None:
    """What was measured of the robot that a case is made of: source, time [s], positions by joint; None without.

    Raises: Damaged.
    """
    path = folder / FOLDER / Path(case).parent.name / _STATES
    if not case.startswith(OWN) or not path.is_file():
        return None
    content = disk.read(path)
    if not check_seal(path, content):
        raise Damaged(f"{path}: it has no checksum")
    stored: dict[str, Any] = json.loads(content)
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
