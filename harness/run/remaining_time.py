"""How long a run will still take, and how surely, by how long its pieces took so far.

An answer takes what a process takes to start, and a time that grows with its steps: along a ladder with 1/dt. Both are learnt
from the answers that there are: of the same case on the same engine, else of the same case, else of all. The first answer of
an engine is left out as long as there is another, since it pays for what all share: an engine that is loaded, or compiles.
What runs already has had its time so far. The timing run of a group of trials starts a process for each engine; each trial is
calibrated there and takes its samples, each a whole run of its scene where that is longer than a sample has to be, and fewer
of long runs. How far that is off is learnt from the groups that were clocked.

What a search will still ask for counts as so many pieces like one that it asked for already, one after the other where it waits
for each before it asks for the next.

What is told is a range, that of nine values in ten by the doubts of what it is made of. They are shares of its parts, and
shrink as a kind of work becomes known; `tests/replay_progress.py` plays recorded runs back, by which they were chosen. Beyond a
factor of three from end to end a range helps nobody: a wider one is told as one of three around the same middle, and one that
would be more than twice as wide is not told.

That nine of ten hold is said of runs together: looks at one run share what they miss. The worst of those recorded holds in 6
of 9, while another process took the machine; else what is missed are cases of which nothing is known: with one waiting 66 of
82 ranges hold, without 272 of 286. To begin with one trial of each case does not help, since the first pays for its truth and
compiling: the same answers in that order hold in 12 of 41 looks for 44 of 55 (`quick`), in 30 of 62 for 62 of 68
(`accuracy`).
"""

import math
from bisect import insort
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from heapq import heapreplace
from statistics import geometric_mean

from harness.run.pieces import Awaited, Piece
from harness.trial.bench import FEW, LONG

__all__ = ["WIDEST", "Estimate", "RemainingTime"]

WIDEST = 3.0
"""Largest over smallest end of a range that is told."""


START = 0.3
"""Seconds that a process takes to start on a machine with nothing else to do: how much longer it takes here, all takes."""
CALIBRATION = 0.2
"""Starts that a trial takes in a timing run before its samples, beside running its scene once: until a group has shown it."""
CANARY = 0.004
"""Seconds of the fixed kernel that is clocked beside each sample."""
STEPPING = 0.1
"""Share of an answer beyond its start in which its scene is run once; the rest is other runs and judging it."""
TRUST = 3
"""Pieces, for as many of which what was foreseen counts beside those that came: one odd piece does not turn all."""
LATELY = 12
"""Answers that came last, by which the pace of those that wait is foreseen: a machine is as busy as it was lately, and a
process that stood still once does not stand still again."""
RECENT = 6
"""Groups that were clocked last, by which those that wait are foreseen: what else the machine does changes within a run."""

SURE = 1.64
"""Standard deviations to both sides within which nine of ten values lie, where their logarithm is normal."""
PACE = 0.25
"""Doubt of all together: that the machine is as busy from now on as it was."""
SIDE, CASE, STRANGE = 0.2, 0.4, 0.8
"""Doubt of the answers of a case on an engine: where such have come, where some of the case have, where none has."""
SEARCHED = 0.4
"""Doubt of what a search will still ask for; half of it is common to all searches."""
CLOCK = 0.4
"""Doubt of the clock before any group of trials was clocked; it falls with the root of the number of groups."""
TELLING = 6.0
"""A range that would be wider is not told."""
LEAP = 1.5
"""By how much what is told may grow from one look to the next where nothing was learned."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Seconds until all work is done, in nine of ten cases. Terms: news: what was learned, where it is far more than before."""

    low: float
    high: float
    news: str = ""

    @property
    def middle(self) -> float:
        """By a ratio as far from one end as from the other."""
        return math.sqrt(self.low * self.high)


@dataclass(slots=True)
class _Kind:
    """What is known of the answers of a kind: how many came, their seconds in sum, and the sums of a straight line.

    Seconds over steps, each answer weighted by what it was foreseen to take, so that along a ladder each counts alike.
    """

    count: int = 0
    seconds: float = 0.0
    weights: float = 0.0
    x: float = 0.0
    xx: float = 0.0
    y: float = 0.0
    xy: float = 0.0

    def add(self, steps: float, seconds: float, foreseen: float) -> None:
        weight = 1.0 / max(foreseen, 1e-6) ** 2
        self.count, self.seconds, self.weights = self.count + 1, self.seconds + seconds, self.weights + weight
        self.x, self.xx = self.x + weight * steps, self.xx + weight * steps**2
        self.y, self.xy = self.y + weight * seconds, self.xy + weight * steps * seconds

    def of(self, steps: float, start: float) -> float:
        """Seconds of so many steps: by the line through all answers and, for as much as one of them, a start without steps."""
        one = 1.0 / max(start, 1e-6) ** 2
        weights, y = self.weights + one, self.y + one * start
        slope = max(0.0, (weights * self.xy - self.x * y) / (weights * self.xx - self.x**2))
        return max(0.5 * start, (y - slope * self.x) / weights + slope * steps)


class _Answers:
    """Seconds of an answer, as foreseen by those that came; and what those took over what they had been foreseen to take."""

    def __init__(self) -> None:
        self._first: set[str] = set()
        self._ordered: list[float] = []
        self._all, self._cases, self._sides = _Kind(), dict[str, _Kind](), dict[tuple[str, str], _Kind]()
        self._took: dict[str, tuple[float, float]] = {}
        self._late: list[tuple[Piece, float]] = []
        self._runs = self._beyond = 0.0

    def add(self, piece: Piece, seconds: float, run: float) -> None:
        """Args: run [s]: of its steps, where that is known; else 0."""
        if piece.engine not in self._first:
            self._first.add(piece.engine)
            return
        foreseen = self.seconds(piece) if self.known else seconds
        self._took[piece.name] = seconds, run
        self._late = [*self._late[1 - LATELY :], (piece, seconds)]
        insort(self._ordered, seconds)
        self._all.add(piece.steps, seconds, foreseen)
        self._cases.setdefault(piece.case, _Kind()).add(piece.steps, seconds, foreseen)
        self._sides.setdefault((piece.case, piece.engine), _Kind()).add(piece.steps, seconds, foreseen)
        if run:
            self._runs, self._beyond = self._runs + run, self._beyond + max(0.0, seconds - self.start)

    @property
    def known(self) -> bool:
        """Is anything known?"""
        return bool(self._ordered)

    @property
    def start(self) -> float:
        """What most take at least: a quarter takes less."""
        return self._ordered[len(self._ordered) // 4]

    def doubt(self, piece: Piece) -> float:
        """How far off an answer may be, by what is known of its kind."""
        if (piece.case, piece.engine) in self._sides:
            return SIDE
        return CASE if piece.case in self._cases else STRANGE

    def pace(self) -> float:
        """What the last answers took over what they would have by all of them."""
        usual = TRUST * self._all.seconds / self._all.count
        foreseen = sum(self.seconds(piece) for piece, _ in self._late)
        return (sum(seconds for _, seconds in self._late) + usual) / (foreseen + usual)

    def seconds(self, piece: Piece) -> float:
        """Of this piece; of a case that nothing is known of, between the mean of the known ones and what its steps say."""
        start = self.start
        kind = self._sides.get((piece.case, piece.engine)) or self._cases.get(piece.case)
        if kind is not None:
            return kind.of(piece.steps, start)
        mean = geometric_mean(kind.seconds / kind.count for kind in self._cases.values())
        return math.sqrt(mean * self._all.of(piece.steps, start))

    def run(self, piece: Piece, busy: float) -> float:
        """Seconds of its steps alone, as they were clocked or a share of its answer. Args: busy: seconds for one of the CPU."""
        took, run = self._took.get(piece.name, (0.0, 0.0))
        if known := piece.run or run:
            return busy * known
        share = busy * self._runs / self._beyond if self._beyond else STEPPING
        return min(1.0, share) * max(0.0, (took or self.seconds(piece)) - self.start)


@dataclass(slots=True)
class _Parts:
    """Seconds of parts of the work, and the square of how far off their sum may be."""

    seconds: float = 0.0
    square: float = 0.0

    def add(self, seconds: float, doubt: float) -> None:
        """One more, whose doubt is its own."""
        self.seconds += seconds
        self.square += (doubt * seconds) ** 2

    def common(self, doubt: float) -> None:
        """A doubt of all so far."""
        self.square += (doubt * self.seconds) ** 2


@dataclass(slots=True)
class _Group:
    """Clocked together. Terms: seconds: all of it."""

    names: list[str] = field(default_factory=list)
    seconds: float = 0.0


class RemainingTime:
    """What is known of the pieces of a run, and what follows for those that wait. All times are told it, on one clock [s]."""

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._pieces: dict[str, Piece] = {}
        self._waiting: set[str] = set()
        self._to_clock: set[str] = set()
        self._order: dict[str, int] = {}
        self._ends: list[float] = []
        self._answers = _Answers()
        self._clocked: dict[str, _Group] = {}
        self._now = self._last_clock = 0.0
        self._awaited: Callable[[], Sequence[Awaited]] = tuple
        self._told: tuple[float, float] | None = None
        self._news = ""

    def expect(self, pieces: Iterable[Piece]) -> None:
        """These are to be answered, and clocked where they have samples."""
        for piece in pieces:
            if piece.name not in self._pieces:
                self._pieces[piece.name] = piece
                self._waiting.add(piece.name)
                self._to_clock |= {piece.name} if piece.count else set()
                self._news = "searches ask for more"

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
        self._now = now

    def answered(self, name: str, now: float, *, to_clock: bool, run: float = 0.0) -> None:
        """A piece has ended. The n-th that was begun began with the n-th time that a worker was free.

        Args: run [s]: of its steps, of CPU time and roughly; 0 where that is not known.
        """
        self._now = now
        piece = self._pieces.get(name)
        if piece is None or name not in self._waiting:
            return
        self._waiting.discard(name)
        begun = self._begun(name)
        self._ends.append(now)
        if not to_clock:
            self._to_clock.discard(name)
        if self._answers.known and self._answers.doubt(piece) == STRANGE:
            self._news = "a case began of which nothing was known"
        self._answers.add(piece, now - (self._ends[-2] if begun is None else begun), run)

    def chosen_for_clock(self, pieces: Iterable[Piece]) -> None:
        """Points of a sweep that are clocked after all, with their samples: which was not known before they were tried."""
        self._pieces |= {piece.name: piece for piece in pieces}

    def clocks_begin(self, names: Collection[str], now: float) -> None:
        """No other pieces than these wait for the clock now."""
        self._to_clock, self._now, self._last_clock = set(names) & set(self._pieces), now, now
        self._news = "the clock began"

    def clocked(self, name: str, now: float) -> None:
        """A timing has come; with the first of a group come all, and the time is that of them all."""
        self._now = now
        piece = self._pieces.get(name)
        if piece is None:
            return
        group = self._clocked.get(piece.group)
        if group is None or name not in group.names:
            more = [other for other in self._to_clock if self._pieces[other].group == piece.group]
            group = self._clocked.setdefault(piece.group, _Group())
            group.names += more
            self._to_clock -= set(more)
            self._news = self._news or ("the first trials were clocked" if len(self._clocked) == 1 else "")
        group.seconds += now - self._last_clock
        self._last_clock = now

    def left(self) -> Estimate | None:
        """Until all that is known of is done; None while too little is known of how long a piece takes."""
        if not self._answers.known:
            return None
        parts = self._parts()
        if parts.seconds <= 0.0:
            return Estimate(0.0, 0.0)
        parts.common(math.hypot(PACE, math.log(self._answers.pace())))
        width = math.exp(2 * SURE * math.sqrt(parts.square) / parts.seconds)
        if width > TELLING:
            return None
        middle, news = self._smoothed(parts.seconds)
        half = math.sqrt(min(width, WIDEST))
        return Estimate(middle / half, middle * half, news)

    def _smoothed(self, middle: float) -> tuple[float, str]:
        """What is told, no leap above what was told before where nothing was learned; and what was learned where it is one."""
        news, self._news = self._news, ""
        leaps = False
        if self._told is not None:
            told, then = self._told
            most = LEAP * max(told - (self._now - then), 0.1 * told)
            leaps = middle > most
            middle = middle if news or not leaps else most
        self._told = middle, self._now
        return middle, news if leaps else ""

    def _parts(self) -> _Parts:
        pace, parts = self._answers.pace(), _Parts()
        waiting = [name for name in self._pieces if name in self._waiting]
        due = [self._of_waiting(name, pace) for name in waiting]
        total, share = sum(due), self._shared(due)
        kinds: dict[tuple[str, float], float] = {}
        for name, seconds in zip(waiting, due, strict=True):
            piece = self._pieces[name]
            doubt = self._answers.doubt(piece)
            key = piece.case + piece.engine if doubt == SIDE else piece.case, doubt
            kinds[key] = kinds.get(key, 0.0) + seconds
        for (_, doubt), seconds in kinds.items():
            parts.add(seconds / total * share if total else 0.0, doubt)

        searched, chains = _Parts(), [0.0]
        asked = self._awaited()
        for each in asked:
            seconds = pace * self._answers.seconds(each.like)
            searched.add(each.answers * seconds / self._workers, SEARCHED)
            chains.append(math.ceil(each.answers / each.at_once) * seconds)
        searched.common(SEARCHED / 2)
        if searched.seconds:
            longer = max(1.0, max(chains) / searched.seconds)
            parts.seconds += longer * searched.seconds
            parts.square += longer**2 * searched.square

        clock = self._clock_left(asked)
        clock.common(CLOCK / math.sqrt(1 + len(self._clocked)))
        parts.seconds += clock.seconds
        parts.square += clock.square
        return parts

    def _begun(self, name: str) -> float | None:
        """When a piece was begun; None of one that waits for a worker, or whose place nobody knows."""
        place = self._order.get(name, len(self._ends))
        return self._ends[place] if place < len(self._ends) else None

    def _of_waiting(self, name: str, pace: float) -> float:
        """What is left of it: one that runs for longer than was foreseen will take half as long again."""
        foreseen, begun = pace * self._answers.seconds(self._pieces[name]), self._begun(name)
        if begun is None:
            return foreseen
        return max(foreseen - (self._now - begun), (self._now - begun) / 2)

    def _shared(self, seconds: Sequence[float]) -> float:
        """Until the last of these is done, each taken by the worker that is free first."""
        free = [0.0] * self._workers
        for each in seconds:
            heapreplace(free, free[0] + each)
        return max(free)

    def _clock_left(self, searched: Sequence[Awaited]) -> _Parts:
        recent = list(self._clocked.values())[-RECENT:]
        behind = sum(self._of_group([self._pieces[name] for name in group.names]) for group in recent)
        usual = TRUST * behind / len(recent) if recent else 1.0
        scale = (sum(group.seconds for group in recent) + usual) / (behind + usual)
        groups: dict[str, list[Piece]] = {}
        for name in self._to_clock:
            groups.setdefault(self._pieces[name].group, []).append(self._pieces[name])
        left = _Parts()
        for group in groups.values():
            left.add(scale * self._of_group(group), SIDE)
        for each in searched:
            if each.clocks:
                left.add(scale * (each.like.processes * self._start + each.clocks * self._clock_of(each.like)), SEARCHED)
        return left

    @property
    def _start(self) -> float:
        return self._answers.start

    def _of_group(self, pieces: Sequence[Piece]) -> float:
        processes = {piece.engine: piece.processes for piece in pieces}
        return sum(processes.values()) * self._start + sum(self._clock_of(piece) for piece in pieces)

    def _clock_of(self, piece: Piece) -> float:
        """Seconds of a trial in a timing run beyond the start of its processes."""
        start = self._start
        busy = max(1.0, start / START)
        run = self._answers.run(piece, busy)
        sample = busy * piece.sample
        runs, long = max(sample, run), run > LONG * sample
        count, processes = (min(of, FEW) if long else of for of in (piece.count, piece.processes))
        return count * (runs + busy * CANARY) + processes * (min(runs, LONG * sample) + CALIBRATION * start)
