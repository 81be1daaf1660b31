"""A history of nights from formulas: three cases, four engines, two tracks, prices with noise, and what is planted."""

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from plumbline.harness.history.folder import History, created, stamp_of
from plumbline.harness.store.journal import Journal
from plumbline.harness.store.record import Measurement, Record, Sample, Timing, digest
from plumbline.harness.store.store import write_json
from tests.run_folder import ENGINES, catalogue

__all__ = ["CASES", "Planted", "priced", "write_history"]

Planted = Callable[[int, Record], Record]
"""Number of the night and what it would hold; what it holds."""

CASES = ("flight_projectile", "joint_pendulum", "friction_stop")
NOISE = 0.02
SAMPLES = 3


def write_history(root: Path, nights: int, planted: Planted = lambda _night, record: record, processor: str = "A") -> History:
    """Nights a day apart, the machine up to 1.3 times as slow on some of them; all answers alike but for what is planted."""
    history, rng = created(root), np.random.default_rng(7)
    described = catalogue(False)
    for night in range(nights):
        stamp = stamp_of(datetime(2026, 9, 1, 1, 30, tzinfo=UTC) + timedelta(days=night))
        folder = history.night(stamp).folder
        folder.mkdir(parents=True)
        slow = float(rng.choice([1.0, 1.0, 1.0, 1.3]))
        journal = Journal(folder)
        for record in _records(described["cases"], rng, slow):
            journal.append(planted(night, record))
        journal.close()
        write_json(folder / "catalogue.json", described)
        write_json(folder / "machine.json", {"processor": processor, "started": stamp})
    return history


def _records(cases: dict[str, dict[str, object]], rng: np.random.Generator, slow: float) -> list[Record]:
    return [
        priced(
            Record(
                trial=digest([case, engine, track]), study="few", experiment="look", case=case, parameters={}, engine=engine,
                engine_version="1.0", track=track, dt=1 / 240, settings={"dt": 1 / 240}, status="passed", reason="passed",
                trajectory_hash=digest(["hash", case, engine, track]), base=track,
                measurements=(Measurement(metric=str(cases[case]["headline"]), value=1e-3, unit="m", at_most=0.01),),
            ),
            ENGINES[engine][4] / 240 * slow * float(np.exp(rng.normal(0, NOISE))),
            1e-3 * slow * float(np.exp(rng.normal(0, NOISE / 2))),
        )
        for case in CASES
        for engine in ENGINES
        for track in ("default", "tuned")
    ]  # fmt: skip


def priced(record: Record, cost: float, canary: float) -> Record:
    """The record with a price [s] of a step, and the canary [s] beside it."""
    timing = record.timing or Timing(trial=record.trial, unit="step", unstable_timing=False)
    run = 500 if timing.clocked else 0
    samples = tuple(
        Sample(process=0, block=k, steps=500, cpu=500 * cost, wall=500 * cost, canary=canary, switches=0, run=run)
        for k in range(SAMPLES)
    )
    bounds = {"cpu_per_unit": cost, "cpu_per_unit_low": 0.98 * cost, "cpu_per_unit_high": 1.02 * cost}
    return replace(record, timing=replace(timing, samples=samples, **bounds))
