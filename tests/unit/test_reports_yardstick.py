"""The reference engine is not ranked: where it errs least a reason stands, and no headline has it for a winner."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from plumbline.harness.findings.tables import limits
from plumbline.harness.store.store import Store
from plumbline.reports.tables.engine_summary import NO_REASON, leads
from plumbline.reports.tables.summary import sentences
from plumbline.reports.words.catalogue import ours
from tests.links import texts_of
from tests.run_folder import write_run_folder

REASON = {"tuned/joint_pendulum": {"by": "sub-steps", "why": "eight to one: by one it errs as the others do"}}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_run_folder(tmp_path / "run", only=("joint_pendulum", "stack_tower"))


def retold(folder: Path, engine: str, **fields: Any) -> Store:
    """The folder with other words about an engine in its catalogue."""
    path = folder / "catalogue.json"
    told = json.loads(path.read_text())
    told["engines"][engine] |= fields
    for case in told["cases"].values():
        case["features"] = ["revolute"]
    path.write_text(json.dumps(told))
    return Store(folder)


def test_where_our_engine_errs_least_its_reason_stands_or_that_none_is_given(folder: Path) -> None:
    store = retold(folder, "reference", advantages=REASON)
    found = leads(store)
    # By the formulas of the folder ours is of order two from the smallest error, so that it leads everywhere.
    assert found.keys() == {(case, track) for case in ("joint_pendulum", "stack_tower") for track in ("default", "tuned")}
    assert (found["joint_pendulum", "tuned"].by, found["joint_pendulum", "tuned"].why) == tuple(
        REASON["tuned/joint_pendulum"].values()
    )
    assert found["joint_pendulum", "default"].by == NO_REASON
    pages = texts_of(store, "case")
    assert REASON["tuned/joint_pendulum"]["why"] in pages["case-joint_pendulum.html"]
    assert pages["case-joint_pendulum.html"].count(NO_REASON) == 1
    assert pages["case-stack_tower.html"].count(NO_REASON) == 2
    assert (
        "On the tuned track the reference engine is most accurate in 2 cases: by sub-steps in 1, with no reason given in 1;"
        in " ".join(sentences(store))
    )


def test_our_engine_leads_nowhere_where_another_errs_less_or_as_little(folder: Path) -> None:
    store = Store(folder)
    mine = store.trials["engine"].isin(ours(store))
    names = set(store.trials["trial"][mine])
    rows = store.measurements["trial"].isin(names)
    store.measurements.loc[rows, "value"] *= 1e3
    assert leads(store) == {}


def test_errors_within_rounding_or_a_per_cent_lead_nobody(folder: Path) -> None:
    for factor, lead in ((0.9895, True), (0.9905, False), (1e-9, False)):
        store = Store(folder)
        table = store.measurements
        for case, trials in store.trials.groupby("case"):
            scale = store.catalogue["cases"][case]["scale"]
            rival = 1e-7 * scale if factor == 1e-9 else 1e-3 * scale
            for engine, group in trials.groupby("engine"):
                rows = table["trial"].isin(group["trial"]) & table["unit"].isin(("rad", "m"))
                table.loc[rows, "value"] = factor * rival if engine == "reference" else rival
        assert bool(leads(store)) == lead


def test_no_sentence_of_the_summary_ranks_our_engine(folder: Path) -> None:
    store = Store(folder)
    title = store.catalogue["engines"]["reference"]["title"]
    ranking = [
        one for one in sentences(store) if " most cases at their nominal time step: " in one or "What accuracy costs" in one
    ]
    assert len(ranking) == 3
    assert not any(title in one for one in ranking)


def test_the_table_of_limits_ranks_the_others_and_puts_the_yardstick_beside_them() -> None:
    def row(engine: str, held: float | None, reach: float, axis: str = "speed") -> SimpleNamespace:
        told = {"experiment": "e", "case": "wall", "where": "", "axis": axis, "verdict": "limit"}
        told |= {"further": reach, "fair": True}
        return SimpleNamespace(**told, engine=engine, track="tuned", parts=4, held=held, reach=reach)

    rows = [row("reference", 50.0, 1.0), row("mujoco", 10.0, 0.5), row("dart", 10.0, 0.5)]
    rows += [row("reference", 2.0, 0.2, "mass"), row("mujoco", None, 0.0, "mass")]
    assert limits.TABLE.sentences(rows) == [
        "wall, sub-step dt/4: speed up to 10: mujoco (tuned, dt/4), dart (tuned, dt/4); reference, not ranked, 50.",
        "wall, sub-step dt/4: mass up to no value: nobody; reference, not ranked, 2.",
    ]


def test_what_an_adapter_makes_is_told_on_every_page_that_speaks_of_it(folder: Path) -> None:
    told = [{"feature": "revolute", "how": "the hinge is two points of its axis", "where": "", "tracks": ["default", "tuned"]}]
    pages = texts_of(retold(folder, "mujoco", emulated=told), "method", "case", "index")
    assert "the hinge is two points of its axis" in pages["method.html"]
    assert "the hinge is two points of its axis" in pages["case-joint_pendulum.html"]
    assert "revolute emulated by the adapter" in pages["index.html"]
    # By the folder's formulas MuJoCo errs by the first order where the second is promised.
    (broken,) = [one for one in sentences(Store(folder)) if "than the integrator promises" in one]
    assert "MuJoCo (tuned) in “Pendulum from 90 degrees” (revolute emulated)" in broken
    assert "DART (tuned) in “Pendulum from 90 degrees”" in broken
    assert "DART (tuned) in “Pendulum from 90 degrees” (" not in broken
