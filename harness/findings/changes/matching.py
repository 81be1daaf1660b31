"""Which trial of one run folder asks the same as which of another: the same question under the same name of settings.

Names of trials cover versions and sources, so that they differ where anything was changed; what is asked does not.
"""

import json
from collections import Counter
from collections.abc import Collection, Hashable, Iterable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from pathlib import PurePath
from typing import Any

from plumbline.harness.case.undropped import OWN
from plumbline.harness.findings.parameter_words import substeps_of, where_of
from plumbline.harness.store.store import Store

_ASKED = (
    "study", "experiment", "parameters", "engine", "track", "dt", "seed", "clocks", "workers", "alteration", "members",
    "remedy", "parts",
)  # fmt: skip
_NAMES = ("study", "experiment")
"""What a question is called by, and not what is asked."""
_SINCE = {"clocks": "work", "workers": 1}
"""What trials of a folder from before there were these columns mean by their absence."""
_APART = ("engine_version", "settings")
"""What tells trials apart that ask the same within one folder: two versions side by side, or settings that share a name."""

LOST = ("crashed", "oom", "timeout", "unavailable", "interrupted")
"""Statuses without an answer that could be compared."""


@dataclass(frozen=True, slots=True)
class TrialPair:
    """Rows of the tables `trials` that ask the same; one of them None where the other folder has no such trial."""

    a: Any
    b: Any

    @property
    def either(self) -> Any:
        """The later row of those that there are."""
        return self.a if self.b is None else self.b

    @property
    def lost(self) -> bool:
        """Is there no answer on one side at least?"""
        return self.a.status in LOST or self.b.status in LOST

    @property
    def same_bits(self) -> bool:
        """Did both answer, with the same trajectory to the last bit?"""
        return isinstance(self.a.trajectory_hash, str) and self.a.trajectory_hash == self.b.trajectory_hash


def matched(store_a: Store, store_b: Store, *, renamed: bool = False) -> tuple[TrialPair, ...]:
    """Every trial of both folders once, in the order of B and then of what A has alone.

    Args: renamed: every trial of B by what it asks, whatever study and experiment ask it, beside the last of A that asks it.
    """
    rows_a, rows_b = (list(store.trials.itertuples()) for store in (store_a, store_b))
    if renamed:
        asked = {_key(row, _NAMES): row for row in rows_a}
        return tuple(TrialPair(asked.get(_key(row, _NAMES)), row) for row in rows_b)
    keys_a, keys_b = ([_key(row) for row in rows] for rows in (rows_a, rows_b))
    ambiguous = {key for keys in (keys_a, keys_b) for key, count in Counter(keys).items() if count > 1}

    def named(keys: Iterable[Hashable], rows: Iterable[Any]) -> dict[Hashable, Any]:
        apart = attrgetter(*_APART)
        return {(key, apart(row) if key in ambiguous else ()): row for key, row in zip(keys, rows, strict=True)}

    of_a, of_b = named(keys_a, rows_a), named(keys_b, rows_b)
    return tuple(TrialPair(of_a.get(key), of_b.get(key)) for key in (*of_b, *(key for key in of_a if key not in of_b)))


def by_question(store: Store) -> dict[Hashable, Any]:
    """The rows of the table `trials` by what they ask; those that share it (two versions side by side) by their order too."""
    asked: Counter[Hashable] = Counter()
    rows: dict[Hashable, Any] = {}
    for row in store.trials.itertuples():
        key = _key(row)
        rows[key, asked[key]] = row
        asked[key] += 1
    return rows


def _key(row: Any, without: Collection[str] = ()) -> Hashable:
    return scene_of(str(row.case)), *(getattr(row, name, _SINCE.get(name)) for name in _ASKED if name not in without)


def scene_of(case: str) -> str:
    """What a case is called wherever its file lies: two check-outs of a scene of one's own are the same question."""
    return OWN + PurePath(case.removeprefix(OWN)).name if case.startswith(OWN) else case


def requested(row: Any) -> dict[str, Any]:
    """The settings that a trial asked for, without where they come from."""
    return {name: value for name, value in json.loads(row.settings).items() if name != "source"}


def located(a: Any, b: Any, catalogue: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a `Change` that say which trials it is read off, and where they stand."""
    return {
        "case": b.case,
        "engine": b.engine,
        "track": b.track,
        "where": where_of(catalogue, b.case, b.parameters),
        "dt": float(b.dt),
        "substeps": substeps_of(str(b.resolved)),
        "trial_a": str(a.trial),
        "trial_b": str(b.trial),
    }
