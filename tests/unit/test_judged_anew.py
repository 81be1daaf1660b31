"""A kept answer that is judged anew gives the record of a fresh run, bit for bit; a damaged one is not judged."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.case.alteration import Alteration
from plumbline.harness.metrics.errors import position_error_max
from plumbline.harness.store.record import Record, StoredNotice, from_plain, plain
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial import accuracy
from plumbline.harness.trial.accuracy import judged_anew, run_trial
from tests.conftest import PLUGINS
from tests.needs import BULLET

RUNS: dict[str, tuple[str, str, dict[str, Any], dict[str, Any]]] = {
    "closed form": ("flight_projectile", "mujoco", {}, {}),
    "a force from outside": ("orbit_kepler", "bullet", {}, {}),
    "contacts": ("stack_tower", "mujoco", {}, {}),
    "impulses of every step": ("stack_heavy_on_two", "mujoco", {}, {}),
    "streams of a sensor": ("sensor_imu_readout", "bullet", {}, {}),
    "other tellings": ("system_invariance", "bullet", {}, {}),
    "another order": ("stack_tower", "bullet", {"alteration": Alteration(name="again", told="reordered")}, {}),
    "an uneven pace": ("flight_projectile", "mujoco", {"pace": "loaded"}, {}),
    "rays": ("system_rays", "bullet", {}, {}),
    "many worlds": ("stack_pile", "mujoco", {}, {"worlds": 2.0}),
    "what diverged": ("stress_fall", "nan", {}, {}),
}


def put(name: str, engine: str, changes: dict[str, Any], parameters: dict[str, Any]) -> tuple[Trial, Case, Adapter]:
    case, adapter = plugins.case(name), plugins.adapter(engine)
    case = replace(case, duration=0.5) if name == "orbit_kepler" else case
    settings = replace(adapter.tracks["default"].with_dt(case.dt), pace=changes.get("pace", ""))
    trial = Trial(
        study="s", experiment=Experiment(name="e"), case=name, parameters={**case.parameters, **parameters}, engine=engine,
        engine_version="", track="default", settings=settings, seed=0, alteration=changes.get("alteration", Alteration()),
    )  # fmt: skip
    return trial.named(), case, adapter


def through_a_journal(record: Record) -> Record:
    return from_plain(Record, json.loads(json.dumps(plain(record))))


@BULLET
@pytest.mark.parametrize("name", RUNS)
def test_a_kept_answer_gives_the_record_and_the_file_of_a_fresh_run(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(PLUGINS))
    trial, case, adapter = put(*RUNS[name])
    fresh = run_trial(trial, case, adapter, tmp_path)
    assert fresh.trajectory_hash is not None, fresh.reason
    file = tmp_path / "trajectories" / f"{fresh.trajectory_hash}.npz"
    content = file.read_bytes()
    monkeypatch.setattr(accuracy, "answer_of", None)  # nothing is simulated
    anew = judged_anew(trial, case, through_a_journal(fresh), tmp_path)
    assert anew is not None
    assert json.dumps(plain(anew)) == json.dumps(plain(fresh))
    assert file.read_bytes() == content
    assert (fresh.broke is not None) == (fresh.status == "diverged") == (name == "what diverged")


def test_another_bound_and_another_metric_are_judged_as_in_a_fresh_run(tmp_path: Path) -> None:
    trial, case, adapter = put("flight_projectile", "mujoco", {}, {})
    kept = through_a_journal(run_trial(trial, case, adapter, tmp_path / "kept"))
    doubled = replace(position_error_max, measure=lambda run: 2 * run.actual.p_WB[:, 0, 2])
    checks = tuple(replace(each, at_most=0.0) if each.metric.name == case.headline else each for each in case.checks)
    edited = replace(case, checks=checks, observe=(*case.observe, replace(doubled, name="twice")))
    anew = judged_anew(trial, edited, kept, tmp_path / "kept")
    fresh = run_trial(trial, edited, adapter, tmp_path / "fresh")
    assert anew is not None
    assert plain(anew) == plain(fresh)
    assert (kept.status, anew.status) == ("passed", "failed")
    assert "twice" in {measurement.metric for measurement in anew.measurements}


def test_what_was_clocked_beside_a_run_stays_and_what_judged_it_is_said_anew(tmp_path: Path) -> None:
    trial, case, adapter = put("flight_projectile", "mujoco", {}, {})
    said = (StoredNotice("the engine's"), StoredNotice("no truth: old", by="judge"), StoredNotice("no clock", by="rough clock"))
    kept = replace(run_trial(trial, case, adapter, tmp_path), warnings=said, rough_cost=1.5, rough_ratio=0.5, idle=(("a", 1),))
    anew = judged_anew(trial, case, kept, tmp_path)
    assert anew is not None
    assert (anew.rough_cost, anew.rough_ratio, anew.idle) == (1.5, 0.5, (("a", 1),))
    assert anew.warnings == (said[0], said[2])


@pytest.mark.parametrize("harm", ["a bit", "cut short", "gone", "another answer", "another scene"])
def test_an_answer_that_is_not_as_it_was_written_is_not_judged(harm: str, tmp_path: Path) -> None:
    trial, case, adapter = put("flight_projectile", "mujoco", {}, {})
    kept = run_trial(trial, case, adapter, tmp_path)
    file = tmp_path / "trajectories" / f"{kept.trajectory_hash}.npz"
    content = file.read_bytes()
    if harm == "a bit":
        file.write_bytes(content[:700] + bytes([content[700] ^ 1]) + content[701:])
    elif harm == "cut short":
        file.write_bytes(content[:-100])
    elif harm == "gone":
        file.unlink()
    elif harm == "another answer":
        other = replace(trial, settings=trial.settings.with_dt(case.dt / 2))
        another = run_trial(other, case, adapter, tmp_path)
        shutil.copy(tmp_path / "trajectories" / f"{another.trajectory_hash}.npz", file)
    else:
        trial = replace(trial, parameters={**trial.parameters, "radius": 0.2})
    assert judged_anew(trial, case, kept, tmp_path) is None
