"""How well a run would have said how long it still takes: finished runs played back against today's estimate.

    python -m tests.replay_progress DIR [DIR ...] [--workers N] [--write FILE]

The campaign is carried out anew in a folder of its own, with its searches, but for the work: each answer and each timing is
what the journal holds, and the clock stands where its line was written. What the estimate is told on the way is a recording,
which needs neither cases nor engines to be played again; with --write it is kept. What is printed is of the looks that a
terminal would show, one a second at most, behind the first tenth of a run.
"""

import argparse
import json
import math
import tempfile
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Self

import pytest

from harness.run import campaign
from harness.run.pieces import Awaited, Piece
from harness.run.progress import Progress
from harness.run.remaining_time import Estimate, RemainingTime
from harness.store.record import Record, Timing
from harness.store.store import Store
from harness.study import plugins
from harness.study.study import load_study
from harness.study.trial import Trial

__all__ = ["Held", "Look", "Recording", "held", "played", "read_recordings", "recorded"]

FIRST, LAST = 0.1, 0.98
"""Shares of a run between which an estimate is held to its word; of the last seconds the next line tells more."""
EVERY = 1.0
"""Seconds between looks of somebody at a terminal."""


@dataclass(frozen=True, slots=True)
class Look:
    """What was said at an instant. Terms, all [s] since the run began: now; said; whole: when it was over."""

    now: float
    said: Estimate | None
    whole: float

    @property
    def truth(self) -> float:
        """What it still took [s]."""
        return self.whole - self.now


@dataclass(frozen=True, slots=True)
class Recording:
    """What an estimate was told in a run.

    Terms: whole [s]: what the run took. pieces: the fields of each, its name a number. events: a letter each, with its
    arguments, times [s] since the run began: e(xpected), s(earched: like this one, answers, clocks, at once), f(orgotten),
    b(egun), a(nswered), p(icked for the clock), c(locks begin), t(imed).
    """

    name: str
    workers: int
    whole: float
    pieces: Sequence[Sequence[Any]]
    events: Sequence[Sequence[Any]]


def read_recordings(path: Path) -> list[Recording]:
    """Those of a file."""
    return [Recording(**each) for each in json.loads(path.read_text(encoding="utf-8"))]


def write_recordings(path: Path, recordings: Iterable[Recording]) -> None:
    """Into a file, a run a line."""
    lines = []
    for each in recordings:
        fields = {name: getattr(each, name) for name in Recording.__dataclass_fields__}
        lines.append(json.dumps(fields, separators=(",", ":")))
    path.write_text("[" + ",\n".join(lines) + "]\n", encoding="utf-8")


def played(recording: Recording) -> list[Look]:
    """What today's estimate says after each piece of work of a recording."""
    pieces = [Piece(**{**dict(zip(_FIELDS, row, strict=True)), "name": str(row[0])}) for row in recording.pieces]
    names = [piece.name for piece in pieces]
    remaining, looks, searched = RemainingTime(recording.workers), list[Look](), list[Awaited]()
    remaining.foresee(lambda: searched)
    for kind, *told in recording.events:
        match kind:
            case "e":
                remaining.expect(pieces[k] for k in told[0])
            case "s":
                searched[:] = [Awaited(pieces[k], *rest) for k, *rest in told[0]]
            case "f":
                remaining.forget([names[k] for k in told[0]])
            case "b":
                remaining.answers_begin([names[k] for k in told[0]], told[1])
            case "a":
                remaining.answered(names[told[0]], told[1], to_clock=bool(told[2]), run=told[3])
            case "p":
                remaining.chosen_for_clock(pieces[k] for k in told[0])
            case "c":
                remaining.clocks_begin([names[k] for k in told[0]], told[1])
            case "t":
                remaining.clocked(names[told[0]], told[1])
        if kind in "at" and (not looks or told[1] - looks[-1].now >= EVERY):
            looks.append(Look(told[1], remaining.left(), recording.whole))
    return looks


_FIELDS = tuple(Piece.__dataclass_fields__)


class _Recorder(RemainingTime):
    """An estimate that writes down what it is told."""

    def __init__(self, workers: int) -> None:
        super().__init__(workers)
        self.events: list[list[Any]] = []
        self.pieces: dict[tuple[Any, ...], int] = {}
        self.names: dict[str, int] = {}
        self.groups: dict[str, str] = {}
        self.begin = 0.0

    def _number(self, piece: Piece) -> int:
        name = self.names.setdefault(piece.name, len(self.names))
        group = self.groups.setdefault(piece.group, f"g{len(self.groups)}")
        case = piece.case.rpartition("/")[2]
        row = (name, case, piece.engine, round(piece.steps, 1), *astuple(piece)[4:-2], group, float(f"{piece.run:.2g}"))
        return self.pieces.setdefault(row, len(self.pieces))

    def _numbers(self, names: Collection[str]) -> list[int]:
        return [self._number(self._pieces[name]) for name in names if name in self._pieces]

    def _at(self, now: float) -> float:
        return round(now - self.begin, 3)

    def expect(self, pieces: Iterable[Piece]) -> None:
        pieces = list(pieces)
        self.events.append(["e", [self._number(piece) for piece in pieces]])
        super().expect(pieces)

    def forget(self, names: Collection[str]) -> None:
        if known := self._numbers(names):
            self.events.append(["f", known])
        super().forget(names)

    def answers_begin(self, names: Sequence[str], now: float) -> None:
        self.begin = self.begin or now
        self.events.append(["b", self._numbers(names), self._at(now)])
        super().answers_begin(names, now)

    def answered(self, name: str, now: float, *, to_clock: bool, run: float = 0.0) -> None:
        super().answered(name, now, to_clock=to_clock, run=run)
        self._write_searches()
        self.events.append(["a", self._numbers([name])[0], self._at(now), int(to_clock), float(f"{run:.2g}")])

    def chosen_for_clock(self, pieces: Iterable[Piece]) -> None:
        pieces = list(pieces)
        self.events.append(["p", [self._number(piece) for piece in pieces]])
        super().chosen_for_clock(pieces)

    def clocks_begin(self, names: Collection[str], now: float) -> None:
        self._write_searches()
        self.events.append(["c", self._numbers(names), self._at(now)])
        super().clocks_begin(names, now)

    def clocked(self, name: str, now: float) -> None:
        self.events.append(["t", self._numbers([name])[0], self._at(now)])
        super().clocked(name, now)

    def _write_searches(self) -> None:
        searched = [
            [self._number(each.like), round(each.answers, 1), round(each.clocks, 1), each.at_once]
            for each in self._awaited()
            if each.answers or each.clocks
        ]
        last: list[Any] = next((event[1] for event in reversed(self.events) if event[0] == "s"), [])
        if searched != last:
            self.events.append(["s", searched])


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


def recorded(folder: Path, workers: int = 2) -> Recording:
    """What a run with so many workers would have been told. Raises: KeyError, where lines bear no time."""
    tape, kept = _Tape(folder), list[_Recorder]()

    class Silent(Progress):
        """Shows nothing."""

        def __enter__(self) -> Self:
            return self

        def advance(self, last: str) -> None:
            pass

    def recorder(workers: int) -> _Recorder:
        kept.append(_Recorder(workers))
        return kept[-1]

    store = Store(folder)
    study = load_study(str(folder / "study.toml"))
    engines = {name: plugins.adapter(name) for name in store.catalogue["engines"]}
    cases = {name: plugins.case(name) for name in store.catalogue["cases"]}
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as out:
        patch.setattr(campaign, "run_isolated", tape.isolated)
        patch.setattr(campaign, "clock_group", tape.clocked)
        patch.setattr(campaign, "expect", lambda _: None)
        patch.setattr(campaign, "Progress", Silent)
        patch.setattr(campaign, "RemainingTime", recorder)
        patch.setattr("harness.run.campaign.time.monotonic", lambda: tape.now)
        trajectories = Path(out) / "run" / "trajectories"
        trajectories.mkdir(parents=True)
        for path in (folder / "trajectories").glob("[!.]*.npz"):
            trajectories.joinpath(path.name).symlink_to(path.resolve())
        campaign.carry_out(study, Path(out) / "run", cases, engines, workers=workers, resume=False)
    told = kept[0]
    if told._waiting:
        raise ValueError(f"{folder}: {len(told._waiting)} trials of today's study have no answer; run it anew")
    return Recording(study.name, workers, round(tape.end - tape.begin, 3), [*map(list, told.pieces)], told.events)


@dataclass(frozen=True, slots=True)
class Held:
    """How the looks at a run held.

    Terms: looks: that count. told: of these, with an estimate. within: of the told, truth within the range. near: of the told,
    middle within half as much again of the truth. widest: largest over smallest end. leaps: to more than half as much again
    of what was told, less what had passed, from one look to the next, and without a word of what was learned.
    """

    looks: int
    told: int
    within: int
    near: int
    widest: float
    leaps: int


def held(looks: Sequence[Look]) -> Held:
    """Of the looks that are held to their word."""
    count = [look for look in looks if FIRST * look.whole < look.now < LAST * look.whole]
    told = [(look, look.said) for look in count if look.said is not None]
    leaps = 0
    for (before, said), (after, then) in pairwise(told):
        rest = max(said.middle - (after.now - before.now), 0.1 * said.middle)
        leaps += then.middle > 1.5 * rest * (1 + 1e-9) and not then.news
    return Held(
        looks=len(count),
        told=len(told),
        within=sum(said.low <= look.truth <= said.high for look, said in told),
        near=sum(said.middle > 0 and abs(math.log(said.middle / look.truth)) <= math.log(1.5) for look, said in told),
        widest=max((said.high / said.low for _, said in told if said.low), default=1.0),
        leaps=leaps,
    )


def _main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sources", nargs="+", type=Path, help="run folders, or a file of recordings")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--write", type=Path)
    asked = parser.parse_args()
    recordings: list[Recording] = []
    for source in asked.sources:
        recordings += [recorded(source, asked.workers)] if source.is_dir() else read_recordings(source)
    for recording in recordings:
        looks = played(recording)
        print(f"{recording.name}, {recording.whole:.0f} s: {held(looks)}")
        for tenth in range(10):
            here = [look for look in looks if tenth <= 10 * look.now / look.whole < tenth + 1]
            told = [look.said.middle / look.truth for look in here if look.said is not None and look.truth]
            print(f"{10 * tenth:4d} %", f"{min(told):.2f} .. {max(told):.2f} in {len(told)} of {len(here)}" if told else "-")
    if asked.write is not None:
        write_recordings(asked.write, recordings)


if __name__ == "__main__":
    _main()
