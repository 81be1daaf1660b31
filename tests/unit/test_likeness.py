"""A trial run again: the same bits, as good where bits are promised on one machine alone, or different."""

from dataclasses import replace
from typing import Any

import pytest

from plumbline.adapters.reference import ADAPTER
from plumbline.harness.adapter import Settings
from plumbline.harness.adapter.settings import BITS, OF_ONE_MACHINE, only_here
from plumbline.harness.findings.changes.answers import Likeness, likeness
from plumbline.harness.store.record import Measurement, Record
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.foreseen_cost import scene_at
from plumbline.harness.study.reproduce import trial_of
from plumbline.harness.trial.accuracy import outcome
from tests.run_folder import write_run_folder


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """A run folder of this machine."""
    return Store(write_run_folder(tmp_path_factory.mktemp("again") / "run", only=("joint_pendulum",)))


def ran_again(store: Store, hash_now: str, bits: str, off: float) -> tuple[dict[str, Any], Record]:
    """The first trial of the store with an answer, and its record with other bits and each bounded metric off by a share."""
    row = store.trials[store.trials["status"] == "passed"].iloc[0]
    measured = store.measurements[store.measurements["trial"] == row["trial"]]
    rows = [
        Measurement(metric=m.metric, value=float(m.value) * (1.0 + off), unit=m.unit, at_most=float(m.at_most), passed=True)
        for m in measured.itertuples()
        if m.at_most == m.at_most
    ]
    assert rows
    now = replace(
        outcome(trial_of(store, row["trial"]), "passed", "", ""),
        measurements=tuple(rows),
        trajectory_hash=hash_now or row["trajectory_hash"],
        resolved={"options": {BITS: bits}},
    )
    return row.to_dict(), now


@pytest.mark.parametrize(
    ("hash_now", "bits", "off", "processor", "expected"),
    [
        ("", "", 0.0, "another", "bit-identical"),
        ("f" * 64, OF_ONE_MACHINE, 1e-3, "another", "as good"),
        ("f" * 64, OF_ONE_MACHINE, 10.0, "another", "different"),
        ("f" * 64, OF_ONE_MACHINE, 0.0, "", "different"),
        ("f" * 64, "", 0.0, "another", "different"),
    ],
    ids=["same bits", "other bits elsewhere", "another answer", "other bits here", "bits are promised everywhere"],
)
def test_other_bits_are_as_good_only_where_bits_are_promised_on_one_machine_and_this_is_another(
    store: Store, hash_now: str, bits: str, off: float, processor: str, expected: Likeness
) -> None:
    then, now = ran_again(store, hash_now, bits, off)
    here = str(store.machine.get("processor"))
    assert likeness(store, then, now, processor or here) == expected


def test_another_status_is_different_whatever_the_bits(store: Store) -> None:
    then, now = ran_again(store, "", OF_ONE_MACHINE, 0.0)
    assert likeness(store, {**then, "status": "failed"}, now, "another") == "different"


@pytest.mark.parametrize(("solver", "promised"), [("exact", False), ("tgs_soft", True)])
def test_the_exact_solver_says_that_its_bits_are_of_one_machine(solver: str, promised: bool) -> None:
    simulation = ADAPTER.build(scene_at(plugins.case("stack_tower"), {}), Settings(dt=1 / 240, solver=solver))
    assert only_here(simulation.resolved.plain()) is not promised
