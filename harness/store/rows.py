"""The rows of a table as mappings: what reports take out of tables by the ten thousand."""

from typing import Any

import pandas as pd

__all__ = ["records"]


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Each row by the names of its columns, numbers as Python's own; `DataFrame.to_dict` asks each word what it is."""
    names = [str(name) for name in frame.columns]
    columns = (frame[name].tolist() for name in frame.columns)
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]
