"""A run folder as tables: trials, measurements, timing samples, prices and all that is worked out from them."""

import warnings
from os import PathLike
from pathlib import Path

import pandas as pd

from plumbline.api.arguments import checked
from plumbline.api.frames import described
from plumbline.harness.findings import tables
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store

STORED = ("trials", "measurements", "samples")


class Results:
    """What a study found. Each table is a DataFrame with units and meanings of its columns in `attrs["units"]` and
    `attrs["columns"]`.

    Terms: folder: the run folder. store: the same for who reads it as Plumbline does; it may change.
    """

    def __init__(self, store: Store) -> None:
        self.folder, self.store = store.folder, store

    def __repr__(self) -> str:
        """In a line: folder, trials, engines."""
        trials = self.store.trials
        return f"<Results {self.folder}: {len(trials)} trials of {', '.join(sorted(set(trials['engine'])))}>"

    @property
    def trials(self) -> pd.DataFrame:
        """A row a trial: case, engine, settings, outcome, CPU time."""
        return self.table("trials")

    @property
    def measurements(self) -> pd.DataFrame:
        """A row a metric of a trial, with the bound if it has one."""
        return self.table("measurements")

    @property
    def samples(self) -> pd.DataFrame:
        """A row a timing sample."""
        return self.table("samples")

    @property
    def prices(self) -> pd.DataFrame:
        """A row an engine, case and error: the CPU time that the error costs, or why it is not known."""
        return self.table("price")

    @property
    def tables(self) -> tuple[str, ...]:
        """The names that `table` takes."""
        return (*STORED, *tables.names())

    def table(self, name: str) -> pd.DataFrame:
        """A table as `plumbline show --table NAME` has it. Raises: PlumblineError, where there is none of that name."""
        if name in STORED:
            return described(name, getattr(self.store, name))
        if name not in self.tables:
            raise StoreError(
                f"table {quoted(name)}: unknown, expected one of {', '.join(self.tables)}{did_you_mean(name, self.tables)}"
            )
        worked_out = tables.table(name)
        rows = worked_out.rows(self.store)
        return described(name, pd.DataFrame(rows, columns=None if rows else list(worked_out.columns)))

    def show(self, case: str) -> None:
        """Show the recording of a case, all engines beside the truth, in the rerun viewer until it is closed.

        Raises: PlumblineError, where there is no recording of it, or no window can open here.
        """
        from plumbline.reports.recordings import recording_of
        from plumbline.reports.recordings.viewer import open_viewer

        path = recording_of(self.folder, case)
        if open_viewer(path):
            raise StoreError(f"{path}: the viewer could not show it; the file opens in a viewer elsewhere")

    def report(self) -> Path:
        """Write the HTML report anew from what is stored; returns its first page."""
        from plumbline.reports.html.report import write_report

        return write_report(self.folder).index


@checked
def open_results(folder: str | PathLike[str]) -> Results:
    """The run folder that `compare`, or `plumbline run` on the command line, wrote.

    What a reader has to know of a folder that was damaged or stopped is warned of. Raises: PlumblineError, where it is none.
    """
    store = Store(Path(folder))
    for note in store.notes:
        warnings.warn(note, stacklevel=2)
    return Results(store)
