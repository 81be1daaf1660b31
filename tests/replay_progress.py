"""How well a run would have said how long it still takes: a finished run folder played back against today's estimate.

    python -m tests.replay_progress DIR [WORKERS]

The campaign is carried out anew in a folder of its own, with its searches, but for the work: each answer and each timing is
what the journal holds, and the clock stands where its line was written. Printed is the share of looks within half as much
again, of those behind the first fifth of the run.
"""

import json
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import pytest

from harness.run import campaign
from harness.store.record import Record, Timing
from harness.store.store import Store
from harness.study import plugins
from harness.study.study import load_study
from harness.study.trial import Trial

__all__ = ["Look", "factors", "replay"]

FIRST, LAST = 0.2, 0.98
"""Shares of a run between which an estimate is held to its word; of the last seconds the next line tells more."""


@dataclass(frozen=True, slots=True)
class Look:
    """What was said at an instant. Terms, all [s] since the run began: now; left: as foreseen; whole: when it was over."""

    now: float
    left: float
    whole: float

    @property
    def factor(self) -> float:
        """Foreseen over what it took."""
        return self.left / (self.whole - self.now)


def _of_record(record: Record) -> str:
    about = [record.experiment, record.case, record.engine, record.track, record.settings, record.parameters, record.alteration]
    return json.dumps([*about, record.seed, record.members, record.remedy, record.parts], sort_keys=True, default=list)


def _of_trial(trial: Trial) -> str:
    about = [trial.experiment.name, trial.case, trial.engine, trial.track, trial.settings.plain(), dict(trial.parameters)]
    rest = [trial.alteration.plain(), trial.seed, trial.members, trial.remedy, trial.parts]
    return json.dumps([*about, *rest], sort_keys=True, default=list)


class _Tape:
    """The lines of a journal, by what they are about, and the clock that stands at one of them."""

    def __init__(self, folder: Path) -> None:
        self.answers: dict[str, tuple[float, Record]] = {}
        self.timings: dict[str, tuple[float, Timing]] = {}
        self.begin = self.now = 0.0
        of: dict[str, str] = {}
        for line in (folder / "journal.jsonl").read_text(encoding="utf-8").splitlines():
            entry: dict[str, Any] = json.loads(line.partition(" ")[2])
            at, content = float(entry["at"]), entry["content"]
            self.begin = self.begin or at
            if entry["kind"] == "accuracy":
                record = Record.from_plain(content, entry["schema"])
                of[record.trial] = _of_record(record)
                self.answers[of[record.trial]] = at, record
            elif entry["kind"] == "timing":
                timing = Timing.from_plain(content)
                self.timings[of[timing.trial]] = at, timing
        self.now = self.begin
        self.end = max(at for at, _ in (*self.answers.values(), *self.timings.values()))

    def isolated(self, trials: Sequence[Trial], _folder: Path, _workers: int) -> Iterator[Record]:
        """The answers to these, in the order in which they came; those that the journal lacks are left out."""
        known = [(*self.answers[key], trial) for trial in trials if (key := _of_trial(trial)) in self.answers]
        for at, record, trial in sorted(known, key=lambda each: each[0]):
            self.now = at
            yield replace(record, trial=trial.trial, sources=trial.sources, samples=())

    def clocked(self, trials: Sequence[Trial], _folder: Path, _shuffle: object) -> Iterator[Timing]:
        """The timings of a group, likewise."""
        known = [(*self.timings[key], trial) for trial in trials if (key := _of_trial(trial)) in self.timings]
        for at, timing, trial in sorted(known, key=lambda each: each[0]):
            self.now = at
            yield replace(timing, trial=trial.trial)


def replay(folder: Path, workers: int = 2) -> list[Look]:
    """What a run with so many workers would have said after each piece of work. Raises: KeyError, where lines bear no time."""
    tape, looks = _Tape(folder), list[Look]()

    class Watched(campaign.Progress):
        """Looks at each piece, and prints nothing."""

        def __enter__(self) -> Self:
            return self

        def advance(self, last: str) -> None:
            left = self._left()
            if left is not None:
                looks.append(Look(tape.now - tape.begin, left, tape.end - tape.begin))

    store = Store(folder)
    study = load_study(str(folder / "study.toml"))
    engines = {name: plugins.adapter(name) for name in store.catalogue["engines"]}
    cases = {name: plugins.case(name) for name in store.catalogue["cases"]}
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as out:
        patch.setattr(campaign, "run_isolated", tape.isolated)
        patch.setattr(campaign, "clock_group", tape.clocked)
        patch.setattr(campaign, "expect", lambda _: None)
        patch.setattr(campaign, "Progress", Watched)
        patch.setattr(campaign.time, "monotonic", lambda: tape.now)
        campaign.carry_out(study, Path(out) / "run", cases, engines, workers=workers, resume=False)
    return looks


def factors(looks: Sequence[Look]) -> list[float]:
    """Foreseen over taken, of the looks that are held to their word."""
    return [look.factor for look in looks if FIRST * look.whole < look.now < LAST * look.whole]


if __name__ == "__main__":
    said = replay(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 2)
    held = factors(said)
    within = sum(1 / 1.5 <= factor <= 1.5 for factor in held)
    worst = max(held, key=lambda factor: max(factor, 1 / factor))
    print(f"{said[-1].whole:.0f} s, {len(said)} looks; {within} of {len(held)} within half as much again, worst {worst:.2f}")
    for tenth in range(10):
        here = [look.factor for look in said if tenth <= 10 * look.now / look.whole < tenth + 1]
        print(f"{10 * tenth:3d} %", f"{min(here):.2f} .. {max(here):.2f} in {len(here)}" if here else "no look")
