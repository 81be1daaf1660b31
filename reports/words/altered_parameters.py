"""Overridden parameters and alterations: what tells a trial from the others of its case in a table."""

import json
from collections.abc import Mapping
from typing import Any

import pandas as pd

from plumbline.harness.case.alteration import EVERYTHING


def departures(rows: pd.DataFrame) -> Mapping[str, str]:
    """Of each trial whose scene departs from its case's: in what, in words; and of one that does not, where it stands beside
    such as do, in an experiment of its own, whose."""
    names = [_name(str(text)) for text in rows["alteration"]]
    switched = {experiment for experiment, name in zip(rows["experiment"], names, strict=True) if name == EVERYTHING}
    words = {}
    for trial, experiment, name in zip(rows["trial"], rows["experiment"], names, strict=True):
        if name:
            words[str(trial)] = name
        elif experiment in switched and len(set(rows["experiment"])) > 1:
            words[str(trial)] = f"as it is ({experiment})"
    return words


def _name(text: str) -> str:
    try:
        alteration: Any = json.loads(text)
    except ValueError:
        return "departs"
    return str(alteration.get("name") or "").replace("_", " ") if isinstance(alteration, dict) else ""
