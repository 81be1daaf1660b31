"""Carrying out a study into a run folder: accuracy runs first, then timing runs, every result on disk as it comes."""

import json
import random
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import tomli_w

from harness import effects, limits, sweep
from harness.adapter import Adapter
from harness.alteration import ALONE, REFINED
from harness.case import Case
from harness.catalogue import describe_case, describe_engine
from harness.clock import clock_group
from harness.discover import version_of
from harness.journal import FolderTaken, Journal, read_journal
from harness.machine import fingerprint
from harness.pool import run_isolated
from harness.progress import Progress
from harness.record import Record
from harness.run import outcome
from harness.store import Store, write_atomically, write_tables
from harness.study import Study, StudyError, Trial
from harness.sweep import due_for_clock

__all__ = ["Shard", "carry_out", "share"]

Shard = tuple[int, int]
"""(i, n): the i-th of n parts, from 1."""

_TIMED = ("passed", "failed")


def _write_json(path: Path, content: object) -> None:
    write_atomically(path, json.dumps(content, indent=1, allow_nan=False, default=str).encode())


def _study_toml(study: Study) -> bytes:
    def told(value: Any) -> Any:
        """Without what is left open: TOML has no word for nothing."""
        if isinstance(value, dict):
            return {name: told(part) for name, part in value.items() if part is not None}
        return [told(part) for part in value] if isinstance(value, list | tuple) else value

    return tomli_w.dumps(told(asdict(study))).encode()


def _accuracy(
    what: str,
    trials: Sequence[Trial],
    reasons: Mapping[str, str | None],
    journal: Journal,
    folder: Path,
    workers: int,
) -> None:
    waiting = [trial for trial in trials if trial.trial not in journal.records]
    for trial in waiting:
        reason = reasons[trial.engine]
        if reason is not None:
            journal.append(outcome(trial, "unavailable", reason))
    waiting = [trial for trial in waiting if reasons[trial.engine] is None]
    if not waiting:
        return
    alone = [trial for trial in waiting if trial.alteration.name == ALONE]
    beside = [trial for trial in waiting if trial.alteration.name != ALONE]
    with Progress(what, len(waiting)) as progress:
        for part, side in ((beside, workers), (alone, 1)):
            for record in run_isolated(part, folder, side):
                if record.status != "interrupted":
                    journal.append(record)
                progress.advance(f"{record.case} {record.engine}/{record.track} {record.status}")


def _timing(
    trials: Sequence[Trial], records: Mapping[str, Record], journal: Journal, folder: Path, cases: Mapping[str, Case]
) -> None:
    near = due_for_clock(trials, records, cases)
    due = [
        trial
        for trial in trials
        if trial.experiment.timing
        and trial.alteration.name not in REFINED
        and (not trial.experiment.sweep or trial.trial in near)
        and trial.trial not in journal.timings
        and trial.trial in records
        and records[trial.trial].status in _TIMED
    ]
    order: dict[tuple[object, ...], int] = {}
    due.sort(key=lambda trial: order.setdefault(_together(trial), len(order)))
    shuffle, troubles = random.Random(0), list[str]()
    with Progress("timing", len(due)) as progress:
        for _, group in groupby(due, key=_together):
            for timing in clock_group(tuple(group), folder, shuffle):
                journal.append(timing)
                troubles += [timing.note] if timing.note else []
                progress.advance(f"{records[timing.trial].case} {records[timing.trial].engine}")
    if troubles:
        print(f"timing: trouble in {len(troubles)} of {len(due)} trials, first: {troubles[0]}", file=sys.stderr)


def _together(trial: Trial) -> tuple[object, ...]:
    """What trials have in common that are clocked side by side: the question, whatever the settings."""
    return trial.experiment.name, trial.case, repr(trial.parameters)


def share(trials: Sequence[Trial], shard: Shard) -> list[Trial]:
    """One of n parts: every n-th trial, but in a sweep every n-th case, since its engines are clocked side by side."""
    part, parts = shard
    cases = list(dict.fromkeys(trial.case for trial in trials))
    plain = [trial for trial in trials if not trial.experiment.sweep][part - 1 :: parts]
    return plain + [trial for trial in trials if trial.experiment.sweep and cases.index(trial.case) % parts == part - 1]


def _searched(
    trials: list[Trial],
    reasons: Mapping[str, str | None],
    journal: Journal,
    folder: Path,
    workers: int,
    cases: Mapping[str, Case],
    adapters: Mapping[str, Adapter],
) -> list[Trial]:
    """The trials with those that sweeps and limits went on to, round by round, all with a record."""
    found, number = list(trials), 0
    searches = [
        go_on
        for go_on, wanted in (
            (sweep.next_trials, any(trial.experiment.sweep for trial in trials)),
            (limits.next_trials, any(trial.experiment.limit for trial in trials)),
            (partial(effects.next_trials, store=Store(folder)), any(trial.experiment.effects for trial in trials)),
        )
        if wanted
    ]
    while searches:
        records = read_journal(journal.path)
        more = [trial for go_on in searches for trial in go_on(found, records, cases, adapters)]
        if not more:
            break
        number += 1
        _accuracy(f"search, round {number}", more, reasons, journal, folder, workers)
        found += more
    return found


def carry_out(
    study: Study,
    folder: Path,
    cases: Mapping[str, Case],
    adapters: Mapping[str, Adapter],
    *,
    workers: int,
    resume: bool,
    shard: Shard = (1, 1),
) -> Store:
    """Run every trial of a study that the folder does not hold yet.

    The journal grows with each finished run, so a kill loses at most the runs under way. Interrupting leaves the same tables
    as finishing, of what was done.

    Raises:
        FolderTaken: where the folder holds another run. StoreError: where it is locked or cannot be read.
        StudyError: where the study leaves no trial.
    """
    if (folder / "journal.jsonl").exists() and not resume:
        raise FolderTaken(f"{folder}: holds a run already; add --resume to go on with it, or choose another --out")
    versions = {name: version_of(adapter)[0] for name, adapter in adapters.items()}
    trials = share(list(study.trials(cases, adapters, versions)), shard)
    if not trials:
        raise StudyError(f"study '{study.name}': no trial; its cases and engines, or --case, --engine and --shard, leave none")
    folder.mkdir(parents=True, exist_ok=True)
    engines = {name: describe_engine(adapter) for name, adapter in adapters.items()}
    journal = Journal(folder)
    machine = fingerprint()
    try:
        write_atomically(folder / "study.toml", _study_toml(study))
        chosen = {trial.case for trial in trials}
        rows = {name: describe_case(case) for name, case in cases.items() if case.name in chosen}
        _write_json(folder / "catalogue.json", {"cases": rows, "engines": engines})
        _write_json(folder / "machine.json", machine)
        reasons = {name: row["unavailable"] for name, row in engines.items()}
        _accuracy("accuracy", trials, reasons, journal, folder, workers)
        trials = _searched(trials, reasons, journal, folder, workers, cases, adapters)
        _timing(trials, read_journal(journal.path), journal, folder, cases)
    finally:
        journal.close()
        write_tables(folder)
        machine["finished"] = datetime.now(UTC).isoformat(timespec="seconds")
        _write_json(folder / "machine.json", machine)
    return Store(folder)
