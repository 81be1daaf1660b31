"""A recording of a moment: the stretch about it alone, so that a viewer opens there, plays it slowly and in a loop."""

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from plumbline.harness.store.store import Store
from plumbline.reports.recordings.layout import file_name
from plumbline.reports.recordings.rotation import Floats
from plumbline.reports.recordings.runs import Stage, stage_of
from plumbline.reports.recordings.sampling import at_instants
from plumbline.reports.recordings.write import write_stage

SHARE = 0.06
"""How far the stretch reaches to each side of the moment, of the whole time."""


@lru_cache(maxsize=8)
def moment_recording(store: Store, recording: str, at: float) -> bytes | None:
    """The bytes of a recording of the stretch about a moment [s], of the case of a recording's name; None: there is none."""
    name = next((str(case) for case in store.trials["case"].unique() if file_name(str(case)) == recording), None)
    stage = None if name is None else about(stage_of(store, name), at)
    if stage is None or not stage.runs:
        return None
    with tempfile.TemporaryDirectory() as folder:
        return write_stage(store, stage, Path(folder), f"-{at:g}").read_bytes()


def about(stage: Stage, at: float) -> Stage:
    """The stage within the stretch about a moment [s]; a run that has nothing there is left out."""
    end = max((float(run.time[-1]) for run in stage.runs), default=0.0)
    low, high = at - SHARE * end, at + SHARE * end
    runs = tuple(replace(run, arrays=_between(run.arrays, low, high)) for run in stage.runs)
    truth = _between(stage.truth, low, high) if stage.truth else stage.truth
    return replace(stage, runs=tuple(run for run in runs if len(run.time)), truth=truth if len(truth.get("time", ())) else {})


def _between(arrays: Mapping[str, Floats], low: float, high: float) -> dict[str, Floats]:
    """States, contacts and signals of the instants from `low` to `high` [s]; all else as it is."""
    time = arrays["time"]
    chosen = at_instants(arrays, np.flatnonzero((time >= low) & (time <= high)))
    for name in [name for name in arrays if name.startswith("stream:")]:
        stamps = arrays[name.rsplit("/", 1)[0] + "/time"]
        if len(arrays[name]) == len(stamps):
            chosen[name] = arrays[name][(stamps >= low) & (stamps <= high)]
    return chosen
