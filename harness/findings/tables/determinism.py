"""Does the same scene give the same bits, and if not, from which step on and how fast does it part?

Each cell was run once and then again: in another process beside others ('again'), with the machine for itself ('alone'), from a
state saved in its middle ('restored'), with its bodies in the other order ('reordered'), on more threads where the engine has
that knob, and with the last bit of one coordinate changed ('nudged'), which is no test but a measure: a motion that multiplies
that bit shows anything that an engine forgets. Some were run in processes whose numeric libraries were told to use the code of
another processor (`harness.study.library_variants`), which rounds otherwise.
"""

import json
import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plumbline.harness.findings.columns import Column, Table, names, outcome, plain, side
from plumbline.harness.findings.once import all_once
from plumbline.harness.findings.spoken import SPOKEN
from plumbline.harness.store.journal import NotKept
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats

STATES = ("p_WB", "q_WB", "v_WB", "w_WB")
FIRST = "first"
"""The run that the others are compared with."""
MAY_DIFFER = (FIRST, "reordered", "nudged")
"""Runs that need not give the same bits, as need none with other code of the libraries; all others must."""
GROWS_FROM, GROWS_TO = 1e-14, 1e-3
"""Distances [m] between which the growth of a difference is fitted: above rounding, below the size of the scene."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Repetition:
    """One repetition against the first run.

    Terms:
        way: how it was repeated. variables: that its process was born with, 'NAME=VALUE'; '' for none. hash_first, hash: of the
        whole answers; those of 'restored' and 'reordered' differ by what they hold, and are compared state by state. steps:
        that both have. first_step: the first that differs, None for none. farthest [m]: the greatest distance of any body.
        doubles_in [s]: the time in which the difference doubles, None where it does not grow by ten times. verdict:
        'bit-identical', 'differs', 'parts' (of a nudge), 'not kept' (two hashes say nothing by themselves), or the status of a
        run without an answer. trial, trial_first: the two runs.
    """

    case: str
    engine: str
    track: str
    way: str
    variables: str = ""
    must: bool
    hash_first: str
    hash: str
    steps: int = 0
    first_step: int | None = None
    farthest: float | None = None
    doubles_in: float | None = None
    verdict: str
    reason: str
    trial: str
    trial_first: str


@all_once
def repetitions(store: Store) -> Iterator[Repetition]:
    """All repetitions of a run."""
    alterations = [json.loads(text) for text in store.trials["alteration"]]
    trials = store.trials.assign(
        way=[alteration.get("name", "") for alteration in alterations],
        every=[alteration.get("every_step", False) for alteration in alterations],
        variables=[" ".join(map("=".join, alteration.get("variables", {}).items())) for alteration in alterations],
    )
    # Each run is compared with the first of its cell, which is read once for all of them.
    states = lru_cache(maxsize=2)(lambda trajectory: store.trajectory(trajectory, ("time", *STATES)))
    for _, group in trials[trials["every"].astype(bool)].groupby(["case", "parameters", "engine", "track"], sort=False):
        runs = {row.way: row for row in group.itertuples()}
        first = runs.pop("", None)
        if first is None:
            continue
        if first.status not in ("passed", "failed"):
            yield _silent(first, first, FIRST)
            continue
        for way, run in runs.items():
            answered = run.status in ("passed", "failed", "diverged") and isinstance(run.trajectory_hash, str)
            yield _compared(states, first, run, way) if answered else _silent(first, run, way)


def _silent(first: Any, run: Any, way: str) -> Repetition:
    return _row(first, run, way, str(run.status), str(run.reason))


def _row(first: Any, run: Any, way: str, verdict: str, reason: str = "", **parting: Any) -> Repetition:
    """Args: parting: fields that say how both part."""
    return Repetition(
        case=first.case,
        engine=first.engine,
        track=first.track,
        way=way,
        variables=run.variables,
        must=way not in MAY_DIFFER and not run.variables,
        hash_first=str(first.trajectory_hash),
        hash=str(run.trajectory_hash),
        verdict=verdict,
        reason=reason,
        trial=str(run.trial),
        trial_first=str(first.trial),
        **parting,
    )


def _compared(states: Callable[[str], Mapping[str, Any]], first: Any, run: Any, way: str) -> Repetition:
    try:
        steps, differs, distance = parting(*(states(side.trajectory_hash) for side in (first, run)))
    except NotKept as error:
        if first.trajectory_hash == run.trajectory_hash:
            return _row(first, run, way, "bit-identical")
        by_hash = way in ("restored", "reordered")  # these hold other things, and say nothing by it
        return _row(first, run, way, "not kept" if by_hash else "parts" if way == "nudged" else "differs", str(error))
    dt = float(first.dt)
    parted = np.flatnonzero(differs)
    first_step = None if len(parted) == 0 else round(float(steps[parted[0]]) / dt)
    same = first_step is None and len(steps) > 0
    verdict = "bit-identical" if same else ("parts" if way == "nudged" else "differs")
    return _row(
        first,
        run,
        way,
        verdict,
        steps=len(steps),
        first_step=first_step,
        farthest=float(distance.max(initial=0.0)),
        doubles_in=doubling(steps, distance),
    )


def parting(first: Mapping[str, Any], second: Mapping[str, Any]) -> tuple[Floats, Any, Floats]:
    """Times [s] that two runs share (t,), whether any bit of the states differs there (t,), the greatest distance [m] (t,)."""
    times, here, there = np.intersect1d(np.round(first["time"], 9), np.round(second["time"], 9), return_indices=True)
    differs = np.zeros(len(times), dtype=np.bool_)
    for name in STATES:
        a, b = (np.ascontiguousarray(run[name][rows]).reshape(len(times), -1) for run, rows in ((first, here), (second, there)))
        differs |= (a.view(np.int64) != b.view(np.int64)).any(axis=1)
    distance: Floats = np.linalg.norm(first["p_WB"][here] - second["p_WB"][there], axis=2).max(axis=1, initial=0.0)
    return times, differs, distance


def doubling(time: Floats, distance: Floats) -> float | None:
    """The time [s] in which a difference doubles while it is small, by least squares of its logarithm; None where it does not
    grow by ten times.

    Args: time (t,) s, distance (t,) m.
    """
    small = np.flatnonzero((distance > GROWS_FROM) & (distance < GROWS_TO))
    if len(small) < 3 or distance[small].max() < 10 * distance[small].min():
        return None
    since, logs = time[small] - time[small].mean(), np.log2(distance[small])
    slope = float(since @ logs / (since @ since))
    return 1 / slope if slope > 0 and math.isfinite(slope) else None


def broken(judged: Iterable[Repetition], engines: Collection[str]) -> list[str]:
    """The repetitions on these engines that must give the same bits and do not, each in a sentence."""
    return [
        f"{repetition.case} on {repetition.engine}/{repetition.track}, {repetition.way}: "
        f"differs from step {repetition.first_step} on (trial {repetition.trial})"
        for repetition in judged
        if repetition.engine in engines and repetition.must and repetition.verdict == "differs"
    ]


_WAYS = SPOKEN["ways"]
"""What a repetition is called in a sentence; of another number of threads by that."""


def sentences(rows: Sequence[Repetition], titles: Mapping[str, str] | None = None) -> list[str]:
    """Engine by engine, how many repetitions gave the same bits, way by way. Args: titles: what engines are called, by name."""
    lines = []
    for engine in dict.fromkeys(row.engine for row in rows):
        title = (titles or {}).get(engine, engine)
        mine = [row for row in rows if row.engine == engine and row.way != "nudged"]
        plain, varied = ([row for row in mine if bool(row.variables) == of_libraries] for of_libraries in (False, True))
        tried = {row.way: None for row in plain}
        ways = (*(way for way in _WAYS if way in tried), *sorted(tried.keys() - _WAYS.keys()))
        if ways:
            words = ", ".join(_how_often(plain, way, _WAYS.get(way, f"on {way}")) for way in ways)
            lines.append(f"{title} gives the same bits {words}.")
        if varied:
            words = ", ".join(_how_often(varied, way, way) for way in sorted({row.way for row in varied}))
            lines.append(f"{title} and its adapter keep their bits with {words}.")
    return lines


def _how_often(rows: Sequence[Repetition], way: str, called: str) -> str:
    """'run again in 25 of 26'; of a way that has no answer, what became of it."""
    verdicts = [row.verdict for row in rows if row.way == way]
    same, differing = (verdicts.count(verdict) for verdict in ("bit-identical", "differs"))
    if same + differing:
        return f"{called} in {same} of {same + differing}"
    return f"{called}: {'not tried' if {*verdicts} == {'unavailable'} else 'no answer'}"


TABLE = Table(
    holds=names(Repetition),
    objects=repetitions,
    shown=(
        Column("case", "case"),
        Column("engine", side),
        Column("way", "way"),
        Column("verdict", lambda row: outcome(row, 50)),
        Column("first step that differs", lambda row: "" if row.first_step is None else f"{row.first_step} of {row.steps}"),
        *plain("farthest=farthest:.2g m", "doubles in=doubles_in:.3g s"),
    ),
    sentences=sentences,
)
