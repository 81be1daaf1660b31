"""Tables as DataFrames that say what their columns hold: `frame.attrs["units"]` and `frame.attrs["columns"]`, by column."""

import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import pandas as pd


@cache
def _columns() -> Mapping[str, Mapping[str, tuple[str, str]]]:
    with Path(__file__).with_name("columns.toml").open("rb") as file:
        return tomllib.load(file)


def described(table: str, frame: pd.DataFrame) -> pd.DataFrame:
    """A copy with the unit and the meaning of each column in `attrs`; of a table without such texts, two empty mappings."""
    frame, about = frame.copy(), _columns().get(table, {})
    for index, key in enumerate(("units", "columns")):
        frame.attrs[key] = {str(name): about[name][index] for name in frame.columns if name in about}
    return frame
