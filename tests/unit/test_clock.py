"""The clock: its statistics are what they claim on samples whose answer is known; no time is asserted."""

import contextlib
import dataclasses
import math
import multiprocessing
import random
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from plumbline.harness.adapter import Settings
from plumbline.harness.run import timed_processes as clockwork
from plumbline.harness.run.fork_servers import Origin, start
from plumbline.harness.run.interrupt import MemoryWatch, TimeIsUp, until
from plumbline.harness.run.message import Inbox
from plumbline.harness.run.timed_processes import Clocked, Ready, Team, joined
from plumbline.harness.run.timing_protocol import clock_group, summarise
from plumbline.harness.store.record import Sample, Timing
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.bench import Sampling
from tests.light_servers import light_servers

TRIAL = Trial(
    trial="t",
    study="s",
    experiment=Experiment(name="e"),
    case="c",
    parameters={},
    engine="x",
    engine_version="1",
    track="tuned",
    settings=Settings(dt=0.01),
    seed=0,
)
UNWATCHED = cast(MemoryWatch, SimpleNamespace(taken=0.0, stop=lambda: None))
SAMPLE = Sample(process=0, block=0, steps=100, cpu=0.5, wall=1.0, canary=0.001, switches=0, run=50)
FORTY, SEVEN = Sampling(40, 20), Sampling(7)


def test_the_median_is_taken_per_simulated_second() -> None:
    samples = [dataclasses.replace(SAMPLE, cpu=cpu) for cpu in (0.5, 0.50001, 0.49999, 0.5, 9.0)]
    timing = summarise(TRIAL, samples)
    assert timing.cpu_per_sim_s == 0.5  # 100 steps of 0.01 s are one simulated second
    assert timing.wall_per_sim_s == 1.0
    assert timing.realtime_factor == 1.0


def drifted(middle: float, low: float, high: float) -> tuple[float, float]:
    """Ends of an interval with the machine's drift: 1.96 times 1.6 %, added to the logarithms in squares."""
    below, above = (math.sqrt(math.log(end / middle) ** 2 + (1.95996 * 0.016) ** 2) for end in (low, high))
    return middle * math.exp(-below), middle * math.exp(above)


def test_equal_samples_have_the_interval_of_the_machines_drift_and_are_stable() -> None:
    timing = summarise(TRIAL, [SAMPLE] * 5)
    assert (timing.cpu_low, timing.cpu_high) == pytest.approx((0.5 * math.exp(-0.03136), 0.5 * math.exp(0.03136)), rel=1e-5)
    assert timing.unstable_timing is False


def test_the_interval_covers_the_median() -> None:
    timing = summarise(TRIAL, [dataclasses.replace(SAMPLE, cpu=0.5 + 0.001 * k) for k in range(9)])
    assert timing.cpu_low is not None
    assert timing.cpu_high is not None
    assert timing.cpu_per_sim_s is not None
    assert timing.cpu_low < 0.504 == timing.cpu_per_sim_s < timing.cpu_high
    assert timing.unstable_timing is False


def test_the_interval_of_a_price_is_that_of_the_median_of_its_samples() -> None:
    """Of 17 samples redrawn, the median is at most the fourth with a chance of .008, the fifth .036, the sixth .104.

    Student's t of 16 degrees of freedom is 2.120, the normal's percentile 1.960.
    """
    timing = summarise(TRIAL, [dataclasses.replace(SAMPLE, cpu=float(k)) for k in range(1, 18)])
    wider = 2.1199 / 1.95996
    found = timing.cpu_per_sim_s, timing.cpu_low, timing.cpu_high
    assert found == pytest.approx((9.0, *drifted(9.0, 9.0 * (5 / 9) ** wider, 9.0 * (13 / 9) ** wider)), rel=1e-4)


def test_a_wide_interval_a_restless_canary_and_too_few_samples_are_each_marked_unstable() -> None:
    wide = [dataclasses.replace(SAMPLE, cpu=cpu) for cpu in (0.3, 0.5, 0.7, 0.4, 0.6)]
    restless = [dataclasses.replace(SAMPLE, canary=canary) for canary in (0.001, 0.002, 0.001, 0.002, 0.003)]
    for samples in (wide, restless, [SAMPLE] * 2):
        assert summarise(TRIAL, samples).unstable_timing is True


def test_a_price_that_differs_between_two_processes_is_marked_unstable() -> None:
    """Five samples of each: the median is redrawn from one process or the other, so its interval spans both prices."""

    def dearer(factor: float) -> Timing:
        second = dataclasses.replace(SAMPLE, process=1, cpu=factor * SAMPLE.cpu)
        return summarise(TRIAL, [SAMPLE] * 5 + [second] * 5)

    wider = 2.2622 / 1.95996  # Student's t of nine degrees of freedom over the normal's percentile
    assert dearer(2.0).unstable_timing is True
    ends = drifted(0.75, 0.75 * (2 / 3) ** wider, 0.75 * (4 / 3) ** wider)
    assert (dearer(2.0).cpu_low, dearer(2.0).cpu_high) == pytest.approx(ends, rel=1e-4)
    # Half of 1.3 - 1 is 13 % of their middle, half of 1.1 - 1 is 5 %, and 15 % more each; a tenth is the line.
    assert dearer(1.3).unstable_timing is True
    assert dearer(1.1).unstable_timing is False
    # The whole of 1.15 - 1 would be over a tenth of 1.075, its half is not; half of 1.25 - 1 over 1.125 is 11 %.
    assert dearer(1.15).unstable_timing is False
    assert dearer(1.25).unstable_timing is True


def test_a_canary_that_moved_between_two_processes_marks_a_price_that_did_not() -> None:
    def moved(factor: float) -> Timing:
        second = dataclasses.replace(SAMPLE, process=1, canary=factor * SAMPLE.canary)
        return summarise(TRIAL, [SAMPLE] * 5 + [second] * 5)

    assert moved(2.0).unstable_timing is True
    assert moved(2.0).cpu_per_sim_s == 0.5
    assert moved(1.2).unstable_timing is True  # the middle half of the samples spans a fifth, over a middle of 1.1
    assert moved(1.05).unstable_timing is False


@pytest.mark.parametrize(("processes", "samples", "most"), [(3, 1, 0.05), (4, 2, 0.05), (3, 4, 0.06)])
def test_intervals_of_a_price_that_is_clocked_twice_overlap(
    processes: int, samples: int, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Processes differ by 2 % and samples in one by 1 %, without any drift. Of 1000 pairs a share of .05 is known to .007.

    The bootstrap alone, of samples drawn as if each were by itself, leaves a fifth of them apart.
    """
    monkeypatch.setattr("plumbline.harness.run.timing_protocol.DRIFT", 0.0)
    rng, apart = np.random.default_rng(5), 0
    for _ in range(1000):
        timings = []
        for _ in range(2):
            levels = 1.0 + rng.normal(0.0, 0.02, processes)[:, None] + rng.normal(0.0, 0.01, (processes, samples))
            taken = [
                dataclasses.replace(SAMPLE, process=p, block=b, cpu=float(levels[p, b]))
                for p in range(processes)
                for b in range(samples)
            ]
            timings.append(summarise(TRIAL, taken))
        low, high = (max(t.cpu_low or 0.0 for t in timings), min(t.cpu_high or 0.0 for t in timings))
        apart += low > high
    assert apart <= (most + 2 * 0.007) * 1000


def test_no_sample_is_said_and_not_made_up() -> None:
    timing = summarise(TRIAL, [], "process ended with exit code -11")
    assert timing.cpu_per_sim_s is None
    assert "exit code -11" in timing.note


def test_workers_share_their_cpu_time_and_wait_for_the_slowest() -> None:
    """Two of 100 steps each, 0.5 s of CPU time each, done after 1 and 1.25 s: 200 steps in 1.25 s."""
    late = dataclasses.replace(SAMPLE, wall=1.25, canary=0.0, switches=3)
    both = joined([SAMPLE, late])
    assert both == dataclasses.replace(SAMPLE, units=2, cpu=1.0, wall=1.25, switches=3)
    timing = summarise(dataclasses.replace(TRIAL, workers=2), [both] * 3)
    assert timing.cpu_per_unit == 0.5 / 100
    assert timing.cpu_per_sim_s is None
    assert joined([SAMPLE]) == SAMPLE


class Scripted(Clocked):
    """A child that answers from a list and notes what it is asked."""

    def __init__(self, name: str, answers: list[Sampling | Sample | str], told: list[tuple[str, str, object]]) -> None:
        self.name, self.answers, self.told, self.trouble = name, answers, told, ""

    def ask(self, number: int, block: int, sampling: Sampling) -> None:
        self.told.append((self.name, "asked", (number, block, sampling)))

    def answer(self, seconds: float) -> Sampling | Sample | str:
        message = self.answers.pop(0)
        self.told.append((self.name, "answered", message))
        return message


def test_workers_are_all_asked_for_the_same_steps_before_any_is_waited_for() -> None:
    told: list[tuple[str, str, object]] = []
    team = Team(TRIAL, [Scripted("a", [FORTY, SAMPLE], told), Scripted("b", [Sampling(60, 20), SAMPLE], told)])
    team.calibrated(1.0)
    told.clear()
    assert team.sample(3, 1.0) == dataclasses.replace(SAMPLE, units=2, cpu=1.0)
    assert [(name, what) for name, what, _ in told] == [("a", "asked"), ("b", "asked"), ("a", "answered"), ("b", "answered")]
    assert [content for _, what, content in told if what == "asked"] == [(0, 3, FORTY)] * 2


class Idle:
    """A bench on which nothing is stepped."""

    units, endless = 1, True

    def __init__(self, *of: object) -> None:
        pass

    def clock(self, count: int) -> tuple[float, float]:
        return count * 1e-3, count * 1e-3

    def stop(self) -> None:
        pass


@pytest.fixture
def idle_children(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Clocked]]:
    """Two children of one trial that start together, as threads of this process."""
    monkeypatch.setattr(clockwork, "plugins", SimpleNamespace(case=str, adapter=lambda _: SimpleNamespace(laws=())))
    monkeypatch.setattr(clockwork, "Bench", Idle)
    monkeypatch.setattr(clockwork, "confine", lambda *_: None)
    monkeypatch.setattr(clockwork, "end_started", lambda: None)
    monkeypatch.setattr(clockwork, "calibrate", lambda *_: FORTY)
    monkeypatch.setattr("gc.disable", lambda: None)
    children, threads = [], []
    for first in (True, False):
        ours, theirs = multiprocessing.Pipe()
        place = clockwork.ProcessPlace(None, first, together=True)
        threads.append(threading.Thread(target=clockwork._child, args=(theirs, [TRIAL], place, Path())))
        threads[-1].start()
        children.append(Clocked(SimpleNamespace(pid=0), UNWATCHED, Inbox(ours)))  # type: ignore[arg-type]
    yield children
    for child, thread in zip(children, threads, strict=True):
        with contextlib.suppress(BrokenPipeError):
            child.inbox.pipe.send(None)
        thread.join()


def test_no_worker_starts_before_all_are_there(idle_children: list[Clocked]) -> None:
    early, late = idle_children
    assert [child.answer(10.0) for child in idle_children] == [FORTY] * 2
    early.ask(0, 0, SEVEN)
    assert early.answer(10.0) == Ready()
    assert not early.inbox.pipe.poll(0.3)
    early.tell(True)
    alone = early.answer(10.0)
    assert isinstance(alone, Sample)
    assert (alone.block, alone.steps, alone.wall) == (0, 7, 0.007)
    both = Team(TRIAL, idle_children, sampling=SEVEN)
    sample = both.sample(3, 10.0)
    assert sample is not None
    assert (sample.block, sample.steps, sample.units, sample.cpu) == (3, 7, 2, 0.014)
    assert sample.canary > 0
    late.ask(0, 0, SEVEN)
    assert late.answer(10.0) == Ready()
    late.tell(True)
    assert cast(Sample, late.answer(10.0)).canary == 0.0


def test_a_worker_that_fails_does_not_keep_the_others_waiting(
    idle_children: list[Clocked], monkeypatch: pytest.MonkeyPatch
) -> None:
    sound, failing = idle_children
    team = Team(TRIAL, idle_children)
    team.calibrated(10.0)
    with monkeypatch.context() as patch:
        patch.setattr(Clocked, "ask", lambda child, *_: child.tell("no order" if child is failing else (0, 0, SEVEN)))
        assert team.sample(0, 10.0) is None
    assert team.trouble.startswith("ValueError")
    sound.ask(0, 1, SEVEN)  # it was not let go, and serves on
    assert sound.answer(10.0) == Ready()
    sound.tell(False)


def test_one_worker_in_trouble_is_the_trials_trouble_and_no_sample() -> None:
    team = Team(TRIAL, [Scripted("a", [FORTY, SAMPLE], []), Scripted("b", [FORTY, "MemoryError: no more"], [])])
    team.calibrated(1.0)
    assert team.sample(0, 1.0) is None
    assert team.trouble == "MemoryError: no more"


def test_a_child_that_died_while_it_waited_is_trouble_and_no_crash() -> None:
    with light_servers():
        process = start(Origin(), id)
        assert process.join(60.0)
        team = Team(TRIAL, [Clocked(process, UNWATCHED, Inbox(process.pipe))], sampling=FORTY)
        assert team.sample(0, 1.0) is None
        assert "exit code 0" in team.trouble
        team.stop()


def test_an_hour_that_comes_ends_the_wait_for_a_sample_and_names_its_trial(
    idle_children: list[Clocked], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody asks the child, which has a minute by itself."""
    team = Team(TRIAL, [idle_children[0]])
    team.calibrated(10.0)
    monkeypatch.setattr(Clocked, "ask", lambda *_: None)
    end = time.monotonic() + 0.2
    with until(lambda: end), pytest.raises(TimeIsUp) as up:
        team.sample(0, 60.0)
    (waiting,) = up.value.under_way
    assert waiting.trial == TRIAL
    assert 0.0 < waiting.seconds < 60.0


class Mortal(Clocked):
    """A child that serves several trials and dies of one."""

    def __init__(self, answers: list[Sampling | Sample | str]) -> None:
        self.answers, self.trouble, self.stopped = answers, "", False

    def ask(self, number: int, block: int, sampling: Sampling) -> None:
        pass

    def answer(self, seconds: float) -> Sampling | Sample | str:
        message = self.answers.pop(0)
        if message == "death":
            self.trouble = "process ended with exit code -11"
            return self.trouble
        return message

    def stop(self) -> None:
        self.stopped = True


def named(*names: str) -> list[Trial]:
    return [dataclasses.replace(TRIAL, trial=name) for name in names]


@pytest.fixture
def births(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """What was started, time after time: a child dies of the trial 'bad' when it should be ready for it."""
    started: list[list[str]] = []

    def start(trials: list[Trial], folder: Path, server: int, apart: bool) -> Iterator[Team]:
        started.append([trial.trial for trial in trials])
        child = Mortal([])
        for number, trial in enumerate(trials):
            child.answers.append("death" if trial.trial == "bad" else "MemoryError" if trial.trial == "hungry" else FORTY)
            yield Team(trial, [child], number)

    monkeypatch.setattr(clockwork, "_start", start)
    return started


def test_who_dies_of_a_trial_leaves_the_others_a_new_process(births: list[list[str]]) -> None:
    """Also those that were ready before; the culprit is told, once, and an exception costs nobody else anything."""
    teams = clockwork.ready_teams(named("good", "hungry", "bad", "late"), Path())
    assert births == [["good", "hungry", "bad", "late"], ["good", "late"]]
    assert {name: team.trouble for name, team in teams.items()} == {
        "good": "",
        "hungry": "MemoryError",
        "bad": "process ended with exit code -11",
        "late": "",
    }
    assert teams["good"].children == teams["late"].children
    assert not teams["good"].children[0].trouble


def test_a_death_in_a_sample_costs_its_own_trial_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The others of the same process give all their samples, from a new one."""
    asked: list[str] = []

    class Host(Mortal):
        served: list[str]
        now = ""

        def ask(self, number: int, block: int, sampling: Sampling) -> None:
            asked.append(self.served[number])
            self.answers.append("death" if self.served[number] == "bad" else dataclasses.replace(SAMPLE, block=block))

    def start(trials: list[Trial], folder: Path, server: int, apart: bool) -> Iterator[Team]:
        child = Host([FORTY] * len(trials))
        child.served = [trial.trial for trial in trials]
        yield from [Team(trial, [child], number) for number, trial in enumerate(trials)]

    monkeypatch.setattr(clockwork, "_start", start)
    monkeypatch.setattr(
        "plumbline.harness.run.timing_protocol.plugins", SimpleNamespace(case=lambda _: SimpleNamespace(unit=lambda *_: "step"))
    )
    experiment = Experiment(name="e", samples=4, processes=2)
    trials = [dataclasses.replace(trial, experiment=experiment) for trial in named("a", "bad", "c")]
    timings = {timing.trial: timing for timing in clock_group(trials, tmp_path, random.Random(1))}
    assert asked.count("bad") == 1
    assert timings["bad"].note == "process ended with exit code -11"
    assert [len(timings[name].samples) for name in ("a", "bad", "c")] == [8, 0, 8]
    assert not timings["a"].note


@pytest.mark.parametrize(("most", "processes", "given"), [(None, 4, 8), (3, 4, 3), (1, 4, 1), (3, 1, 2), (3, 2, 3), (9, 4, 8)])
def test_long_runs_take_fewer_samples_spread_over_the_processes(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, most: int | None, processes: int, given: int
) -> None:
    """Two are asked for in each process; another trial, of short runs, takes them all."""

    class Host(Mortal):
        def ask(self, number: int, block: int, sampling: Sampling) -> None:
            self.answers.append(dataclasses.replace(SAMPLE, block=block))

    def start(trials: list[Trial], folder: Path, server: int, apart: bool) -> Iterator[Team]:
        answers = [Sampling(40, 40, most) if trial.trial == "long" else FORTY for trial in trials]
        child = Host(list(answers))
        yield from [Team(trial, [child], number) for number, trial in enumerate(trials)]

    monkeypatch.setattr(clockwork, "_start", start)
    monkeypatch.setattr(
        "plumbline.harness.run.timing_protocol.plugins", SimpleNamespace(case=lambda _: SimpleNamespace(unit=lambda *_: "step"))
    )
    experiment = Experiment(name="e", samples=2, processes=processes)
    trials = [dataclasses.replace(trial, experiment=experiment) for trial in named("long", "short")]
    timings = {timing.trial: timing for timing in clock_group(trials, tmp_path, random.Random(1))}
    assert [len(timings[name].samples) for name in ("long", "short")] == [given, 2 * processes]
    assert len({s.process for s in timings["long"].samples}) == min(given, processes)
    assert {timing.clocked for timing in timings.values()} == {"whole runs"}


def test_what_the_samples_are_of_is_said() -> None:
    assert summarise(TRIAL, [SAMPLE]).clocked == "whole runs"
    assert summarise(TRIAL, [dataclasses.replace(SAMPLE, run=0)], unit="ray").clocked == "calls"
    assert summarise(TRIAL, [], "a whole run does not fit").clocked == "not clocked"


def test_questions_of_one_sitting_take_turns_process_by_process_and_their_samples_are_spread_over_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[str] = []

    class Host(Mortal):
        def ask(self, number: int, block: int, sampling: Sampling) -> None:
            asked.append(trials[number].trial)
            self.answers.append(dataclasses.replace(SAMPLE, block=block))

    def start(trials: list[Trial], folder: Path, server: int, apart: bool) -> Iterator[Team]:
        child = Host([FORTY] * len(trials))
        yield from [Team(trial, [child], number) for number, trial in enumerate(trials)]

    monkeypatch.setattr(clockwork, "_start", start)
    monkeypatch.setattr(
        "plumbline.harness.run.timing_protocol.plugins", SimpleNamespace(case=lambda _: SimpleNamespace(unit=lambda *_: "step"))
    )
    experiment = Experiment(name="e", samples=2, processes=3)
    names = ("a0", "a1", "b0", "b1")
    trials = [dataclasses.replace(TRIAL, trial=name, case=name[0], experiment=experiment) for name in names]
    said: list[str] = []
    timings = list(clock_group(trials, tmp_path, random.Random(1), said.append))
    assert [[(s.process, s.block) for s in timing.samples] for timing in timings] == [
        [(p, b) for p in range(3) for b in range(2)]
    ] * 4
    blocks = [asked[k : k + 2] for k in range(0, len(asked), 2)]
    assert all({name[0] for name in block} == {block[0][0]} and len(set(block)) == 2 for block in blocks)  # side by side
    assert [sorted(block[0][0] for block in blocks[k : k + 4]) for k in (0, 4, 8)] == [["a", "a", "b", "b"]] * 3
    assert len(said) == 6
