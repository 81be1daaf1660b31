"""The tables of a run folder: made from the journal, written as Parquet, and read back."""

import dataclasses
import hashlib
import io
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from plumbline.harness.intake.documents import InputError, regular
from plumbline.harness.store import disk
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.record import Measurement, Record, Sample, Timing

if TYPE_CHECKING:
    import pyarrow as pa

JSON_COLUMNS = ("parameters", "settings", "resolved", "warnings", "alteration", "sources")
BESIDE = ("base", "idle", "notices")
"""What the file of the trials holds beside the columns that people are shown; `idle` and `notices` as JSON."""
COLUMNS = {
    "trials": (
        *("trial", "study", "experiment", "case", "parameters", "engine", "engine_version", "track", "dt", "settings"),
        *("resolved", "seed", "status", "reason", "sim_seconds", "steps", "cpu_per_sim_s", "cpu_low", "cpu_high"),
        *("wall_per_sim_s", "realtime_factor", "unstable_timing", "trajectory_hash", "warnings", "detail", "unit"),
        *("cpu_per_unit", "cpu_per_unit_low", "cpu_per_unit_high", "rough_cost", "rough_ratio", "clocks", "workers", "round"),
        *("alteration", "members", "remedy", "remedied", "substep", "parts", "sources", "answered_on", "clocked_on", "clocked"),
        *("emulated", "timing_note", "recalled", "again", "trajectory_kept", "motion", "simulated_as", "memory"),
    ),
    "measurements": ("trial", *(f.name for f in dataclasses.fields(Measurement))),
    "samples": ("trial", *(f.name for f in dataclasses.fields(Sample))),
}
"""Of each table."""
TABLES = tuple(COLUMNS)
MOST_ROWS = 20_000_000
MOST_BYTES = 2 * 2**30
"""What a table may take once it is unpacked."""
BATCH, PIECE = 5000, 500
"""Trials of a row group, and of what is in Python at once."""
_NUMBERS: dict[Any, str] = {float: "float64", float | None: "float64", int: "int64", bool: "bool", bool | None: "boolean"}
_TYPES = {
    f.name: _NUMBERS[f.type]
    for table in (Measurement, Sample, Timing, Record)
    for f in dataclasses.fields(table)
    if f.type in _NUMBERS
}
"""Of the columns that hold numbers; all others hold words."""
_JSON = json.JSONEncoder(sort_keys=True)

Rows = dict[str, list[dict[str, Any]]]


Order = tuple[str, str, str, float, int, str, str, str]


def order_of(r: Record) -> Order:
    """How rows of tables stand: by study, experiment, case, the coarsest time step first, ..."""
    return r.study, r.experiment, r.case, -r.dt, r.seed, r.track, r.engine, r.trial


def in_order(records: Iterable[Record]) -> list[Record]:
    """As rows of tables stand."""
    return sorted(records, key=order_of)


def flat(record: Record) -> dict[str, Any]:
    """The row of the trials: what was asked, what came of it and what it took side by side, JSON where a cell holds more."""
    timing = record.timing or _NOT_TIMED
    row = vars(timing) | vars(record) | {"timing_note": timing.note}
    row["warnings"] = [str(notice) for notice in record.notices]
    row["notices"] = [dataclasses.asdict(notice) for notice in record.notices]
    return row | {name: _JSON.encode(row[name]) for name in (*JSON_COLUMNS, "idle", "notices")}


_NOT_TIMED = Timing(trial="")


def _rows(records: Iterable[Record]) -> Rows:
    """The rows of the tables by name."""
    rows: Rows = {name: [] for name in COLUMNS}
    for record in records:
        rows["trials"].append(flat(record))
        samples = () if record.timing is None else record.timing.samples
        for name, values in (("measurements", record.measurements), ("samples", samples)):
            rows[name] += [
                {"trial": record.trial} | {field: getattr(value, field) for field in COLUMNS[name][1:]} for value in values
            ]
    return rows


def _columns(name: str) -> tuple[str, ...]:
    """Those of a table's file."""
    return COLUMNS[name] + (BESIDE if name == "trials" else ())


def tables_of(records: Iterable[Record]) -> dict[str, pd.DataFrame]:
    """The tables by name, as `read_tables` reads what `write_tables` writes."""
    return {
        name: pd.DataFrame({column: _in_python([row[column] for row in rows], column) for column in _columns(name)})
        for name, rows in _rows(in_order(records)).items()
    }


def _in_python(values: list[Any], column: str) -> "pd.Series[Any]":
    """Numbers in their types, and words as Python's own strings, nan for none: reports take rows and cells out of tables by the
    ten thousand, and each string that Arrow keeps is made anew whenever it is looked at."""
    if column in _TYPES:
        return pd.Series(values, dtype=_TYPES[column])
    if all(value is None for value in values):
        return pd.Series(values, dtype=object)
    return pd.Series([math.nan if value is None else value for value in values], dtype=object)


def _in_arrow(tables: Rows) -> dict[str, "pa.Table"]:
    import pyarrow as pa

    kinds = {"float64": pa.float64(), "int64": pa.int64(), "bool": pa.bool_(), "boolean": pa.bool_(), "": pa.string()}
    return {
        name: pa.table(
            {
                column: pa.array([row[column] for row in rows], kinds[_TYPES.get(column, "")], from_pandas=True)
                for column in _columns(name)
            }
        )
        for name, rows in tables.items()
    }


def _batches(records: Iterable[Record]) -> Iterator[dict[str, "pa.Table"]]:
    """What the tables hold of each `BATCH` of records, by name; one without rows where there are none."""
    pieces: list[dict[str, pa.Table]] = []
    for piece in _pieces(records):
        pieces.append(_in_arrow(_rows(piece)))
        if len(pieces) == BATCH // PIECE:
            yield _joined(pieces)
            pieces.clear()
    if pieces:
        yield _joined(pieces)


def _pieces(records: Iterable[Record]) -> Iterator[list[Record]]:
    """`PIECE` records after the other; an empty one where there are none."""
    remaining = iter(records)
    yield list(islice(remaining, PIECE))
    while piece := list(islice(remaining, PIECE)):
        yield piece


def _joined(pieces: Sequence[Mapping[str, "pa.Table"]]) -> dict[str, "pa.Table"]:
    import pyarrow as pa

    return {name: pa.concat_tables([piece[name] for piece in pieces]).combine_chunks() for name in COLUMNS}


def in_parquet(records: Iterable[Record], compression: str = "snappy") -> dict[str, bytes]:
    """The files of the tables by name, of records in order; equal records have equal bytes."""
    from pyarrow.parquet import ParquetWriter  # late: it takes a while

    files = {name: io.BytesIO() for name in COLUMNS}
    writers: dict[str, ParquetWriter] = {}
    for batch in _batches(records):
        for name, table in batch.items():
            if name not in writers:
                writers[name] = ParquetWriter(files[name], table.schema, compression=compression)
            writers[name].write_table(table)
    for writer in writers.values():
        writer.close()
    return {name: file.getvalue() for name, file in files.items()}


def write_tables(folder: Path, records: Iterable[Record]) -> dict[str, str]:
    """Write the tables of these records, which are in order, and give the digest of each file's bytes. Raises: OSError."""
    digests = {}
    for name, content in disk.calls.filled(lambda: in_parquet(records)).items():
        disk.write_atomically(folder / f"{name}.parquet", content)
        digests[name] = hashlib.sha256(content).hexdigest()
    return digests


def read_tables(folder: Path) -> dict[str, pd.DataFrame]:
    """The tables by name, which another program may have written: looked at, then read. Raises: StoreError."""
    tables = {name: _table(folder / f"{name}.parquet", needed) for name, needed in _NEEDED.items()}
    for column, blank in _LATER.items():
        if column not in tables["trials"]:
            tables["trials"][column] = blank
    for column in (column for column in JSON_COLUMNS if column in tables["trials"]):
        for text in dict.fromkeys(tables["trials"][column]):
            try:
                whole = isinstance(json.loads(text), dict | list)
            except (TypeError, ValueError, RecursionError):
                whole = False
            if not whole:
                raise StoreError(f"{folder / 'trials.parquet'}: column {column}: got {str(text)[:80]!r}, expected JSON")
    return tables


_LATER = {"motion": "", "simulated_as": "", "memory": math.nan}
"""Columns of the trials that older versions did not write, and what stands there then."""
_NEEDED = {
    "trials": tuple(name for name in COLUMNS["trials"] if name not in _LATER),
    "measurements": ("trial", "metric", "value"),
    "samples": ("trial",),
}


def _table(path: Path, columns: Sequence[str]) -> pd.DataFrame:
    from pyarrow.parquet import ParquetFile

    try:
        regular(path)
        file = ParquetFile(path)
        size = sum(file.metadata.row_group(group).total_byte_size for group in range(file.metadata.num_row_groups))
        rows = file.metadata.num_rows
        missing = [column for column in columns if column not in file.schema_arrow.names]
        if rows > MOST_ROWS or size > MOST_BYTES:
            raise StoreError(f"{path}: {rows} rows in {size} bytes, expected at most {MOST_ROWS} in {MOST_BYTES}")
        if missing:
            raise StoreError(f"{path}: has no column {', '.join(missing)}; expected the tables of a run")
        arrow = file.read()
        return pd.DataFrame({name: _read(name, arrow[name]) for name in arrow.column_names})
    except InputError as error:
        raise StoreError(str(error)) from None
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise StoreError(f"{path}: not readable: {' '.join(str(error).split())[:300]}") from error


def _read(name: str, column: "pa.ChunkedArray") -> "pd.Series[Any]":
    """As `_in_python` has it; equal words are one string."""
    import pyarrow as pa

    if not (pa.types.is_string(column.type) or pa.types.is_large_string(column.type)):
        values: pd.Series[Any] = column.to_pandas()
        return values.astype(_TYPES.get(name, values.dtype))
    coded = column.combine_chunks().dictionary_encode()
    words = np.array([*coded.dictionary.to_pylist(), None if coded.null_count == len(coded) else math.nan], dtype=object)
    return pd.Series(words[coded.indices.fill_null(len(words) - 1).to_numpy(zero_copy_only=False)], dtype=object)
