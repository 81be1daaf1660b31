"""The experiments of the study that a run folder was made by, read back."""

from harness.store.store import Store, StoreError
from harness.study.experiment import Experiment, StudyError, experiment_from

__all__ = ["experiments_of"]


def experiments_of(store: Store) -> list[Experiment]:
    """All experiments in order; none where the folder does not hold its study. Raises: StoreError."""
    path = store.folder / "study.toml"
    tables = store.study.get("experiments", [])
    if not isinstance(tables, list):
        raise StoreError(f"{path}: experiments is {type(tables).__name__}, expected a list of tables")
    try:
        return [experiment_from(table, str(path)) for table in tables]
    except StudyError as error:
        raise StoreError(str(error)) from error
