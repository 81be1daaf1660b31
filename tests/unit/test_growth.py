"""Large stores: tables are read in the place of the journal only where they are of it, and long tables show what matters."""

import json
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner

from plumbline.harness.cli import listing
from plumbline.harness.cli.main import main
from plumbline.harness.store import store as store_module
from plumbline.harness.store.journal import read_written
from plumbline.harness.store.journal_index import read_index
from plumbline.harness.store.store import Store
from plumbline.harness.store.stored_tables import TABLES, in_order, in_parquet, tables_of
from plumbline.reports.tables.trial_results import MOST_ROWS, listed, rows_shown
from tests.large_store import unsynchronised, write_large_store

TRIALS = 300


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("growth") / "run"
    with unsynchronised():
        write_large_store(path, TRIALS)
    return path


@pytest.fixture
def copy(folder: Path, tmp_path: Path) -> Path:
    for path in folder.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    return tmp_path


def refused(path: Path) -> None:
    raise AssertionError(f"{path} was read")


def test_tables_that_are_of_the_journal_are_read_in_its_place(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_module, "read_written", refused)
    store = Store(folder)
    assert len(store.trials) == TRIALS
    assert set(store.bases.values()) == {"default", "tuned"}
    assert store.notes == ()
    assert store.notices.keys() == set(store.trials["trial"])


@pytest.mark.parametrize("name", ["journal.jsonl", *(f"{table}.parquet" for table in TABLES)])
def test_tables_and_journal_of_which_one_has_changed_are_not_taken_for_one_another(
    name: str, copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = bytearray((copy / name).read_bytes())
    content[len(content) // 2] ^= 1
    (copy / name).write_bytes(content)
    monkeypatch.setattr(store_module, "read_written", refused)
    with pytest.raises(AssertionError, match=r"journal\.jsonl was read"):
        Store(copy).trials  # noqa: B018  # reading is what is tested


def test_tables_that_are_read_back_are_those_of_the_records(folder: Path) -> None:
    due = tables_of(read_written(folder / "journal.jsonl").records.values())
    store = Store(folder)
    for name in TABLES:
        read = getattr(store, name)
        pd.testing.assert_frame_equal(read, due[name][list(read.columns)])


def test_an_index_gives_the_records_of_a_journal_in_the_order_of_tables(folder: Path) -> None:
    records = in_order(read_written(folder / "journal.jsonl").records.values())
    index = read_index(folder / "journal.jsonl")
    assert list(index.records()) == records
    assert in_parquet(index.records()) == {name: (folder / f"{name}.parquet").read_bytes() for name in TABLES}


def test_a_table_for_people_shows_its_first_rows_and_says_how_many_it_has(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(listing, "MOST_ROWS", 7)
    shown = CliRunner().invoke(main, ["show", str(folder)])
    rows = [line for line in shown.stdout.splitlines() if line.startswith("│") and line[2] != " "]
    assert len(rows) == 7
    assert shown.stdout.splitlines()[-1] == f"and {TRIALS - 7} more rows; --format json prints all {TRIALS}"
    assert len(json.loads(CliRunner().invoke(main, ["show", str(folder), "--format", "json"]).stdout)) == TRIALS


def test_a_page_lists_the_trials_that_matter_in_their_order() -> None:
    count = 3 * MOST_ROWS
    rows = pd.DataFrame(
        {
            "trial": [f"t{k}" for k in range(count)],
            "track": [("tuned, x 1", "default", "tuned, x 2")[k % 3] for k in range(count)],
        }
    )
    priced = f"t{count - 3}"
    shown = listed(rows.drop(index=1), {priced})
    assert len(shown) == MOST_ROWS
    assert set(shown["track"]) == {"default", "tuned, x 1"}
    assert list(shown["trial"])[-2:] == [priced, f"t{count - 2}"]
    assert list(shown.index) == sorted(shown.index)
    assert rows_shown([1, 0, 1]) == [0, 1, 2]
