"""Notices: what an engine says of an answer stays typed on its way into a record and back."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from plumbline.harness.adapter import Notice, Settings, Simulation
from plumbline.harness.adapter.notice import as_notices
from plumbline.harness.adapter.what_comes_out import Answering, BrokenContract
from plumbline.harness.conformance import CHECKS
from plumbline.harness.scene import Body, Effect, Scene
from plumbline.harness.store.journal import Journal, read_journal
from plumbline.harness.store.record import Record, StoredNotice
from plumbline.harness.store.store import Store
from plumbline.harness.store.stored_tables import in_order, write_tables
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import run_trial
from tests.planted_faults.planting import plant

SURPLUS = StoredNotice("gyroscopic (no switch)", "surplus", "gyroscopic")
MISSING = StoredNotice("continuous_collision: dartpy's step has none", "missing", "continuous_collision")
SPOKEN = StoredNotice("linear damping, by default", "surplus", "linear_damping")
SENTENCES = [
    "surplus: gyroscopic (no switch)",
    "missing: continuous_collision: dartpy's step has none",
    "surplus: linear damping, by default",
    "surplus to a note",
]
TYPED = (SURPLUS, MISSING, SPOKEN, StoredNotice("surplus to a note"))


def record(trial: str, warnings: tuple[StoredNotice, ...]) -> Record:
    """A record that says this."""
    return Record(
        trial=trial, study="s", experiment="e", case="c", parameters={}, engine="one", engine_version="1", track="default",
        dt=0.1, settings={}, status="passed", reason="every check holds", warnings=warnings,
    )  # fmt: skip


def test_a_notice_comes_back_from_the_journal_as_it_was(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    journal.append(record("a", TYPED))
    journal.close()
    assert read_journal(tmp_path / "journal.jsonl")["a"].warnings == TYPED
    store = Store(tmp_path)
    assert store.notices == {"a": TYPED}
    assert json.loads(store.trials.loc[0, "warnings"]) == SENTENCES


def test_a_table_without_its_journal_says_the_same(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    journal.append(record("a", TYPED))
    journal.close()
    write_tables(tmp_path, in_order(read_journal(tmp_path / "journal.jsonl").values()))
    (tmp_path / "journal.jsonl").unlink()
    assert Store(tmp_path).notices == {"a": TYPED}


def test_a_plain_text_is_a_note_whatever_it_reads() -> None:
    notice = Notice("gyroscopic, always", "surplus", Effect.GYROSCOPIC)
    assert as_notices(("surplus: gyroscopic", notice)) == (Notice("surplus: gyroscopic"), notice)
    assert str(notice) == "surplus: gyroscopic, always"
    assert str(Notice("surplus: gyroscopic")) == "surplus: gyroscopic"


class Saying:
    """A sound simulation with words of its own."""

    def __init__(self, inner: Simulation, *said: Any) -> None:
        self._inner, self._said = inner, said

    def warnings(self) -> tuple[Any, ...]:
        return self._said

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)


@pytest.mark.parametrize("said", [(1,), (b"x",), (None,), ("fine", 2.0)])
def test_what_is_neither_text_nor_notice_breaks_the_contract(said: tuple[Any, ...]) -> None:
    scene = Scene(bodies=(Body(name="b"),))
    simulation = cast(Simulation, Saying(plugins.adapter("mujoco").build(scene, Settings()), *said))
    with pytest.raises(BrokenContract, match=rf"warnings\(\)\[{len(said) - 1}\]"):
        Answering(simulation, scene).warnings()


def test_a_trial_keeps_which_effect_its_engine_could_not_leave_out() -> None:
    case, adapter = plugins.case("flight_projectile"), plugins.adapter("mujoco")
    trial = Trial(
        study="s",
        experiment=Experiment(name="e"),
        case=case.name,
        parameters=dict(case.parameters),
        engine="mujoco",
        engine_version="1",
        track="default",
        settings=adapter.tracks["default"].with_dt(case.dt),
        seed=0,
    ).named()
    (notice,) = run_trial(trial, case, adapter, None).warnings
    assert (notice.kind, notice.effect) == ("surplus", "gyroscopic")


@pytest.mark.parametrize(
    ("notice", "status"),
    [
        (Notice("magnetism", "surplus"), "failed"),
        (Notice("much", "missing", Effect.GRAVITY | Effect.CONTACT), "failed"),
        (Notice("gyroscopic", "surplus", Effect.GYROSCOPIC), "passed"),
        (Notice("surplus: magnetism"), "passed"),
    ],
)
def test_a_surplus_names_one_effect(notice: Notice, status: str) -> None:
    def speak(simulation: Simulation, *_: object) -> Simulation:
        return cast(Simulation, Saying(simulation, notice))

    (check,) = (check for check in CHECKS if check.name == "surplus_names_effects")
    adapter = plant(plugins.adapter("mujoco"), simulation=speak)
    assert check.run(adapter, adapter.tracks["default"]).status == status


def test_what_a_track_descends_from_is_a_field(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    journal.append(replace(record("new", ()), track="a variant, with a comma, iterations 4", base="a variant, with a comma"))
    journal.close()
    assert Store(tmp_path).bases == {"new": "a variant, with a comma"}
    assert "base" not in Store(tmp_path).trials
