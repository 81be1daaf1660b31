"""A trial read back from a run folder, so that it can be run again."""

import json

from harness.adapter import Settings
from harness.alteration import Alteration
from harness.store import Store, StoreError
from harness.study import Experiment, Trial

__all__ = ["trial_of"]


def trial_of(store: Store, name: str) -> Trial:
    """The trial whose name starts with `name`, with the settings that were requested then.

    Raises:
        StoreError: where no trial, or more than one, has that name.
    """
    found = store.trials[store.trials["trial"].str.startswith(name)]
    if len(found) != 1:
        raise StoreError(f"{store.folder}: trial '{name}' names {len(found)} trials, expected one; see plumbline show")
    row = found.iloc[0]
    return Trial(
        trial=row["trial"],
        study=row["study"],
        experiment=Experiment(name=row["experiment"], timing=False),
        case=row["case"],
        parameters=json.loads(row["parameters"]),
        engine=row["engine"],
        engine_version=row["engine_version"],
        track=row["track"],
        settings=Settings(**json.loads(row["settings"])),
        seed=int(row["seed"]),
        alteration=Alteration.from_plain(json.loads(row["alteration"])),
        members=int(row["members"]),
    )
