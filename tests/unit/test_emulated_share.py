"""The share of a price that is the adapter's own work, on a stand-in engine whose clock goes by what it does."""

import time
from dataclasses import replace
from typing import Any

import pytest

from plumbline.harness.adapter import Settings
from plumbline.harness.findings.emulations import share_in_words
from plumbline.harness.run.timing_protocol import summarise
from plumbline.harness.store.record import Sample
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.bench import Bench
from plumbline.harness.trial.emulated_share import emulated_share, stopwatch

LAW, PART, ENGINE = 0.003, 0.002, 0.001
"""What the stand-in takes in a step [s]: its law, of which PART in a law that it calls, and the rest."""
HERE = f"{__name__}:Standing"
LAWS = (f"{HERE}.law", f"{HERE}.part")


class Standing:
    """A simulation whose law is the adapter's; the clock is what its calls take."""

    now = 0.0
    built = 0

    def step(self, count: int = 1) -> None:
        for _ in range(count):
            self.law()
            Standing.now += ENGINE

    def law(self) -> None:
        Standing.now += LAW - PART
        self.part()

    def part(self) -> None:
        Standing.now += PART

    def close(self) -> None:
        pass


class Maker:
    """Its adapter; building takes long, and is outside of every share."""

    def build(self, scene: object, settings: object) -> Standing:
        Standing.now += 10.0
        Standing.built += 1
        return Standing()


CASE = plugins.case("flight_box")
TRIAL = Trial(
    trial="t", study="s", experiment=Experiment(name="e"), case=CASE.name, parameters=dict(CASE.parameters), engine="x",
    engine_version="1", track="tuned", settings=Settings(dt=1 / 240), seed=0, clocks="work",
)  # fmt: skip


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    monkeypatch.setattr(time, "process_time", lambda: Standing.now)
    monkeypatch.setattr(Standing, "built", 0)
    maker: Any = Maker()
    return Bench(CASE, maker, TRIAL)


def test_the_share_is_that_of_the_laws_over_a_whole_run_and_counts_none_twice(bench: Bench) -> None:
    assert emulated_share(bench, LAWS, seconds=1e9) == pytest.approx(LAW / (LAW + ENGINE))
    assert Standing.built == 1
    assert emulated_share(bench, LAWS[1:], seconds=1e9) == pytest.approx(PART / (LAW + ENGINE))


def test_an_adapter_without_laws_has_no_share_and_is_not_even_built(bench: Bench) -> None:
    assert emulated_share(bench, (), seconds=1.0) == 0.0
    assert Standing.built == 0


def test_a_long_run_is_measured_over_its_beginning(bench: Bench) -> None:
    begun = Standing.now
    assert emulated_share(bench, LAWS, seconds=4 * (LAW + ENGINE)) == pytest.approx(LAW / (LAW + ENGINE))
    # One step, two, four: the first that reach as far.
    assert Standing.now - begun == pytest.approx(10.0 + 7 * (LAW + ENGINE))


def test_laws_that_a_scene_does_not_call_are_known_after_one_step(bench: Bench) -> None:
    begun = Standing.now
    assert emulated_share(bench, (f"{__name__}:Maker.build",), seconds=1e9) == 0.0
    assert Standing.now - begun == pytest.approx(10.0 + LAW + ENGINE)


def test_the_functions_are_themselves_again_afterwards() -> None:
    kept = Standing.law, Standing.part
    with pytest.raises(AttributeError, match="gone"), stopwatch((*LAWS, f"{HERE}.gone")):
        pass
    assert (Standing.law, Standing.part) == kept


@pytest.mark.parametrize("engine", ["dart", "bullet", "mujoco", "reference"])
def test_the_laws_that_an_adapter_names_are_there(engine: str) -> None:
    laws = plugins.adapter(engine).laws
    try:
        with stopwatch(laws) as spent:
            assert spent.calls == 0
    except ModuleNotFoundError as error:
        pytest.skip(f"{engine} is not installed: {error}")


def test_a_timing_tells_the_share_of_its_samples_and_words_say_what_is_more_than_a_tenth() -> None:
    sample = Sample(process=0, block=0, steps=10, cpu=1.0, wall=1.0, canary=1.0, switches=0, run=10)
    timing = summarise(TRIAL, [replace(sample, emulated=share) for share in (0.7, 0.74, 0.9)])
    assert timing.emulated == 0.74
    assert share_in_words(timing.emulated) == "74 % is the adapter's own"
    # Folders of older versions say nothing of it.
    assert summarise(TRIAL, [sample] * 3).emulated is None
    assert {share_in_words(share) for share in (None, float("nan"), 0.0, 0.1)} == {""}
