"""Two run folders from formulas, the second with planted changes: of bits, of errors, of verdicts, of prices."""

import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

from tests.run_folder import write_run_folder

__all__ = ["Planted", "write_two_runs"]

Planted = Callable[[pd.DataFrame, pd.DataFrame, pd.DataFrame], None]
"""What is done to trials, measurements and samples of the second folder, in place."""

BLOCKS = 10
NOISE = 0.02


def write_two_runs(
    folder: Path, planted: Planted | None = None, machine: Mapping[str, Any] | None = None, only: tuple[str, ...] = ()
) -> tuple[Path, Path]:
    """Folders a and b: the same answers; prices with noise of 2 % a sample, and b's machine 1.3 times as slow throughout.

    Args: only: these cases, where not all.
    """
    sides = folder / "a", folder / "b"
    for number, side in enumerate(sides):
        write_run_folder(side, only=only)
        trials, measurements, samples = (table.copy() for table in _tables(number, only))
        if number and planted is not None:
            planted(trials, measurements, samples)
        medians = (samples["cpu"] / samples["steps"]).groupby(samples["trial"]).median()
        trials["cpu_per_unit"] = [medians.get(trial, np.nan) for trial in trials["trial"]]
        trials["cpu_per_unit_low"], trials["cpu_per_unit_high"] = (trials["cpu_per_unit"] * bound for bound in (0.98, 1.02))
        for name, table in (("trials", trials), ("measurements", measurements), ("samples", samples)):
            table.to_parquet(side / f"{name}.parquet", index=False)
        if number and machine is not None:
            path = side / "machine.json"
            path.write_text(json.dumps(json.loads(path.read_text()) | machine), encoding="utf-8")
    return sides


@cache
def _tables(number: int, only: tuple[str, ...]) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Trials, measurements and samples of a side before anything is planted; they are only copied."""
    with TemporaryDirectory() as made:
        folder = write_run_folder(Path(made), only=only)
        trials = pd.read_parquet(folder / "trials.parquet").assign(alteration="{}", sources='{"adapter": "0000"}')
        measurements = pd.read_parquet(folder / "measurements.parquet").assign(truth_error=0.0)
    return trials, measurements, _samples(trials, np.random.default_rng(number), 1.3 if number else 1.0)


def _samples(trials: pd.DataFrame, rng: np.random.Generator, slow: float) -> pd.DataFrame:
    rows = [
        {"trial": row.trial, "process": 0, "block": block, "steps": 500, "cpu": 500 * row.cpu_per_unit * slow * noise,
         "wall": 0.1, "canary": 1e-3 * slow, "switches": 0, "units": 1}
        for row in trials.itertuples()
        if row.cpu_per_unit == row.cpu_per_unit
        for block, noise in enumerate(np.exp(rng.normal(0, NOISE, BLOCKS)))
    ]  # fmt: skip
    return pd.DataFrame(rows)
