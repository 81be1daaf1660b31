"""A time step is told with the sub-steps that it was taken in, whoever tells it."""

import pytest

from plumbline.harness.findings.parameter_words import step_in_words, substeps_of, substeps_taken
from plumbline.harness.findings.tables import price, steps
from plumbline.harness.store.store import Store
from plumbline.reports.words.text import step
from tests.run_folder import write_run_folder


@pytest.mark.parametrize(
    ("resolved", "count"), [('{"substeps": 4}', 4), ('{"substeps": null}', 1), ("{}", 1), ("", 1), ("null", 1)]
)
def test_what_an_engine_says_that_it_used_counts(resolved: str, count: int) -> None:
    assert substeps_of(resolved) == count


@pytest.mark.parametrize(
    ("dt", "substeps", "told"),
    [
        (1 / 60, 4, "1/60 s (4 sub-steps)"),
        (1 / 240, 1, "1/240 s"),
        (1 / 240, None, "1/240 s"),
        (0.0033, 2, "0.0033 s (2 sub-steps)"),
    ],
)
def test_a_step_is_told_with_its_sub_steps(dt: float, substeps: int | None, told: str) -> None:
    assert step_in_words(dt, substeps) == told


def test_a_report_says_it_alike_in_its_own_unit() -> None:
    assert step(1 / 60, 4) == step_in_words(1 / 60, 4)
    assert step(0.0033, 2) == "3.3 ms (2 sub-steps)"


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(write_run_folder(tmp_path_factory.mktemp("steps") / "run", only=("joint_chain", "stack_tower")))


def test_the_store_knows_which_trials_were_cut(store: Store) -> None:
    cut = store.trials[store.trials["trial"].isin(substeps_taken(store))]
    assert set(zip(cut["engine"], cut["track"], strict=True)) == {("bullet", "tuned")}
    assert (cut["dt"] > 1 / 240).all()
    assert set(substeps_taken(store).values()) == {4, 2}


def test_tables_tell_the_sub_steps_beside_the_step(store: Store) -> None:
    cut = substeps_taken(store)
    for found in price.TABLE.objects(store):
        row = price.TABLE.flat(found)
        assert row["substeps"] in (None, cut.get(row["trial"], 1))
        if row["cost"] is not None and row["trial"] in cut:
            assert f"({cut[row['trial']]} sub-steps)" in str(price.TABLE.brief(found))
    (row,) = (
        row for row in steps.TABLE.objects(store) if (row.case, row.engine, row.track) == ("stack_tower", "bullet", "tuned")
    )
    assert row.stable_substeps == 4
    assert "1/60 s (4 sub-steps)" in str(steps.TABLE.brief(row))
