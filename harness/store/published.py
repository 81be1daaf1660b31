"""The dataset that ships with the package: a run folder without journal and trajectories, sealed, so that engines can be judged
without running anything."""

import hashlib
from dataclasses import replace
from pathlib import Path

import tomli_w

from plumbline.harness.store import disk
from plumbline.harness.store.journal import FolderTaken, StoreError, read_written
from plumbline.harness.store.record import Record
from plumbline.harness.store.seal import Damaged, read_sealed, sealed_json, sealed_toml
from plumbline.harness.store.store import Store
from plumbline.harness.store.stored_tables import COLUMNS, in_order, in_parquet


class NotPublished(StoreError):
    """No dataset ships with this package."""


FOLDER = Path(__file__).parents[2] / "published"
MOST_BYTES = 1_000_000
"""Of all its files together: it is part of every installation."""
_PLAIN = ("catalogue.json", "machine.json", "study.toml")
_ABOUT_THE_RUN = ("command", "journal", "tables")
"""What machine.json says of the folder that was published, which nobody has: its command names paths."""


def published(folder: Path | None = None) -> Store:
    """The dataset, that of the package if no folder is given, each file of it as it was written.

    Raises: StoreError, where there is none or it is damaged.
    """
    folder = folder or FOLDER
    path = folder / "machine.json"
    if not path.is_file():
        raise NotPublished(f"{folder}: no published dataset; plumbline publish DIR makes one of a run folder")
    try:
        for name in _PLAIN:
            read_sealed(folder / name)
        store = Store(folder)
        for name in COLUMNS:
            if disk.digest(folder / f"{name}.parquet") != store.machine["tables"].get(name):
                raise Damaged(f"{name}.parquet: its content is not what was published (its checksum differs)")
    except (Damaged, OSError) as error:
        raise StoreError(f"{folder}: {error}; install the package anew") from None
    return store


def publish(store: Store, folder: Path) -> int:
    """Write the dataset of a run folder; returns its bytes.

    Raises: FolderTaken, where the folder holds a run. StoreError, where the run is not whole, or the dataset is larger than
    `MOST_BYTES`. OSError.
    """
    if (folder / "journal.jsonl").exists():
        raise FolderTaken(f"{folder}: holds a run, which a dataset would be written over; choose another --out")
    if not store.machine.get("complete"):
        raise StoreError(f"{store.folder}: the run is not whole; go on with it by --resume")
    written = read_written(store.folder / "journal.jsonl")
    records = [_without_trace(record) for record in in_order(written.records.values())]
    tables = in_parquet(records, compression="zstd")
    machine = {name: value for name, value in store.machine.items() if name not in _ABOUT_THE_RUN}
    machine["tables"] = {name: hashlib.sha256(content).hexdigest() for name, content in tables.items()}
    files = {f"{name}.parquet": content for name, content in tables.items()}
    files["catalogue.json"] = sealed_json("catalogue.json", store.catalogue)
    files["machine.json"] = sealed_json("machine.json", machine)
    files["study.toml"] = sealed_toml("study.toml", tomli_w.dumps(store.study))
    total = sum(map(len, files.values()))
    if total > MOST_BYTES:
        sizes = ", ".join(f"{name} {len(content)}" for name, content in sorted(files.items()))
        raise StoreError(f"{store.folder}: {total} bytes to publish, expected at most {MOST_BYTES} ({sizes}); run fewer trials")
    disk.make_folder(folder)
    for name, content in files.items():
        disk.write_atomically(folder / name, content)
    return total


def _without_trace(record: Record) -> Record:
    """Without what a process printed before it died, which names paths of the machine."""
    return replace(record, detail="")
