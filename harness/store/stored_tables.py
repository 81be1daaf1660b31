"""The Parquet tables of a run folder without a journal, which another program may have written: looked at, then read."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from plumbline.harness.intake.documents import InputError, regular
from plumbline.harness.store.journal import StoreError

MOST_ROWS = 20_000_000
MOST_BYTES = 2 * 2**30
"""What a table may take once it is unpacked."""


def read_tables(folder: Path, needed: Mapping[str, Sequence[str]], texts: Sequence[str]) -> dict[str, pd.DataFrame]:
    """The tables by name, each with at least these columns; `texts` are columns of the first table that hold JSON.

    Raises: StoreError.
    """
    tables = {name: _table(folder / f"{name}.parquet", columns) for name, columns in needed.items()}
    first, trials = next(iter(tables.items()))
    for column in (column for column in texts if column in trials):
        for text in dict.fromkeys(trials[column]):
            try:
                whole = isinstance(json.loads(text), dict | list)
            except (TypeError, ValueError, RecursionError):
                whole = False
            if not whole:
                raise StoreError(f"{folder / f'{first}.parquet'}: column {column}: got {str(text)[:80]!r}, expected JSON")
    return tables


def _table(path: Path, columns: Sequence[str]) -> pd.DataFrame:
    """With words as Python's own strings, as the tables of a journal have them."""
    from pyarrow.parquet import ParquetFile  # late: it takes a while

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
        read: pd.DataFrame = file.read().to_pandas()
    except InputError as error:
        raise StoreError(str(error)) from None
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise StoreError(f"{path}: not readable: {' '.join(str(error).split())[:300]}") from error
    return read.astype({name: object for name, kind in read.dtypes.items() if isinstance(kind, pd.StringDtype)})
