"""How long a run will still take, by how long its pieces took so far.

An answer takes what a process takes to start, and a time that grows with the number of steps: along a ladder with 1/dt. Both
are learnt from the answers that there are: of the same case on the same engine, else of the same case, else of all. The first
answer of an engine is left out as long as there is another, since it pays for what all share: an engine that is loaded, or
compiles. The timing run of a group of trials starts a process for each engine; each trial takes its samples, and a share of
what its answer took, for the warm-up and the calibration. How far that is off is learnt from the groups that were clocked.

What a search will still ask for counts as so many pieces like one that it asked for already.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from heapq import heapreplace
from statistics import fmean

from harness.case import Case
from harness.case.alteration import REFINED
from harness.search.to_come import ToCome, seconds_of_run
from harness.store.record import Record
from harness.study.trial import Trial
from harness.trial.bench import LONGEST

__all__ = ["Awaited", "Piece", "RemainingTime", "awaited", "clocked_pieces", "pieces_of"]

WARM_UP = 0.02
"""Of the time of an answer, that each process of a timing run takes before its samples: until a group has shown it."""

LOADING, STARTS = 0.7, 1.0
"""Seconds, and starts of an answer, that a process of a timing run takes to load its engine off a server of its own: until a
group has shown it. The starts tell how busy the machine is."""
TRUST = 3
"""Groups, for as many of which what was foreseen counts beside those that were clocked: one odd group does not turn all."""
LATELY = 12
"""Answers that came last, by which the pace of those that wait is foreseen: a machine is as busy as it was lately, and a
process that stood still once does not stand still again."""
RECENT = 6
"""Groups that were clocked last, by which those that wait are foreseen: what else the machine does changes within a run."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """A trial as work.

    Terms: steps: that its engine takes. samples [s]: of its timing run, 0 without one; processes: of it; group: those that are
    clocked together, in one process an engine. warm_up: share of its answer that goes before the samples, 0 where they hold it.
    """

    name: str
    case: str
    engine: str
    steps: float
    samples: float = 0.0
    processes: int = 1
    group: str = ""
    warm_up: float = WARM_UP


@dataclass(frozen=True, slots=True)
class Awaited:
    """Pieces like this one that a search will ask for. Terms: answers, clocks: how many, in expectation."""

    like: Piece
    answers: float
    clocks: float


def pieces_of(trials: Iterable[Trial], cases: Mapping[str, Case]) -> list[Piece]:
    """These trials as work; which settings of a sweep are clocked is not known before they are tried."""
    pieces = []
    for trial in trials:
        asked = trial.experiment
        altered = trial.alteration.name in REFINED or trial.alteration.start or trial.alteration.undropped
        clocked = asked.timing and not asked.sweep and asked.limit is None and not altered
        piece = _piece(trial, cases[trial.case])
        pieces.append(piece if clocked else replace(piece, samples=0.0))
    return pieces


def clocked_pieces(trials: Iterable[Trial], records: Mapping[str, Record], cases: Mapping[str, Case]) -> list[Piece]:
    """These trials as work, all of them clocked. Args: records: theirs, by which a whole run is known to take so long."""
    return [_piece(trial, cases[trial.case], seconds_of_run(records[trial.trial], cases[trial.case])) for trial in trials]


def _piece(trial: Trial, case: Case, run: float = 0.0) -> Piece:
    """A trial as work that is clocked. Args: run [s]: what its steps take, where that is known.

    A sample is a whole run, and so is the calibration before; of one that is too long it is a part.
    """
    asked, settings = trial.experiment, trial.settings
    sample = max(asked.sample_seconds, min(run, LONGEST * asked.sample_seconds))
    samples = asked.samples * asked.sample_seconds if run == 0.0 else (asked.samples + 1) * sample
    return Piece(
        name=trial.trial,
        case=trial.case,
        engine=trial.engine,
        steps=case.duration / settings.dt * (settings.substeps or 1) * trial.members,
        samples=asked.processes * samples,
        processes=asked.processes,
        group=repr((asked.name, trial.case, trial.parameters)),
        warm_up=WARM_UP if run == 0.0 else 0.0,
    )


def awaited(expected: Iterable[ToCome], cases: Mapping[str, Case]) -> list[Awaited]:
    """What searches will ask for, as work."""
    return [Awaited(_piece(each.like, cases[each.like.case], each.run), each.answers, each.clocks) for each in expected]


@dataclass(frozen=True, slots=True)
class _Took:
    piece: Piece
    seconds: float


@dataclass(frozen=True, slots=True)
class _Group:
    """Clocked together. Terms: seconds: all of it."""

    names: list[str]
    seconds: float


class RemainingTime:
    """What is known of the pieces of a run, and what follows for those that wait. All times are told it, on one clock [s]."""

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._pieces: dict[str, Piece] = {}
        self._waiting: set[str] = set()
        self._to_clock: set[str] = set()
        self._order: dict[str, int] = {}
        self._ends: list[float] = []
        self._first: dict[str, _Took] = {}
        self._took: dict[str, _Took] = {}
        self._clocked: dict[str, _Group] = {}
        self._last_clock = 0.0
        self._awaited: Callable[[], Sequence[Awaited]] = tuple

    def expect(self, pieces: Iterable[Piece]) -> None:
        """These are to be answered, and clocked where they have samples."""
        for piece in pieces:
            if piece.name not in self._pieces:
                self._pieces[piece.name] = piece
                self._waiting.add(piece.name)
                self._to_clock |= {piece.name} if piece.samples else set()

    def foresee(self, awaited: Callable[[], Sequence[Awaited]] = tuple) -> None:
        """What searches will ask for beyond what is expected, told anew at each look; nothing more where it is left out."""
        self._awaited = awaited

    def forget(self, names: Collection[str]) -> None:
        """These have an answer already, or will have none that takes time."""
        self._waiting -= set(names)

    def answers_begin(self, names: Sequence[str], now: float) -> None:
        """All workers are free, and take these in this order."""
        self._order = {name: place for place, name in enumerate(names)}
        self._ends = [now] * self._workers

    def answered(self, name: str, now: float, *, to_clock: bool) -> None:
        """A piece has ended. The n-th that was begun began with the n-th time that a worker was free."""
        piece = self._pieces.get(name)
        if piece is None or name not in self._waiting:
            return
        self._waiting.discard(name)
        took = _Took(piece, now - self._ends[min(self._order.get(name, len(self._ends)), len(self._ends) - 1)])
        self._ends.append(now)
        if not to_clock:
            self._to_clock.discard(name)
        if piece.engine in self._first:
            self._took[name] = took
        else:
            self._first[piece.engine] = took

    def chosen_for_clock(self, pieces: Iterable[Piece]) -> None:
        """Points of a sweep that are clocked after all, with their samples: which was not known before they were tried."""
        self._pieces |= {piece.name: piece for piece in pieces}

    def clocks_begin(self, names: Collection[str], now: float) -> None:
        """No other pieces than these wait for the clock now."""
        self._to_clock, self._last_clock = set(names) & set(self._pieces), now

    def clocked(self, name: str, now: float) -> None:
        """A timing has come; those of a group come together, the time is that of them all."""
        piece = self._pieces.get(name)
        if piece is None:
            return
        self._to_clock.discard(name)
        group = self._clocked.setdefault(piece.group, _Group([], 0.0))
        self._clocked[piece.group] = _Group([*group.names, name], group.seconds + now - self._last_clock)
        self._last_clock = now

    def left(self) -> float | None:
        """Seconds until all that is known of is done; None while nothing is known of how long a piece takes."""
        known = self._took or self._first
        if not known:
            return None
        model = _Model(list(known.values()))
        waiting = [name for name in self._pieces if name in self._waiting]
        searched = self._awaited()
        due = self._shared([model.seconds(self._pieces[name]) for name in waiting])
        to_come = sum(each.answers * model.seconds(each.like) for each in searched) / self._workers
        return due + to_come + self._clock_left(model, searched)

    def _shared(self, seconds: Sequence[float]) -> float:
        """Until the last of these is done, each taken by the worker that is free first."""
        free = [0.0] * self._workers
        for each in seconds:
            heapreplace(free, free[0] + each)
        return max(free)

    def _clock_left(self, model: "_Model", searched: Sequence[Awaited]) -> float:
        def foreseen(names: Collection[str]) -> float:
            pieces = [self._pieces[name] for name in names]
            starts = {(piece.group, piece.engine): piece.processes for piece in pieces}
            warm_up = sum(self._clock_of(piece, model) for piece in pieces)
            return sum(starts.values()) * start + warm_up

        start = LOADING + STARTS * model.start
        clocked = [each for each in searched if each.clocks]
        to_come = sum(each.clocks * self._clock_of(each.like, model) + each.like.processes * start for each in clocked)

        recent = list(self._clocked.values())[-RECENT:]
        behind = foreseen([name for group in recent for name in group.names])
        usual = TRUST * behind / len(recent) if recent else 1.0
        return (foreseen(self._to_clock) + to_come) * (sum(group.seconds for group in recent) + usual) / (behind + usual)

    def _clock_of(self, piece: Piece, model: "_Model") -> float:
        """Seconds of a timing run beyond the start of its processes."""
        return piece.samples + piece.warm_up * piece.processes * self._seconds(piece, model)

    def _seconds(self, piece: Piece, model: "_Model") -> float:
        """Of its answer: as it was, or as it is foreseen."""
        took = self._took.get(piece.name)
        return took.seconds if took is not None else model.seconds(piece)


class _Model:
    """Seconds of an answer: start + rate x steps, the rate of the same case and engine, else of the same case, else of all;
    times the pace of late, which is what the last answers took over what they would have by these."""

    def __init__(self, known: Sequence[_Took]) -> None:
        self._pace = 1.0
        ordered = sorted(took.seconds for took in known)
        self.start = ordered[len(ordered) // 4]
        self._by_side = _rates(known, self.start, lambda piece: (piece.case, piece.engine))
        self._by_case = _rates(known, self.start, lambda piece: (piece.case,))
        self._mean = fmean(fmean(each) for each in _grouped(known).values())
        self._by_all = _rates(known, self.start, lambda _: ())[()]
        late = known[-LATELY:]
        usual = TRUST * fmean(took.seconds for took in known)
        self._pace = (sum(took.seconds for took in late) + usual) / (sum(self.seconds(took.piece) for took in late) + usual)

    def seconds(self, piece: Piece) -> float:
        """Of this piece; of a case that nothing is known of, between the mean of the known ones and the mean rate of all."""
        rate = self._by_side.get((piece.case, piece.engine), self._by_case.get((piece.case,)))
        if rate is not None:
            return self._pace * (self.start + rate * piece.steps)
        return self._pace * (0.5 * self._mean + 0.5 * (self.start + self._by_all * piece.steps))


def _grouped(known: Sequence[_Took]) -> dict[str, list[float]]:
    groups: dict[str, list[float]] = {}
    for took in known:
        groups.setdefault(took.piece.case, []).append(took.seconds)
    return groups


def _rates(known: Sequence[_Took], start: float, key: Callable[[Piece], tuple[str, ...]]) -> dict[tuple[str, ...], float]:
    """Seconds a step beyond the start, by key."""
    groups: dict[tuple[str, ...], list[_Took]] = {}
    for took in known:
        groups.setdefault(key(took.piece), []).append(took)
    return {
        name: max(0.0, sum(took.seconds - start for took in group)) / sum(took.piece.steps for took in group)
        for name, group in groups.items()
    }
