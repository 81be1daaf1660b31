"""The clock: its statistics are what they claim on samples whose answer is known; no time is asserted."""

import dataclasses
import multiprocessing

from harness.adapter import Settings
from harness.clock import Clocked, summarise
from harness.record import Sample, Timing
from harness.study import Experiment, Trial

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
SAMPLE = Sample(process=0, block=0, steps=100, cpu=0.5, wall=1.0, canary=0.001, switches=0)


def test_the_median_is_taken_per_simulated_second() -> None:
    samples = [dataclasses.replace(SAMPLE, cpu=cpu) for cpu in (0.5, 0.50001, 0.49999, 0.5, 9.0)]
    timing = summarise(TRIAL, samples)
    assert timing.cpu_per_sim_s == 0.5  # 100 steps of 0.01 s are one simulated second
    assert timing.wall_per_sim_s == 1.0
    assert timing.realtime_factor == 1.0


def test_equal_samples_have_an_interval_of_no_width_and_are_stable() -> None:
    timing = summarise(TRIAL, [SAMPLE] * 5)
    assert (timing.cpu_low, timing.cpu_high) == (0.5, 0.5)
    assert timing.unstable_timing is False


def test_the_interval_covers_the_median() -> None:
    timing = summarise(TRIAL, [dataclasses.replace(SAMPLE, cpu=0.5 + 0.001 * k) for k in range(9)])
    assert timing.cpu_low is not None
    assert timing.cpu_high is not None
    assert timing.cpu_low < 0.504 == timing.cpu_per_sim_s < timing.cpu_high
    assert timing.unstable_timing is False


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

    assert dearer(2.0).unstable_timing is True
    assert (dearer(2.0).cpu_low, dearer(2.0).cpu_high) == (0.5, 1.0)
    # Half of 1.3 - 1 is 13 % of their middle, half of 1.1 - 1 is 5 %; a tenth is the line.
    assert dearer(1.3).unstable_timing is True
    assert dearer(1.1).unstable_timing is False


def test_a_canary_that_moved_between_two_processes_marks_a_price_that_did_not() -> None:
    def moved(factor: float) -> Timing:
        second = dataclasses.replace(SAMPLE, process=1, canary=factor * SAMPLE.canary)
        return summarise(TRIAL, [SAMPLE] * 5 + [second] * 5)

    assert moved(2.0).unstable_timing is True
    assert moved(2.0).cpu_per_sim_s == 0.5
    assert moved(1.2).unstable_timing is True  # the middle half of the samples spans a fifth, over a middle of 1.1
    assert moved(1.05).unstable_timing is False


def test_no_sample_is_said_and_not_made_up() -> None:
    timing = summarise(TRIAL, [], "process ended with exit code -11")
    assert timing.cpu_per_sim_s is None
    assert "exit code -11" in timing.note


def test_a_child_that_died_while_it_waited_is_trouble_and_no_crash() -> None:
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=int)
    process.start()
    process.join()
    theirs.close()
    child = Clocked(TRIAL, process, ours)
    assert child.sample(0, 1.0) is None
    assert "exit code 0" in child.trouble
    child.stop()
