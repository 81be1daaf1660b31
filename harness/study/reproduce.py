"""A trial read back from a run folder, so that it can be run again."""

import json

from plumbline.harness.adapter import Settings
from plumbline.harness.case.alteration import Alteration
from plumbline.harness.store.journal import NoRun
from plumbline.harness.store.store import Store
from plumbline.harness.study.experiment import Experiment, experiments_of
from plumbline.harness.study.trial import Trial


def trial_of(store: Store, name: str) -> Trial:
    """The trial whose name starts with `name`, with the settings that were requested and the limits that were set then.

    Raises:
        NoRun: where no trial, or more than one, has that name. StoreError: where the folder's study is not readable.
    """
    matching = store.trials[store.trials["trial"].str.startswith(name)]
    if len(matching) != 1:
        raise NoRun(f"{store.folder}: trial '{name}' names {len(matching)} trials, expected one; see plumbline show")
    row = matching.iloc[0]
    return Trial(
        trial=row["trial"],
        study=row["study"],
        experiment=_limited(store, row["experiment"], row["case"]),
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


def _limited(store: Store, name: str, case: str) -> Experiment:
    """An experiment that allows as much time and memory as the study of a store did, and clocks nothing.

    A store that does not hold its study, or another one, leaves the limits as they are where nobody sets them.
    """
    asked = [experiment for experiment in experiments_of(store) if experiment.name == name]
    asking = next((experiment for experiment in asked if experiment.asks(case)), Experiment(name=name))
    return Experiment(name=name, timing=False, deadline=asking.deadline, memory=asking.memory)
