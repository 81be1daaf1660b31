"""Time steps as they were taken: an engine may cut the step that it is asked for, and whoever reads of a step reads of that."""

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from plumbline.harness.findings.once import once

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store


@lru_cache(maxsize=4096)
def substeps_of(resolved: str) -> int:
    """How many sub-steps an engine took for a step, by what it says that it used (JSON); 1 of one that says nothing of them."""
    settings = json.loads(resolved or "{}")
    return int(settings.get("substeps") or 1) if isinstance(settings, dict) else 1


@once
def substeps_taken(store: "Store") -> Mapping[str, int]:
    """The sub-steps of each trial that took several, by its name."""
    trials = store.trials
    taken = {str(t): substeps_of(str(r)) for t, r in zip(trials["trial"], trials["resolved"], strict=True)}
    return {trial: count for trial, count in taken.items() if count > 1}


def whole_part(dt: float) -> str:
    """A time step [s] as people write it, '1/240 s'; '' where it is no whole part of a second."""
    parts = round(1 / dt)
    return f"1/{parts} s" if parts > 1 and abs(parts * dt - 1) < 1e-6 else ""


def beside(substeps: int | None) -> str:
    """What stands beside a time step: ' (4 sub-steps)', or nothing where it was taken whole."""
    return f" ({substeps} sub-steps)" if substeps is not None and substeps > 1 else ""


def step_in_words(dt: float, substeps: int | None = 1) -> str:
    """A time step [s] as people write it, with what became of it: '1/60 s (4 sub-steps)'."""
    return (whole_part(dt) or f"{dt:.4g} s") + beside(substeps)


def columns_with_substeps(columns: Sequence[str]) -> tuple[str, ...]:
    """The columns of a table with one for sub-steps beside that of time steps."""
    others = [column for column in columns if column != "substeps"]
    return tuple(name for column in others for name in ((column, "substeps") if column == "dt" else (column,)))


def with_substeps(store: "Store", rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Flat rows of trials with the sub-steps that each `dt` was taken in; None where there is no step."""
    taken, flat = substeps_taken(store), []
    for row in rows:
        count = None if row["dt"] is None else taken.get(row["trial"], 1)
        flat.append({name: count if name == "substeps" else row[name] for name in columns_with_substeps(tuple(row))})
    return flat
