"""Prices that creep from night to night: told against the night that told of them last, and never of noise alone."""

from collections.abc import Sequence
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from plumbline.harness.history.changes_since import lasting, price_changes_of

ENGINES, CASES, TRACKS = ("a", "b", "c"), ("w", "x", "y", "z"), ("default", "tuned")
SAMPLES = 5
MACHINE, LAYOUT, SAMPLE = 0.016, 0.015, 0.01
"""Of logarithms, rms: what the machine's drift does to one program as a whole (docs/method.md), what another layout in memory
does to one price, and how samples stray."""


def night(rng: np.random.Generator, times: float = 1.0) -> Any:
    """The tables of a night: eight prices of each engine, those of the first so many times as dear."""
    trials, samples = [], []
    slow = {engine: rng.normal(0, MACHINE) for engine in (*ENGINES, "canary")}
    for engine in ENGINES:
        for case in CASES:
            for track in TRACKS:
                trial = f"{engine} {case} {track}"
                price = 1e-5 * (times if engine == "a" else 1.0) * np.exp(slow[engine] + rng.normal(0, LAYOUT))
                costs = price * np.exp(rng.normal(0, SAMPLE, SAMPLES))
                trials.append({
                    "trial": trial, "study": "s", "experiment": "e", "case": case, "parameters": "{}", "engine": engine,
                    "track": track, "dt": 0.01, "seed": 0, "alteration": "{}", "members": 1, "remedy": "", "parts": 1,
                    "engine_version": "1", "sources": "", "settings": "{}", "trajectory_hash": trial, "status": "passed",
                    "cpu_per_unit": float(np.median(costs)), "unstable_timing": False, "unit": "step", "resolved": "{}",
                })  # fmt: skip
                canary = 1e-3 * np.exp(slow["canary"] + rng.normal(0, SAMPLE, SAMPLES))
                samples += [
                    {"trial": trial, "cpu": 100 * cost, "steps": 100, "units": 1, "run": 100, "canary": beside}
                    for cost, beside in zip(costs, canary, strict=True)
                ]
    return SimpleNamespace(trials=pd.DataFrame(trials), samples=pd.DataFrame(samples), catalogue={})


def crept(nights: Sequence[Any]) -> list[Any]:
    """What the last of four nights is told to have crept by."""
    cells = {("e", case, engine, track, "s") for engine in ENGINES for case in CASES for track in TRACKS}
    return lasting(partial(price_changes_of, nights, cells))


@pytest.mark.slow
def test_of_a_thousand_unchanged_histories_fewer_than_one_in_a_hundred_tells_that_a_price_crept() -> None:
    """Of three engines each; a night looks once, so that this is its chance of a false word by this way."""
    rng = np.random.default_rng(3)
    false = sum(bool(crept([night(rng) for _ in range(4)])) for _ in range(1000))
    print(f"{false} of 1000")
    assert false < 10


def test_a_rise_of_three_percent_a_night_is_told_by_the_sixth() -> None:
    rng = np.random.default_rng(4)
    seen = [crept([night(rng, 1.03**k) for k in (0, 1, 5, 6)]) for _ in range(20)]
    assert sum(any((row.engine, row.sense) == ("a", "worse") for row in rows) for rows in seen) >= 19


def test_one_noisy_night_is_not_told_against_those_before_it() -> None:
    """Nor one that all later ones are compared with."""
    rng = np.random.default_rng(5)
    assert not crept([night(rng), night(rng), night(rng), night(rng, 1.2)])
    assert not crept([night(rng, 1.2), night(rng), night(rng), night(rng)])
