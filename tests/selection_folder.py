"""A run folder of engines of which it is known who is better: errors and costs by formula, each case with noise of its own.

The numbers are made, not measured; they say nothing of a real engine, whatever their names.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tests.run_folder import CASES, LADDER, catalogue, row

__all__ = ["Made", "write_selection_folder"]

DT = 1 / 240
STEPS = LADDER[0], DT, LADDER[-1]
"""Errors and costs are powers of the step: three tell them as well as more."""


@dataclass(frozen=True)
class Made:
    """error: at 1/240 s over the bound there; cost: CPU seconds per simulated second there; lacks: cases that it cannot run."""

    error: float
    cost: float
    lacks: tuple[str, ...] = ()


def write_selection_folder(
    folder: Path,
    engines: Mapping[str, Made],
    seed: int,
    noise: float = 0.3,
    most: int | None = None,
    steps: Sequence[float] = STEPS,
) -> Path:
    """Args: noise: of the logarithm of each error and each cost, from case to case. most: so many cases, all for None. steps:
    that were run."""
    folder.mkdir(parents=True, exist_ok=True)
    draw = np.random.default_rng(seed)
    trials, measurements = list[dict[str, Any]](), list[dict[str, Any]]()
    for case, (_, metric, unit, scale) in [*CASES.items()][:most]:
        for engine, made in engines.items():
            off, dear = (math.exp(noise * draw.normal()) for _ in range(2))
            for dt in steps:
                error, bound = 1e-2 * scale * made.error * off * dt * 240, 1e-2 * scale * dt * 240
                cost = made.cost * dear * DT / dt
                timed = {"cpu_per_sim_s": cost, "cpu_low": 0.97 * cost, "cpu_high": 1.03 * cost, "rough_cost": cost}
                trial = row(case, engine, "tuned", dt, **timed)
                if case in made.lacks:
                    trials.append(
                        trial
                        | {
                            "status": "unsupported",
                            "reason": "planted: no such thing",
                            "steps": 0,
                            **dict.fromkeys(timed, math.nan),
                        }
                    )
                    continue
                if error > bound:
                    trial |= {"status": "failed", "reason": f"{metric} is beyond its bound"}
                trials.append(trial)
                fields = {"trial": trial["trial"], "unit": unit, "because": "made", "passed": error <= bound}
                measurements.append(fields | {"metric": metric, "value": error, "at_most": bound})
    pd.DataFrame(trials).astype({"unstable_timing": "boolean"}).to_parquet(folder / "trials.parquet", index=False)
    pd.DataFrame(measurements).astype({"passed": "boolean"}).to_parquet(folder / "measurements.parquet", index=False)
    none = pd.DataFrame(columns=["trial", "process", "block", "steps", "cpu", "wall", "canary", "switches", "units"])
    none.to_parquet(folder / "samples.parquet", index=False)
    (folder / "catalogue.json").write_text(json.dumps(catalogue(hostile=False)), encoding="utf-8")
    (folder / "machine.json").write_text("{}", encoding="utf-8")
    (folder / "study.toml").write_text('name = "made"\ntitle = "Made"\npurpose = "A known answer"\n', encoding="utf-8")
    return folder
