"""Is every planted change between two run folders told, with its size, and nothing else?"""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from plumbline.harness.cli.main import main
from plumbline.harness.findings.changes import Change, Changes, compare
from plumbline.harness.findings.changes.files import LONGEST_COMMENT, changes_files, comment
from plumbline.harness.findings.changes.values import ComparedRun, heaviest_first
from plumbline.harness.findings.changes.words import command, headline, sentence
from plumbline.harness.store.record import StoredNotice
from plumbline.harness.store.store import Store
from tests.two_runs import Planted, write_two_runs

CASES = ("flight_projectile", "joint_pendulum", "stack_tower")
FRICTION = ("friction_stop", "joint_pendulum")


def compared(folder: Path, planted: Planted | None = None, only: tuple[str, ...] = CASES, **machine: Any) -> Changes:
    return compare(*map(Store, write_two_runs(folder, planted, machine or None, only)))


def cells(trials: pd.DataFrame, case: str, engine: str) -> "pd.Series[bool]":
    return (trials["case"] == case) & (trials["engine"] == engine)


def other_bits(trials: pd.DataFrame, measurements: pd.DataFrame, case: str, engine: str, times: float) -> "pd.Series[bool]":
    """Trials of a case on an engine get another trajectory, and their headline so many times the value."""
    mine = cells(trials, case, engine)
    trials.loc[mine, "trajectory_hash"] = "0123456789abcdef"
    headline = measurements["at_most"].notna() & (measurements["metric"] != "energy_drift")
    measurements.loc[measurements["trial"].isin(trials.loc[mine, "trial"]) & headline, "value"] *= times
    return mine


def test_two_runs_of_the_same_say_nothing_though_the_machine_was_a_third_slower(tmp_path: Path) -> None:
    changes = compared(tmp_path)
    assert changes.rows == ()
    assert changes.matched == changes.a.trials == changes.b.trials
    assert changes.clocked > 100
    assert changes.titles["dart"] == "DART"
    assert changes.titles["stack_tower"] == "Tower of ten boxes"


def test_an_engine_that_takes_a_fifth_longer_is_told_by_trial_and_as_a_whole_over_the_other_engines(tmp_path: Path) -> None:
    def slower(trials: pd.DataFrame, _measurements: pd.DataFrame, samples: pd.DataFrame) -> None:
        mine = samples["trial"].isin(trials.loc[trials["engine"] == "reference", "trial"])
        samples.loc[mine, "cpu"] *= 1.2

    changes = compared(tmp_path, slower)
    assert {(row.kind, row.sense, row.engine, row.beside) for row in changes.rows} == {
        ("price", "worse", "reference", "other engines")
    }
    (whole,) = [row for row in changes.rows if not row.case]
    # The median of some hundred ratios, each of two medians of ten samples with 2 % noise: a spread of 1 % / 10 about.
    assert whole.ratio == pytest.approx(1.2, rel=0.01)
    assert whole.low is not None
    assert whole.high is not None
    assert whole.low < 1.2 < whole.high
    assert len(changes.rows) > 0.9 * whole.count
    bullets = [line for line in comment(changes).splitlines() if line.startswith("* ")]
    assert "as a whole" in bullets[0]


def test_what_delays_all_engines_at_a_question_alike_is_of_none_of_them_and_hides_none_that_is_slower(tmp_path: Path) -> None:
    busy = ("stack_tower", "joint_chain", "flight_projectile")

    def disturbed(trials: pd.DataFrame, _measurements: pd.DataFrame, samples: pd.DataFrame) -> None:
        for number, case in enumerate(busy):
            there = samples["trial"].isin(trials.loc[trials["case"] == case, "trial"])
            samples.loc[there, "cpu"] *= 1.4 + 0.2 * number

    assert compared(tmp_path / "busy", disturbed, ()).rows == ()

    def one_slower(trials: pd.DataFrame, measurements: pd.DataFrame, samples: pd.DataFrame) -> None:
        disturbed(trials, measurements, samples)
        samples.loc[samples["trial"].isin(trials.loc[cells(trials, busy[0], "bullet"), "trial"]), "cpu"] *= 1.3

    rows = compared(tmp_path / "slower", one_slower, ()).rows
    assert rows
    assert {(row.sense, row.case, row.engine) for row in rows} == {("worse", busy[0], "bullet")}
    # Two medians of ten samples with 2 % noise each.
    assert all(abs((row.ratio or 0) - 1.3) < 0.1 for row in rows)


def test_what_slows_all_engines_at_a_question_but_none_like_another_is_of_none_of_them(tmp_path: Path) -> None:
    """By how much each was slower in a night when other work filled the caches, and no engine had changed."""
    met = {
        "bullet": {"default": 1.85, "tuned": 1.42},
        "dart": {"default": 2.18, "tuned": 1.95},
        "mujoco": {"default": 1.45, "tuned": 1.49},
        "reference": {"default": 1.15, "tuned": 1.43},
    }

    def told(name: str, dart: float) -> set[tuple[str, str, str]]:
        def busy(trials: pd.DataFrame, _measurements: pd.DataFrame, samples: pd.DataFrame) -> None:
            for engine, tracks in met.items():
                for track, times in tracks.items():
                    mine = cells(trials, "stack_tower", engine) & (trials["track"] == track)
                    there = samples["trial"].isin(trials.loc[mine, "trial"])
                    samples.loc[there, "cpu"] *= times * (dart if engine == "dart" else 1.0)

        return {(row.sense, row.case, row.engine) for row in compared(tmp_path / name, busy).rows if row.kind == "price"}

    assert told("load", 1.0) == set()
    assert told("slower", 3.0) == {("worse", "stack_tower", "dart")}


def test_samples_that_fall_into_two_heaps_do_not_tell_what_their_median_seems_to(tmp_path: Path) -> None:
    """Every second sample 1.6 times as long: the median is 1.3 times as high, and by chance 1 or 1.6. All 1.3 times is told."""

    def told(name: str, every_second: float, every: float) -> set[tuple[str, str, str]]:
        def planted(trials: pd.DataFrame, _measurements: pd.DataFrame, samples: pd.DataFrame) -> None:
            there = samples["trial"].isin(trials.loc[cells(trials, "stack_tower", "dart"), "trial"])
            samples.loc[there & (samples["block"] % 2 == 1), "cpu"] *= every_second
            samples.loc[there, "cpu"] *= every

        return {(row.sense, row.case, row.engine) for row in compared(tmp_path / name, planted).rows if row.kind == "price"}

    assert told("heaps", 1.6, 1.0) == set()
    assert told("all", 1.0, 1.3) == {("worse", "stack_tower", "dart")}


def test_one_engine_alone_is_compared_over_the_canary(tmp_path: Path) -> None:
    folders = write_two_runs(tmp_path, only=CASES)
    for folder in folders:
        trials = pd.read_parquet(folder / "trials.parquet")
        trials[trials["engine"] == "dart"].to_parquet(folder / "trials.parquet", index=False)
    samples = pd.read_parquet(folders[1] / "samples.parquet")
    samples["cpu"] *= 1.5
    samples.to_parquet(folders[1] / "samples.parquet", index=False)
    trials = pd.read_parquet(folders[1] / "trials.parquet")
    trials["cpu_per_unit"] *= 1.5
    trials.to_parquet(folders[1] / "trials.parquet", index=False)
    rows = compare(*map(Store, folders)).rows
    assert rows
    assert {(row.kind, row.sense, row.beside) for row in rows} == {("price", "worse", "canary")}
    assert all(abs((row.ratio or 0) - 1.5) < 0.1 for row in rows)  # two medians of ten samples with 2 % noise each


def alone(folder: Path, load: float, *, most: int, seeds: int = 1, times: float = 1.0) -> Iterator[Changes]:
    """One engine in two runs, three samples for each of at most so many prices; in the second, load comes and goes: a canary of
    a millisecond meets it or not, a sample is long enough to meet half of it."""
    folders = write_two_runs(folder, only=CASES)
    trials, samples = ([pd.read_parquet(side / f"{name}.parquet") for side in folders] for name in ("trials", "samples"))
    asked = trials[0].loc[trials[0]["engine"] == "dart", "trial"].head(most)
    for side in folders:
        path = side / "measurements.parquet"
        pd.read_parquet(path, filters=[("trial", "in", [*asked])]).to_parquet(path, index=False)
    for seed in range(seeds):
        for number, side in enumerate(folders):
            mine = trials[number][trials[number]["engine"] == "dart"].head(most)
            few = samples[number][samples[number]["trial"].isin(mine["trial"]) & (samples[number]["block"] < 3)]
            met = np.random.default_rng(seed).uniform(0.0, load * number, len(few))
            slower = np.exp(load / 2) * times if number else 1.0
            few = few.assign(canary=few["canary"] * np.exp(met), cpu=few["cpu"] * slower)
            medians = (few["cpu"] / few["steps"]).groupby(few["trial"]).median()
            mine = mine.assign(cpu_per_unit=[medians.get(trial, np.nan) for trial in mine["trial"]], unstable_timing=False)
            mine.to_parquet(side / "trials.parquet", index=False)
            few.to_parquet(side / "samples.parquet", index=False)
        yield compare(*map(Store, folders))


@pytest.mark.parametrize("seeds", [3, pytest.param(10, marks=pytest.mark.slow)])
def test_load_that_swings_between_canary_and_sample_is_no_change_of_an_engine_alone(tmp_path: Path, seeds: int) -> None:
    """Up to a half slower. Of fewer than eight prices nothing says how far they stray but their samples."""
    for changes in alone(tmp_path, 0.4, most=6, seeds=seeds):
        assert [sentence(row) for row in changes.rows] == []


def test_an_engine_alone_that_takes_more_than_twice_as_long_is_told_through_such_load(tmp_path: Path) -> None:
    (changes,) = alone(tmp_path, 0.4, most=1000, times=2.5)
    assert {(row.kind, row.sense, row.beside) for row in changes.rows} == {("price", "worse", "canary")}
    (whole,) = [row for row in changes.rows if not row.case]
    assert whole.low is not None
    assert whole.high is not None
    assert 1.3 < whole.low < 2.5 < whole.high


def test_what_meets_a_question_of_one_engine_alone_is_not_of_that_engine_where_the_canary_saw_it(tmp_path: Path) -> None:
    """Half as slow again for one question that no other engine is asked; and three times, of which the canary saw half."""

    def told(name: str, seen: float, times: float) -> list[tuple[str, str, str]]:
        def planted(trials: pd.DataFrame, _measurements: pd.DataFrame, samples: pd.DataFrame) -> None:
            there = samples["trial"].isin(trials.loc[cells(trials, "stack_tower", "dart"), "trial"])
            samples.loc[there, "canary"] *= seen
            samples.loc[there, "cpu"] *= times

        folders = write_two_runs(tmp_path / name, planted, only=CASES)
        for side in folders:
            trials = pd.read_parquet(side / "trials.parquet")
            gone = (trials["case"] == "stack_tower") & (trials["engine"] != "dart")
            trials[~gone].to_parquet(side / "trials.parquet", index=False)
        return [(row.sense, row.case, row.engine) for row in compare(*map(Store, folders)).rows if row.kind == "price"]

    assert told("load", 1.5, 1.8) == []
    assert set(told("slower", 1.5, 3.0)) == {("worse", "stack_tower", "dart")}


def test_another_last_bit_is_no_change_for_the_worse_and_an_error_three_times_as_large_is(tmp_path: Path) -> None:
    def planted(trials: pd.DataFrame, measurements: pd.DataFrame, _samples: pd.DataFrame) -> None:
        other_bits(trials, measurements, "joint_pendulum", "mujoco", 1 + 1e-12)
        other_bits(trials, measurements, "friction_stop", "mujoco", 3.0)

    changes = compared(tmp_path, planted, FRICTION)
    assert {(row.kind, row.sense, row.case) for row in changes.rows if row.kind == "error"} == {
        ("error", "within tolerance", "joint_pendulum"),
        ("error", "worse", "friction_stop"),
    }
    worse = [row for row in changes.rows if row.sense == "worse"]
    assert all(row.ratio == pytest.approx(3) for row in worse)
    assert changes.rows[: len(worse)] == tuple(worse)
    # No price of such an engine is a yardstick any more; the others' are.
    assert not [row for row in changes.rows if row.kind == "price"]


def test_a_verdict_that_flips_is_said_first_and_bars_the_gate_of_its_engine_alone(tmp_path: Path) -> None:
    def planted(trials: pd.DataFrame, measurements: pd.DataFrame, _samples: pd.DataFrame) -> None:
        mine = other_bits(trials, measurements, "joint_pendulum", "dart", 500.0) & (trials["status"] == "passed")
        trials.loc[mine, ["status", "reason"]] = ["failed", "angle_error above its bound"]

    changes = compared(tmp_path, planted, ("joint_pendulum",))
    first = changes.rows[0]
    assert (first.kind, first.sense, first.before, first.after) == ("verdict", "worse", "passed", "failed")
    assert changes.regressions(["dart"])
    assert not changes.regressions(["mujoco", "bullet"])
    folders = str(tmp_path / "a"), str(tmp_path / "b")
    for gate, code in ((["--gate", "dart"], 1), (["--gate", "mujoco"], 0), ([], 0), (["--gate", "dar"], 2)):
        assert CliRunner().invoke(main, ["diff", *folders, *gate]).exit_code == code
    said = CliRunner().invoke(main, ["diff", *folders, "--format", "json"]).stdout
    assert json.loads(said)[0]["command"] == f"plumbline reproduce {folders[1]} {first.trial_b}"


def test_the_same_bits_that_are_measured_otherwise_are_no_fault_of_the_engine(tmp_path: Path) -> None:
    def planted(trials: pd.DataFrame, measurements: pd.DataFrame, _samples: pd.DataFrame) -> None:
        mine = other_bits(trials, measurements, "joint_pendulum", "bullet", 2.0)
        trials.loc[mine, "trajectory_hash"] = trials.loc[mine, "trial"]

    errors = [row for row in compared(tmp_path, planted).rows if row.kind == "error"]
    assert errors
    assert {row.sense for row in errors} == {"neither"}


def test_a_truth_that_is_known_to_less_than_the_change_makes_no_change(tmp_path: Path) -> None:
    def planted(trials: pd.DataFrame, measurements: pd.DataFrame, _samples: pd.DataFrame) -> None:
        mine = other_bits(trials, measurements, "rest_table", "mujoco", 1.5)
        measurements.loc[measurements["trial"].isin(trials.loc[mine, "trial"]), "truth_error"] = 1.0

    assert {row.sense for row in compared(tmp_path, planted, ("rest_table",)).rows} == {"within tolerance"}


def test_versions_sources_machine_and_trials_that_came_or_went_are_facts(tmp_path: Path) -> None:
    def planted(trials: pd.DataFrame, _measurements: pd.DataFrame, _samples: pd.DataFrame) -> None:
        trials.loc[trials["engine"] == "dart", ["engine_version", "sources"]] = ["2.0.0", '{"adapter": "1111"}']
        trials.loc[cells(trials, "rest_table", "bullet"), "case"] = "rest_elsewhere"

    rows = compared(tmp_path, planted, ("joint_pendulum", "rest_table"), processor="Another CPU").rows
    assert {(row.kind, row.sense, row.engine) for row in rows} == {
        ("version", "neither", "dart"),
        ("sources", "neither", "dart"),
        ("machine", "neither", ""),
        ("trials", "neither", "bullet"),
    }
    counts = {row.case: (row.before, row.after) for row in rows if row.kind == "trials" and row.track == "default"}
    assert counts == {"rest_table": (6.0, 0.0), "rest_elsewhere": (0.0, 6.0)}
    assert all(sentence(row).endswith(".") for row in rows)


def many(count: int) -> Changes:
    """So many verdicts that flipped, with long reasons."""
    rows = [
        Change(kind="verdict", sense="worse", case=f"case_{n}|<b>", engine="dart", track="tuned", dt=0.01, trial_b=f"{n:016x}",
               before="passed", after="failed", detail="x" * 1900)
        for n in range(count)
    ]  # fmt: skip
    side = ComparedRun(folder="a b", study="quick", started="", machine="", trials=count, versions=())
    return Changes(a=side, b=side, rows=heaviest_first(rows), matched=count, same=0, clocked=0)


def test_a_summary_of_a_thousand_changes_fits_a_comment(tmp_path: Path) -> None:
    text = comment(many(1000), ["dart"])
    assert len(text) <= LONGEST_COMMENT
    assert "1000 regressions" in text
    assert "<b>" not in text
    assert command(many(1).rows[0], many(1)) == "plumbline reproduce 'a b' 0000000000000000"


def test_the_files_say_the_same_to_build_servers_and_trackers(tmp_path: Path) -> None:
    def planted(trials: pd.DataFrame, measurements: pd.DataFrame, _samples: pd.DataFrame) -> None:
        other_bits(trials, measurements, "friction_stop", "mujoco", 3.0)

    folders = write_two_runs(tmp_path, planted, only=FRICTION)
    stores = [Store(folder) for folder in folders]
    changes = compare(*stores)
    files = changes_files(changes, stores[1], ["mujoco"])
    root = ElementTree.fromstring(files["junit.xml"])
    (suite,) = root
    tests = suite.findall("testcase")
    asked = stores[1].trials.groupby(["case", "engine"]).ngroups
    assert (root.tag, suite.tag, len(tests), int(suite.attrib["tests"])) == ("testsuites", "testsuite", asked, asked)
    assert root.attrib.keys() == {"name", "tests", "failures", "errors", "time"}  # what junit-10.xsd of Jenkins allows there
    assert len({(test.attrib["classname"], test.attrib["name"]) for test in tests}) == asked
    assert [test.attrib["name"] for test in tests if test.find("failure") is not None] == ["friction_stop"]
    assert int(suite.attrib["failures"]) == 1
    assert int(suite.attrib["skipped"]) == sum(test.find("skipped") is not None for test in tests) > 0
    results = json.loads(files["asv.json"])
    assert results["version"] == 2
    for name, row in results["results"].items():
        values, axes = row[0], row[1]
        assert len(values) == np.prod([len(axis) for axis in axes]), name
        assert len(row) <= len(results["result_columns"])
    metrics = json.loads(files["bencher.json"])
    prices = stores[1].trials["cpu_per_unit"].notna().sum()
    assert sum("latency" in one for one in metrics.values()) == prices  # no trial stands in the place of another
    assert {measure for one in metrics.values() for measure in one} == {"latency", "error"}
    for one in metrics.values():
        for figure in one.values():
            assert figure["lower_value"] <= figure["value"] <= figure["upper_value"]
    badge = ElementTree.fromstring(files["badge.svg"])
    title = badge.find("{http://www.w3.org/2000/svg}title")
    assert title is not None
    assert title.text == f"plumbline: {len(changes.regressions(['mujoco']))} worse"


def test_a_warning_that_came_or_went_is_told_apart_from_one_in_other_words(tmp_path: Path) -> None:
    a, b = map(Store, write_two_runs(tmp_path, only=("flight_projectile",)))
    trial = str(a.trials.loc[cells(a.trials, "flight_projectile", "bullet"), "trial"].iloc[0])
    damped, turned, friction = (
        StoredNotice(text, "surplus", effect)
        for text, effect in (
            ("angular_damping, by default", "angular_damping"), ("gyroscopic terms", "gyroscopic"), ("friction", "friction"),
        )
    )  # fmt: skip
    reworded = replace(damped, text="angular damping, by the vendor's default")
    vars(a)["notices"], vars(b)["notices"] = {trial: (damped, turned)}, {trial: (reworded, friction)}
    changes = compare(a, b)
    assert {(row.sense, row.before, row.after, row.detail) for row in changes.rows if row.kind == "warning"} == {
        ("neither", "angular_damping", "angular_damping", reworded.text),
        ("better", "gyroscopic", None, turned.text),
        ("worse", None, "friction", friction.text),
    }
    assert headline(changes).startswith("1 thing worse, 1 better, 0 changed")
    said = [sentence(row) for row in changes.rows]
    assert [sum(words in line for line in said) for words in ("warns anew", "warns no more", "warns in other words")] == [
        1,
        1,
        1,
    ]
    assert not changes.regressions(("bullet",))
