"""The study that a run folder was made by, read back: its experiments, and what its variants change."""

from collections.abc import Mapping
from dataclasses import dataclass

from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store
from plumbline.harness.study.experiment import Experiment, StudyError, experiment_from


@dataclass(frozen=True, slots=True)
class Departure:
    """How a variant differs in one thing. Terms: beside: the track or variant that it differs from. changes: the thing."""

    beside: str
    changes: str


def experiments_of(store: Store) -> list[Experiment]:
    """All experiments in order; none where the folder does not hold its study. Raises: StoreError."""
    path = store.folder / "study.toml"
    try:
        return [experiment_from(table, str(path)) for table in store.study.get("experiments", [])]
    except StudyError as error:
        raise StoreError(str(error)) from error


def departures_of(store: Store) -> Mapping[tuple[str, str], Departure]:
    """By engine and name, the variants that change one thing."""
    return {
        (engine, name): Departure(variant["beside"], variant["changes"])
        for engine, named in store.study.get("variants", {}).items()
        for name, variant in named.items()
        if "changes" in variant
    }
