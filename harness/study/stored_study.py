"""The experiments of the study that a run folder was made by, read back."""

from harness.store.store import Store, StoreError
from harness.study.study import Experiment, StudyError, experiment_from

__all__ = ["experiments_of"]


def experiments_of(store: Store) -> list[Experiment]:
    """All experiments in order; none where the folder does not hold its study. Raises: StoreError."""
    path = store.folder / "study.toml"
    told = store.study.get("experiments", [])
    if not isinstance(told, list):
        raise StoreError(f"{path}: experiments is {type(told).__name__}, expected a list of tables")
    try:
        return [experiment_from(part, str(path)) for part in told]
    except StudyError as error:
        raise StoreError(str(error)) from error
