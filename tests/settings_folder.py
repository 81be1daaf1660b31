"""A run folder in which engines have settings beside the two tracks, written from formulas like those of `tests.run_folder`."""

import json
from pathlib import Path

import pandas as pd

from tests.run_folder import write_run_folder

__all__ = ["ONE", "SEVERAL", "write_settings_folder"]

STUDY = """
name = "settings"
[variants.mujoco]
cg-loose = { on = "default", solver = "cg", tolerance = 1e-5, source = "the vendor's guide" }
pgs = { solver = "pgs", options = { split_impulse = true } }
[variants.dart]
pgs = { solver = "pgs" }
"""


def write_settings_folder(folder: Path, *settings: tuple[str, str], without: str = "") -> Path:
    """A run folder in which engines have settings beside the tracks: the tuned trials once more, under these names.

    Args: without: an engine that is left out.
    """
    write_run_folder(folder, only=("joint_pendulum", "stack_tower"))
    folder.joinpath("study.toml").write_text(STUDY, encoding="utf-8")
    trials, measurements = (pd.read_parquet(folder / f"{name}.parquet") for name in ("trials", "measurements"))
    trials = trials[trials["engine"] != without]
    for engine, name in settings:
        mine = trials[(trials["engine"] == engine) & (trials["track"] == "tuned")]
        renamed = {trial: f"{name[:3]}{engine[:2]}{trial[5:]}" for trial in mine["trial"]}
        other = json.dumps({"dt": 1 / 240, "solver": name, "source": "the vendor's guide"})
        trials = pd.concat([trials, mine.assign(track=name, trial=mine["trial"].map(renamed), settings=other)])
        theirs = measurements[measurements["trial"].isin(renamed)]
        measurements = pd.concat([measurements, theirs.assign(trial=theirs["trial"].map(renamed))])
    trials.to_parquet(folder / "trials.parquet", index=False)
    measurements.to_parquet(folder / "measurements.parquet", index=False)
    return folder


ONE, SEVERAL = (("mujoco", "cg-loose"),), (("mujoco", "cg-loose"), ("mujoco", "pgs"), ("dart", "pgs"))
