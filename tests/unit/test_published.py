"""The dataset that ships with the package: written of a run, sealed, read back, ranked by, and shown beside a run."""

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import plumbline
from plumbline.harness.store import published as room
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.published import MOST_BYTES, NotPublished, publish, published
from plumbline.harness.store.store import Store
from plumbline.reports.pages import index
from plumbline.reports.tables.published import BEGIN, END, beside_published, in_markdown, published_table
from plumbline.reports.words.catalogue import engines
from tests.conftest import Command
from tests.two_runs import write_two_runs

ROOT = Path(__file__).parents[2]
SHIPPED = ROOT / "src" / "plumbline" / "published"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> plumbline.Results:
    """Two engines in one case, as they are."""
    out = tmp_path_factory.mktemp("run") / "q"
    return plumbline.compare("quick", ["mujoco", "dart"], cases=["flight_projectile"], out=out, report=False)


@pytest.fixture
def dataset(run: plumbline.Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The run, published in the place of the package's own."""
    publish(run.store, tmp_path / "published")
    monkeypatch.setattr(room, "FOLDER", tmp_path / "published")
    return tmp_path / "published"


def test_what_is_published_reads_back_as_the_run(run: plumbline.Results, dataset: Path) -> None:
    store = plumbline.published().store
    for name in ("trials", "measurements", "samples"):
        pd.testing.assert_frame_equal(getattr(store, name), getattr(run.store, name))
    assert store.catalogue == run.store.catalogue
    assert store.study == run.store.study
    assert plumbline.published().prices.equals(run.prices)
    assert plumbline.select(plumbline.published()).frame().equals(plumbline.select(run).frame())


def test_nothing_of_the_machine_s_paths_is_published(run: plumbline.Results, dataset: Path) -> None:
    machine = json.loads((dataset / "machine.json").read_text(encoding="utf-8"))
    assert machine.keys().isdisjoint({"command", "journal"})
    assert machine["processor"] == run.store.machine["processor"]
    assert not any(str(run.folder).encode() in path.read_bytes() for path in dataset.iterdir())


@pytest.mark.parametrize("name", ["trials.parquet", "catalogue.json", "machine.json", "study.toml"])
def test_a_damaged_dataset_is_refused_by_file(dataset: Path, name: str) -> None:
    path = dataset / name
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(StoreError, match="checksum differs"):
        published()


def test_a_run_that_is_too_large_or_not_whole_is_not_published(
    run: plumbline.Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(room, "MOST_BYTES", 1000)
        with pytest.raises(StoreError, match=r"expected at most 1000 \(catalogue.json \d+"):
            publish(run.store, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    half = Store(run.folder)
    half.__dict__["machine"] = run.store.machine | {"complete": False}
    with pytest.raises(StoreError, match="not whole"):
        publish(half, tmp_path / "out")


def test_the_command_refuses_a_folder_that_is_not_as_it_was_written(
    run: plumbline.Results, tmp_path: Path, printed: Command
) -> None:
    done = printed("publish", run.folder, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert f"at most {MOST_BYTES} bytes" in done.stdout
    assert published(tmp_path / "out").trials.equals(run.store.trials)
    study = run.folder / "study.toml"
    before = study.read_bytes()
    try:
        study.write_bytes(before.replace(b"quick", b"quack", 1))
        damaged = printed("publish", run.folder, "--out", tmp_path / "other")
    finally:
        study.write_bytes(before)
    assert damaged.returncode == 3
    assert "study.toml" in damaged.stderr
    assert not (tmp_path / "other").exists()


def test_select_ranks_by_the_dataset_and_says_where_it_comes_from(dataset: Path, printed: Command) -> None:
    done = printed("select", "--published", "--json")
    assert done.returncode == 0, done.stderr
    assert {row["engine"] for row in json.loads(done.stdout)} == {"mujoco", "dart"}
    assert "Published figures: Quick study" in done.stderr
    assert "installed is" not in done.stderr
    for words in ((), ("--published", "somewhere")):
        wrong = printed("select", *words)
        assert (wrong.returncode, "DIR or --published" in wrong.stderr) == (2, True)


def test_another_version_than_the_installed_one_is_named(dataset: Path, printed: Command, run: plumbline.Results) -> None:
    older = pd.read_parquet(dataset / "trials.parquet")
    store = published()
    store.__dict__["_whole"] = store._whole | {"trials": older.assign(engine_version="1.2.3")}
    store.__dict__.pop("_read", None)
    from plumbline.api.published import published_in_words

    version = run.trials.set_index("engine")["engine_version"]["mujoco"].iloc[0]
    assert f"MuJoCo: published with 1.2.3, installed is {version}." in published_in_words(store)


def test_without_a_dataset_the_remedy_is_said(printed: Command) -> None:
    done = printed("select", "--published")
    assert done.returncode == 3
    assert "plumbline publish DIR makes one" in done.stderr
    with pytest.raises(NotPublished):
        plumbline.published()
    assert published_table() is None


def test_a_run_beside_the_dataset_tells_other_verdicts_and_what_costs_more_than_the_machine_explains(tmp_path: Path) -> None:
    """The second folder's machine takes 1.3 times the time throughout; Bullet twice that; one verdict of DART's is another."""

    def planted(trials: pd.DataFrame, _measurements: pd.DataFrame, samples: pd.DataFrame) -> None:
        bullet = trials["trial"][trials["engine"] == "bullet"]
        samples.loc[samples["trial"].isin(bullet), "cpu"] *= 2.0
        failing = trials.index[(trials["engine"] == "dart") & (trials["status"] == "passed")][0]
        trials.loc[failing, "status"] = "failed"
        trials["unstable_timing"] = False

    folders = write_two_runs(tmp_path, planted)
    for name in ("trials.parquet",):
        frame = pd.read_parquet(folders[0] / name)
        frame.assign(unstable_timing=False).to_parquet(folders[0] / name, index=False)
    besides = beside_published(*map(Store, folders))
    assert besides["bullet"].slower == pytest.approx(2.0, rel=0.05), "2 % of noise a sample, medians of ten"
    assert besides["mujoco"].slower == pytest.approx(1.0, rel=0.05)
    assert [(then["status"], now["status"]) for then, now in besides["dart"].differences] == [("passed", "failed")]
    assert besides["mujoco"].differences == ()
    assert all(beside.same > 0 for name, beside in besides.items() if name in ("mujoco", "bullet", "dart"))


def test_the_first_page_has_the_dataset_beside_the_run_and_greys_another_version(
    run: plumbline.Results, dataset: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = str(index.PAGE.render(run.store)["index.html"])
    section = page.partition('id="published"')[2].partition("</section>")[0]
    same = len(run.trials)
    assert f"This run holds {same} of them too." in section
    assert section.count("<td>nowhere</td>") == 2
    assert "other-version" not in section
    newer = run.store.trials.assign(engine_version=lambda frame: frame["engine_version"].where(frame["engine"] != "dart", "99"))
    store = Store(run.folder)
    store.__dict__["_read"] = run.store._read | {"trials": newer}
    section = str(index.PAGE.render(store)["index.html"]).partition('id="published"')[2].partition("</section>")[0]
    assert section.count("other-version") == 1
    assert ", here 99</td>" in section


def test_a_run_of_other_questions_has_no_such_section(run: plumbline.Results, dataset: Path, tmp_path: Path) -> None:
    other, _ = write_two_runs(tmp_path / "others", only=("joint_chain",))
    assert 'id="published"' not in str(index.PAGE.render(Store(other))["index.html"])


def shipped() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(room, "FOLDER", SHIPPED)
        return published_table()


def test_the_dataset_that_ships_is_whole_small_and_has_all_engines() -> None:
    store = published(SHIPPED)
    assert sum(path.stat().st_size for path in SHIPPED.iterdir()) <= MOST_BYTES
    assert {"mujoco", "bullet", "dart"} <= set(engines(store))
    assert not set(store.trials["status"]) & {"unavailable", "interrupted"}
    assert store.machine["complete"]


def test_the_table_of_the_readme_is_that_of_the_dataset() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert text.partition(BEGIN)[2].partition(END)[0].strip() == in_markdown(shipped())
