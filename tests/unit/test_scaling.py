"""The scaling table on run folders made by formula: prices, ratios, quality and exponents are what they were made to be."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.harness.findings.tables.scaling import TABLE, TELLING, Cost, Scaling, no_worse
from plumbline.harness.statistics.bootstrap import ratio
from plumbline.harness.store.journal import Journal
from plumbline.harness.store.record import Measurement, Record, Sample, Timing
from plumbline.harness.store.store import Store, write_json

SIZES = (10, 100, 1000, 10_000)
EXPONENT = 1.25


def record(engine: str, track: str, n: int, penetration: float, status: str = "passed") -> Record:
    found = (
        Measurement(metric="overlap", value=penetration, unit="m"),
        Measurement(metric="rms_speed", value=1e-4, unit="m/s"),
    )
    return Record(
        trial=f"{engine}-{track}-{n}",
        study="s",
        experiment="e",
        case="stack_pile",
        parameters={"n": n, "worlds": 1},
        engine=engine,
        engine_version="1",
        track=track,
        dt=1 / 240,
        settings={},
        status=status,  # type: ignore[arg-type]
        reason="it took too long" if status == "timeout" else "",
        measurements=found if status != "timeout" else (),
    )


def timing(engine: str, track: str, n: int, cpu: float, noise: tuple[float, ...] = (1.0, 1.1, 0.9, 1.3, 1.0)) -> Timing:
    """Five blocks whose common noise is the machine's."""
    samples = tuple(
        Sample(process=0, block=k, steps=10, units=2, cpu=20 * cpu * shake, wall=1.0, canary=1e-3, switches=0)
        for k, shake in enumerate(noise)
    )
    return Timing(
        trial=f"{engine}-{track}-{n}", unit="step", cpu_per_unit=cpu, cpu_per_unit_low=0.9 * cpu, cpu_per_unit_high=1.3 * cpu,
        unstable_timing=False, samples=samples,
    )  # fmt: skip


@pytest.fixture
def scaling(tmp_path: Path) -> Scaling:
    journal = Journal(tmp_path)
    for n in SIZES:
        price = 1e-6 * n**EXPONENT
        for engine, track, cpu, depth in (
            ("ours", "fine", 3 * price, 1e-5),
            ("ours", "coarse", price, 1e-4),
            ("theirs", "default", 2 * price, 5e-5),
            ("theirs", "deep", 0.5 * price, 1e-2),
        ):
            failed = track == "deep"
            journal.append(record(engine, track, n, depth, "failed" if failed else "passed"))
            journal.append(timing(engine, track, n, cpu))
        journal.append(record("slow", "default", n, 0.0, "timeout"))
    journal.close()
    catalogue = {
        "cases": {"stack_pile": {"parameters": {"n": 100, "worlds": 1}, "headline": "overlap", "title": "Pile"}},
        "engines": {name: {"name": name, "ours": name == "ours", "title": name} for name in ("ours", "theirs", "slow")},
    }
    write_json(tmp_path / "catalogue.json", catalogue)
    return Scaling(Store(tmp_path))


def at(scaling: Scaling, n: int, engine: str, track: str) -> Cost:
    (found,) = [r for r in scaling.costs if (r.parameters["n"], r.engine, r.track) == (n, engine, track)]
    return found


def test_noise_that_both_share_cancels_in_a_ratio_and_noise_of_one_widens_it() -> None:
    shake = np.array([1.0, 2.0, 0.5, 1.5, 3.0])
    same = ratio(2 * shake, shake)
    assert (same.value, same.low, same.high) == (2.0, 2.0, 2.0)
    alone = ratio(2 * shake, np.ones(5))
    assert alone.ends[0] < alone.value < alone.ends[1]


def test_the_fastest_is_the_fastest_whose_checks_hold(scaling: Scaling) -> None:
    assert at(scaling, 100, "ours", "coarse").best
    assert not at(scaling, 100, "ours", "fine").best
    assert not at(scaling, 100, "theirs", "deep").best
    fast = at(scaling, 100, "theirs", "deep").to_fastest
    assert fast is not None
    assert fast.value == pytest.approx(0.25)
    assert at(scaling, 100, "theirs", "default").to_fastest.value == 1.0  # type: ignore[union-attr]


def test_the_reference_engine_is_a_line_beside_and_never_what_a_price_is_divided_by(scaling: Scaling) -> None:
    """Its coarse setting takes half of what the fastest takes that people can deploy."""
    assert at(scaling, 100, "ours", "coarse").to_fastest.value == pytest.approx(0.5)  # type: ignore[union-attr]


def test_a_rival_is_compared_with_our_fastest_that_is_no_worse(scaling: Scaling) -> None:
    shallow, deep = at(scaling, 100, "theirs", "default"), at(scaling, 100, "theirs", "deep")
    assert (shallow.reference_setting, deep.reference_setting) == ("fine", "coarse")  # coarse stands deeper than shallow
    assert shallow.reference is not None
    assert shallow.reference.value == pytest.approx(3 / 2)
    assert deep.reference is not None
    assert deep.reference.value == pytest.approx(2.0)


def test_what_did_not_finish_is_a_row_with_its_reason(scaling: Scaling) -> None:
    row = at(scaling, 10_000, "slow", "default")
    assert row.cpu is None
    assert row.to_fastest is None
    assert (row.status, row.reason) == ("timeout", "it took too long")


def test_rows_stand_by_size_and_name_what_was_swept(scaling: Scaling) -> None:
    assert list(dict.fromkeys(row.where for row in scaling.costs)) == [f"{n} balls" for n in SIZES]


def test_the_exponent_is_the_one_that_the_prices_were_made_with(scaling: Scaling) -> None:
    assert {(fit.engine, fit.track) for fit in scaling.exponents} == {
        ("ours", "fine"), ("ours", "coarse"), ("theirs", "default"), ("theirs", "deep"),
    }  # fmt: skip
    for exponent in scaling.exponents:
        fit = exponent.fit
        assert fit.order == pytest.approx(EXPONENT, abs=1e-9)
        assert fit.low <= fit.order <= fit.high
        assert (exponent.sweep.parameter, fit.fine, fit.coarse) == ("n", pytest.approx(10), pytest.approx(10_000))


def beside_trial(
    journal: Journal, clocks: str, workers: int, n: int, cpu: float, wall: float, experiment: str = "beside"
) -> None:
    """Five blocks of 100 steps by each worker, `cpu` [s] of each step, all done after 100 `wall`, under common noise."""
    name = f"{experiment}-{clocks}-{workers}-{n}"
    plain = record("ours", "fine", n, 1e-5)
    journal.append(replace(plain, trial=name, experiment=experiment, clocks=clocks, workers=workers))
    unit = {"work": "step", "reading": "read-step", "call": "call"}[clocks]
    samples = tuple(
        Sample(process=0, block=k, steps=100, units=workers, cpu=100 * workers * cpu * shake, wall=100 * wall * shake,
               canary=1e-3, switches=0)
        for k, shake in enumerate((1.0, 1.1, 0.9, 1.3, 1.0))
    )  # fmt: skip
    journal.append(
        Timing(trial=name, unit=unit, cpu_per_unit=cpu, cpu_per_unit_low=cpu, cpu_per_unit_high=cpu, samples=samples)
    )


@pytest.fixture
def beside(tmp_path: Path) -> Scaling:
    """Reading adds a fifth to a step and a call costs a tenth of it; two processes lose nothing, four share two cores."""
    journal = Journal(tmp_path)
    for n, cpu in ((10, 1e-5), (20, 2e-5)):
        for clocks, share in (("work", 1.0), ("reading", 1.2), ("call", 0.1)):
            beside_trial(journal, clocks, 1, n, share * cpu, share * cpu)
    for workers, wall in ((1, 1e-5), (2, 1e-5), (4, 2e-5)):
        beside_trial(journal, "work", workers, 10, 1e-5, wall, "shared")
    journal.close()
    catalogue = {
        "cases": {"stack_pile": {"parameters": {"n": 100, "worlds": 1}, "headline": "overlap", "title": "Pile"}},
        "engines": {"ours": {"name": "ours", "ours": True, "title": "ours"}},
    }
    write_json(tmp_path / "catalogue.json", catalogue)
    return Scaling(Store(tmp_path))


def test_reading_and_calling_stand_over_the_plain_step_of_the_same_scene(beside: Scaling) -> None:
    found = {row.where: row.to_plain for row in beside.costs if row.clocks != "work"}
    assert found.keys() == {f"{n} balls, {what}" for n in (10, 20) for what in ("step and reading", "empty call")}
    for where, over in found.items():
        assert over is not None
        # The noise is common, so nothing is left of it.
        assert (over.low, over.high) == pytest.approx((over.value, over.value))
        assert over.value == pytest.approx(1.2 if "reading" in where else 0.1)
    assert all(row.to_plain is None for row in beside.costs if row.clocks == "work")


def test_what_stands_beside_the_work_is_nobodys_best_and_no_sweep(beside: Scaling) -> None:
    assert not any(row.best or row.to_fastest or row.reference for row in beside.costs)
    assert beside.sweeps == ()


def test_efficiency_is_the_rate_of_all_over_as_many_times_the_rate_of_one(beside: Scaling) -> None:
    shared = {row.workers: row for row in beside.costs if row.efficiency is not None}
    assert {workers: row.where for workers, row in shared.items()} == {
        k: f"10 balls, {k} process{'es' * (k > 1)}" for k in (1, 2, 4)
    }
    for workers, efficiency in ((1, 1.0), (2, 1.0), (4, 0.5)):
        row = shared[workers]
        assert row.efficiency is not None
        assert row.efficiency.value == pytest.approx(efficiency)
        assert row.efficiency.ends[0] <= row.efficiency.value * (1 + 1e-12)
        assert row.rate == pytest.approx(efficiency * workers * 1e5)
        assert row.units == 1
        assert row.cpu is not None
        assert row.cpu.value == pytest.approx(1e-5)
    short = [" ".join(map(str, TABLE.brief(row))) for row in beside.rows]
    assert any("200,000 a second, efficiency 0.50" in line for line in short)
    assert any("1.2 x the step alone" in line for line in short)


@pytest.mark.parametrize(
    ("case", "name", "unit", "told"),
    [("system_rays", "thin", "ray", ("cast", "rays")), ("stack_pile", "worlds", "world-step", ("batch-step", "worlds"))],
)
def test_rays_and_worlds_are_priced_all_together_over_their_number(
    tmp_path: Path, case: str, name: str, unit: str, told: tuple[str, str]
) -> None:
    """A price of count^0.8 for all of them is count^-0.2 for each, which the exponent must not show."""
    journal = Journal(tmp_path)
    for count in (512, 4096, 32_768):
        each = 1e-6 * count**-0.2
        value = 32_768 / count if name == "thin" else count
        journal.append(replace(record("ours", "fine", 1, 1e-5), case=case, parameters={name: value}, trial=f"t{count}"))
        sample = Sample(process=0, block=0, steps=10, units=count, cpu=10 * count * each, wall=1.0, canary=1e-3, switches=0)
        prices = {"cpu_per_unit": each, "cpu_per_unit_low": each, "cpu_per_unit_high": each}
        journal.append(Timing(trial=f"t{count}", unit=unit, samples=(sample,), **prices))
    journal.close()
    write_json(tmp_path / "catalogue.json", {"cases": {}, "engines": {}})
    scaling = Scaling(Store(tmp_path))
    (exponent,) = scaling.exponents
    assert exponent.fit.order == pytest.approx(0.8, abs=1e-9)
    assert (exponent.sweep.unit, exponent.sweep.parameter) == told
    assert (exponent.fit.fine, exponent.fit.coarse) == pytest.approx((512, 32_768))
    assert {row.unit for row in scaling.costs} == {unit}  # the rows themselves go on pricing one


@pytest.fixture
def scattered(tmp_path: Path) -> Scaling:
    """Three sizes: ours costs n^1.25 to the digit, the others stray from that at the middle one.

    A logarithm off by s there leaves residuals of -s/3, 2s/3 and -s/3, so that the slope over two decades has a standard error
    of s/(sqrt(3) ln 10), and an interval that is 6.4 s wide: a factor of 1.17 makes it 1."""
    journal = Journal(tmp_path)
    for n in SIZES[:3]:
        for engine, stray in (("ours", 1.0), ("near", 1.1), ("theirs", 1.5)):
            journal.append(record(engine, "default", n, 1e-5))
            journal.append(timing(engine, "default", n, 1e-6 * n**EXPONENT * (stray if n == SIZES[1] else 1.0)))
    journal.close()
    catalogue = {
        "cases": {"stack_pile": {"parameters": {"n": 100, "worlds": 1}, "headline": "overlap", "title": "Pile"}},
        "engines": {name: {"name": name, "ours": name == "ours", "title": name} for name in ("ours", "near", "theirs")},
    }
    write_json(tmp_path / "catalogue.json", catalogue)
    return Scaling(Store(tmp_path))


def test_an_exponent_that_does_not_tell_linear_from_quadratic_growth_is_not_stated(scattered: Scaling) -> None:
    widths = {fit.engine: fit.fit.high - fit.fit.low for fit in scattered.exponents}
    assert widths["ours"] == pytest.approx(0, abs=1e-9)
    for engine, stray in (("near", 1.1), ("theirs", 1.5)):
        assert widths[engine] == pytest.approx(2 * 12.706 * np.log(stray) / (np.sqrt(3) * np.log(10)), rel=1e-3)
    assert widths["near"] < TELLING < widths["theirs"]
    assert {fit.engine: fit.telling for fit in scattered.exponents} == {"ours": True, "near": True, "theirs": False}
    rows = {row["engine"]: row for row in map(TABLE.flat, scattered.rows) if row["row"] == "exponent"}
    assert rows["ours"]["exponent"] == pytest.approx(EXPONENT)
    assert rows["theirs"]["exponent"] is None
    assert rows["theirs"]["exponent_low"] < EXPONENT < rows["theirs"]["exponent_high"]
    assert TABLE.brief(next(fit for fit in scattered.exponents if fit.engine == "theirs"))[4].startswith("exponent not known (")


def test_flat_rows_have_all_columns_and_short_words(scaling: Scaling) -> None:
    rows = [*map(TABLE.flat, scaling.rows)]
    assert all(tuple(row) == TABLE.columns for row in rows)
    assert [row["row"] for row in rows].count("exponent") == 4
    short = [TABLE.brief(row) for row in scaling.rows]
    assert any(cell == "timeout: it took too long" for line in short for cell in line)
    assert any("exponent 1.25" in line[4] for line in short)


def cost(**values: Any) -> Cost:
    empty: dict[str, Any] = dict.fromkeys(Cost.__dataclass_fields__)
    return Cost(**(empty | values))


@pytest.mark.parametrize(
    ("own", "other", "answer"),
    [
        ({"penetration": 1e-4, "residual": 1e-4}, {"penetration": 1e-4, "residual": 1e-4}, True),
        ({"penetration": 2e-4, "residual": 1e-4}, {"penetration": 1e-4, "residual": 1e-4}, False),
        ({"penetration": 1e-4, "residual": 2e-4}, {"penetration": 1e-4, "residual": 1e-4}, False),
        ({"penetration": 9e-7, "residual": 9e-6}, {"penetration": 0.0, "residual": 0.0}, True),
        ({"penetration": None, "residual": 0.0}, {"penetration": 1e-4, "residual": 1e-4}, False),
        ({"error": 0.1}, {"error": 0.2}, True),
        ({"error": 0.2}, {"error": 0.1}, False),
        ({"error": 0.2}, {}, False),
    ],
)
def test_no_worse_means_in_every_respect_that_is_known(own: dict[str, Any], other: dict[str, Any], answer: bool) -> None:
    assert no_worse(cost(**own), cost(**other)) is answer
