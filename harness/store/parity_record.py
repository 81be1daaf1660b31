"""What a comparison of robot files came to, as one sealed file that a page can be made from."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from plumbline.harness.store.disk import make_folder, write_atomically
from plumbline.harness.store.seal import Damaged, check_seal, sealed_json

FILE = "parity.json"
SCHEMA = 1
Verdict = Literal["same", "differs", "refused"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Side:
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
    sides: tuple[Side, ...]
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
    sides = (Side(**{**side, "rows": tuple(side["rows"]), "notes": tuple(side["notes"])}) for side in table.pop("sides"))
    return ParityRecord(**table, sides=tuple(sides))
