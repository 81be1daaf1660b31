"""A small price study, run for real through the command line: it sweeps, clocks what lies near the front, and can go on."""

import json
from pathlib import Path

import pytest

from plumbline.harness.findings.prices import Prices
from plumbline.harness.search.front import SCREENING, SMALLEST, TELLING
from plumbline.harness.statistics.pareto import on_front
from plumbline.harness.store.store import Store
from tests.conftest import Command

STUDY = """
name = "small"
recordings = false
[[experiments]]
name = "fronts"
cases = ["spin_asymmetric_top"]
engines = ["mujoco", "reference"]
dt = [0.016666666666666666, 0.004166666666666667, 0.0010416666666666667]
sweep = 4
samples = 2
sample_seconds = 0.002
deadline = 120.0
"""


@pytest.fixture(scope="module")
def folder(printed: Command, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of the study, whose trials have processes of their own."""
    here = tmp_path_factory.mktemp("price")
    (here / "small.toml").write_text(STUDY)
    done = printed("run", str(here / "small.toml"), "--out", str(here / "run"), "--workers", "2")
    assert done.returncode == 0, done.stderr
    return here / "run"


def test_the_sweep_goes_beyond_the_tracks_within_its_number(folder: Path) -> None:
    """Two tracks at three steps, each knob turned, and up to four more for each engine, named by what was turned."""
    trials = Store(folder).trials
    for engine in ("mujoco", "reference"):
        mine = trials[trials["engine"] == engine]
        hashes = mine["trajectory_hash"]
        # Settings that leave every bit as it was are no others: two tracks at three steps, each knob turned, and four answers
        # beyond at most.
        answers = set(hashes[mine["round"] > SCREENING].dropna()) - set(hashes[mine["round"] <= SCREENING])
        assert 0 < len(answers) <= 4
        words = set(mine["track"])
        assert {"default", "tuned"} < words
        assert all(word.split(",")[0] in ("default", "tuned") for word in words)
    assert any("integrator" in word for word in trials["track"])


def test_fronts_are_clocked_and_every_point_stays_visible(folder: Path) -> None:
    """What was not clocked keeps its rough cost; both ends of a front are clocked, or an answer as good for about as much."""
    trials = Store(folder).trials.set_index("trial")
    points = Prices(Store(folder)).points
    assert {point.clocked for point in points} == {True, False}
    for engine in ("mujoco", "reference"):
        mine = [point for point in points if point.engine == engine]
        rough = [trials["rough_ratio"][point.trial] for point in mine]
        flags = on_front([max(point.error, SMALLEST) for point in mine], rough)
        front = [(cost, point.error) for cost, point, on in zip(rough, mine, flags, strict=True) if on]
        for cost, error in (min(front), max(front)):
            close = (point for dear, point in zip(rough, mine, strict=True) if dear < TELLING * cost)
            assert any(point.clocked for point in close if max(point.error, SMALLEST) <= max(error, SMALLEST))


def test_the_price_list_has_every_pair_and_says_what_is_not_reached(folder: Path, printed: Command) -> None:
    """Through the command line; with integrators of a high order both engines come to 1e-6 of an attitude."""
    rows = json.loads(printed("show", str(folder), "--table", "price", "--format", "json").stdout)
    assert len(rows) == 2 * 8
    for row in rows:
        assert row["verdict"] in ("priced", "at most", "not within the ladder", "not clocked")
        assert (row["cost"] is None) == (row["verdict"] in ("not within the ladder", "not clocked"))
        if row["cost"] is not None:
            assert 0 < row["low"] <= row["high"]
            assert row["ratio"] >= 1 or row["engine"] == "reference"
    assert {row["engine"] for row in rows if row["cost"] is not None and row["target"] < 2e-6} == {"mujoco", "reference"}


def test_going_on_runs_nothing_that_was_run(folder: Path, printed: Command) -> None:
    """The rounds are found again from the journal, to the letter."""
    before = (folder / "journal.jsonl").read_bytes()
    done = printed("run", str(folder.parent / "small.toml"), "--out", str(folder), "--workers", "2", "--resume")
    assert done.returncode == 0, done.stderr
    assert (folder / "journal.jsonl").read_bytes() == before


@pytest.mark.parametrize("table", ["profile", "steps"])
def test_tables_made_of_prices_print(folder: Path, printed: Command, table: str) -> None:
    """In every format, with the same number of rows."""
    rows = json.loads(printed("show", str(folder), "--table", table, "--format", "json").stdout)
    assert rows
    assert len(printed("show", str(folder), "--table", table, "--format", "csv").stdout.splitlines()) == len(rows) + 1
    assert "reference" in printed("show", str(folder), "--table", table).stdout
