"""In what scenes depart from their case's own: what tells an altered trial from the others in a table."""

import json
from collections.abc import Mapping
from typing import Any

import pandas as pd

__all__ = ["departures"]


def departures(rows: pd.DataFrame) -> Mapping[str, str]:
    """Of each trial whose scene departs from its case's: in what, in words."""
    found = {}
    for trial, text in zip(rows["trial"], rows["alteration"], strict=True):
        if name := _name(str(text)):
            found[str(trial)] = name
    return found


def _name(text: str) -> str:
    try:
        said: Any = json.loads(text)
    except ValueError:
        return "departs"
    return str(said.get("name") or "") if isinstance(said, dict) else ""
