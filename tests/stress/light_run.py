"""A study small enough to be run a thousand times: two trials of a falling body, in this process, clocked by formula."""

import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

import pandas as pd
import pytest

from plumbline.harness.findings.summary import write_summary
from plumbline.harness.run import campaign
from plumbline.harness.store.record import Sample, Timing
from plumbline.harness.store.store import Store
from plumbline.harness.store.stored_tables import TABLES
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from tests.conftest import PLUGINS
from tests.in_process import in_this_process, steps_of_run

__all__ = ["STUDY", "carry_out", "light", "same_tables", "tables"]

STUDY = Study(
    name="light",
    recordings=False,
    experiments=(Experiment(name="light", cases=("stress_fall",), engines=("sound",), dt=(0.05,)),),
)


def _by_formula(trials: Sequence[Trial], _folder: Path, **_how: object) -> Iterator[Timing]:
    for trial in trials:
        run = steps_of_run(trial)
        seconds = run * trial.settings.dt
        sample = Sample(process=0, block=0, steps=run, cpu=seconds, wall=seconds, canary=1.0, switches=0, run=run)
        yield Timing(trial=trial.trial, unit="step", cpu_per_unit=trial.settings.dt, clocked="whole runs", samples=(sample,))


def light(patch: pytest.MonkeyPatch) -> None:
    """Run trials in this process from here on, and let nothing be clocked."""
    patch.syspath_prepend(str(PLUGINS))
    in_this_process(patch)
    patch.setattr(campaign, "clock_group", _by_formula)


def carry_out(folder: Path, study: Study = STUDY, resume: bool | Literal["merge"] = True) -> Store:
    """The study, with the summaries that the command line writes behind it."""
    cases, engines = {"stress_fall": plugins.case("stress_fall")}, {"sound": plugins.adapter("sound")}
    store = campaign.carry_out(study, folder, cases, engines, workers=1, resume=resume)
    write_summary(store)
    return store


def tables(folder: Path) -> dict[str, bytes]:
    """The tables as they lie on the disk."""
    return {name: (folder / f"{name}.parquet").read_bytes() for name in TABLES}


def same_tables(folder: Path, expected: dict[str, bytes]) -> None:
    """Raises: AssertionError, where a table in the folder differs; equal bytes are equal tables.

    Whether an answer was simulated or judged from the file that it had left is no part of it."""
    for name, content in tables(folder).items():
        if content != expected[name]:
            frames = (pd.read_parquet(io.BytesIO(table)) for table in (content, expected[name]))
            pd.testing.assert_frame_equal(*(frame.drop(columns="simulated_as", errors="ignore") for frame in frames))
