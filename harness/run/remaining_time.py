"""How long a run will still take, by how long its answers and timing runs took so far.

An answer takes as long as those of the same case on the same engine in the mean, else as those of the same case, else as all: a
start, and a time that grows with its steps. The first answer of an engine is left out: it also pays for loading and compiling.
A timing run takes its samples, scaled by what the timing runs so far took. A search counts as one more round like its newest.
The range is the middle half of what answers took, over what they had been foreseen to take.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from statistics import quantiles

from plumbline.harness.case import Case
from plumbline.harness.store.record import Record
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.bench import FEW, LONG

ENOUGH = 4
"""Answers that were foreseen, before which nothing is said."""
START = 0.1
"""Seconds that a trial takes of the start of a process, and to be ready in it."""
STEPS = 0.5
"""Of what a run of a refined ladder takes, the share of its steps; the rest is judging them."""

Kind = tuple[str, ...]
"""Case and engine, the case alone, or nothing: of all answers."""


def seconds_of_run(trial: Trial, record: Record, case: Case) -> float:
    """What the steps of a run take, of CPU time and roughly; 0 if that is not known or what is clocked is no step."""
    share = 1.0 if trial.experiment.refine is None else STEPS
    return share * (record.rough_cost or 0.0) * case.put(trial.parameters).duration if case.rays is None else 0.0


class RemainingTime:
    """What is known of the trials of a run, and the time that those which wait will take. `now` [s] is of one clock."""

    def __init__(self, cases: Mapping[str, Case], workers: int) -> None:
        self._cases, self._workers = cases, workers
        self._waiting: dict[str, Trial] = {}
        self._next_round: list[Trial] = []
        self._order: dict[str, int] = {}
        self._worker_free: list[float] = []
        self._engines_seen: set[str] = set()
        self._sums: dict[Kind, tuple[int, float, float]] = {}
        self._shortest = float("inf")
        self._ratios: list[float] = []
        self._runs: dict[str, float] = {}
        self._to_clock: dict[str, Trial] = {}
        self._clock_foreseen = self._clock_taken = self._last_clock = 0.0

    def expect(self, trials: Iterable[Trial]) -> None:
        """These are to be answered, and clocked if their study says so of each; what a search clocks is not known yet."""
        self._next_round = []
        for trial in trials:
            asked = trial.experiment
            searched = bool(asked.sweep or asked.dominance or asked.limit)
            self._waiting[trial.trial] = trial
            if asked.timing and trial.alteration.clocked and not searched:
                self._to_clock[trial.trial] = trial
            if searched or asked.effects or asked.refine:
                self._next_round.append(trial)

    def forget(self, names: Iterable[str]) -> None:
        """These have an answer already."""
        for name in names:
            self._waiting.pop(name, None)

    def answers_begin(self, names: Sequence[str], now: float) -> None:
        """All workers are free, and take these in this order."""
        self._order = {name: index for index, name in enumerate(names)}
        self._worker_free = [now] * self._workers

    def answered(self, record: Record, now: float) -> None:
        """A trial has ended. The n-th began when a worker was free for the n-th time."""
        trial = self._waiting.pop(record.trial, None)
        if trial is None:
            return
        begun = self._worker_free[min(self._order[record.trial], len(self._worker_free) - 1)]
        self._worker_free.append(now)
        self._runs[record.trial] = seconds_of_run(trial, record, self._cases[trial.case])
        if record.status not in ("passed", "failed"):
            self._to_clock.pop(record.trial, None)
        if trial.engine not in self._engines_seen:
            self._engines_seen.add(trial.engine)
            return
        seconds = max(now - begun, 1e-6)
        if self._sums:
            self._ratios.append(seconds / self._seconds(trial))
        self._shortest = min(self._shortest, seconds)
        for kind in ((trial.case, trial.engine), (trial.case,), ()):
            count, steps, total = self._sums.get(kind, (0, 0.0, 0.0))
            self._sums[kind] = count + 1, steps + self._steps(trial), total + seconds

    def clocks_begin(self, due: Collection[Trial], records: Mapping[str, Record], now: float) -> None:
        """Searches are over; no other trials than these wait for the clock."""
        self._next_round, self._last_clock = [], now
        self._to_clock = {trial.trial: trial for trial in due}
        self._runs |= {trial.trial: seconds_of_run(trial, records[trial.trial], self._cases[trial.case]) for trial in due}

    def clocked(self, trials: Iterable[Trial], now: float) -> None:
        """A timing of these has come, which were clocked in one sitting: the others come with it."""
        beside = [self._to_clock.pop(trial.trial) for trial in trials if trial.trial in self._to_clock]
        self._clock_foreseen += sum(map(self.clock, beside))
        self._clock_taken += now - self._last_clock
        self._last_clock = now

    def left(self) -> tuple[float, float] | None:
        """From how long to how long [s] until all is done that is known of; None if too little is known."""
        if len(self._ratios) < ENOUGH:
            return None
        answers = sum(self._seconds(trial) for trial in (*self._waiting.values(), *self._next_round)) / self._workers
        pace = self._clock_taken / self._clock_foreseen if self._clock_foreseen else 1.0
        seconds = answers + pace * sum(self.clock(trial) for trial in self._to_clock.values())
        low, _, high = quantiles(self._ratios, method="inclusive")
        return low * seconds, high * seconds

    def _steps(self, trial: Trial) -> float:
        settings = trial.settings
        duration = self._cases[trial.case].put(trial.parameters).duration
        return duration / settings.dt * (settings.substeps or 1) * trial.members

    def _seconds(self, trial: Trial) -> float:
        """Of an answer: the shortest of all for its start, and the mean beyond that times its steps over their mean."""
        kinds = ((trial.case, trial.engine), (trial.case,), ())
        count, steps, total = next(self._sums[kind] for kind in kinds if kind in self._sums)
        return self._shortest + (total - count * self._shortest) * self._steps(trial) / steps

    def clock(self, trial: Trial) -> float:
        """Seconds of a timing run: a start a process, and samples that take a run each if that is longer; few of long runs."""
        asked, run = trial.experiment, self._runs.get(trial.trial, 0.0)
        count = asked.processes * asked.samples
        if run > LONG * asked.sample_seconds:
            count = min(count, FEW)
        return asked.processes * START + count * max(asked.sample_seconds, run)


def together(trial: Trial) -> tuple[object, ...]:
    """What trials have in common that are clocked side by side: the question, whatever the settings."""
    return trial.experiment.name, trial.case, repr(trial.parameters)
