"""The contract with scripts: commands, table columns and exit codes are still exactly these."""

import csv
import io
import json
from pathlib import Path

import pytest

from plumbline.harness.store.store import Store
from tests.conftest import PLUGINS, Command

TRIALS = [
    "trial",
    "study",
    "experiment",
    "case",
    "parameters",
    "engine",
    "engine_version",
    "track",
    "dt",
    "settings",
    "resolved",
    "seed",
    "status",
    "reason",
    "sim_seconds",
    "steps",
    "cpu_per_sim_s",
    "cpu_low",
    "cpu_high",
    "wall_per_sim_s",
    "realtime_factor",
    "unstable_timing",
    "trajectory_hash",
]
MEASUREMENTS = ["trial", "metric", "value", "unit", "at_most", "passed", "because"]
COMMANDS = ["cases", "check", "engines", "report", "reproduce", "run", "serve", "show", "verify", "view", "warm"]
FILES = [
    "trials.parquet",
    "measurements.parquet",
    "samples.parquet",
    "journal.jsonl",
    "study.toml",
    "machine.json",
    "junit.xml",
    "summary.md",
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, plumbline: Command) -> Path:
    """The run folder of a small real run: a third party's sound engine and one that dies, with timing and a recording."""
    out = tmp_path_factory.mktemp("contract")
    study = out / "small.toml"
    study.write_text(
        'name = "small"\n[[experiments]]\nname = "e"\ncases = ["stress_fall"]\nmemory = 1000.0\n'
        "samples = 3\nsample_seconds = 0.002\n"
    )
    done = plumbline("run", study, "--engine", "sound", "--engine", "segfault", "--out", out / "run", plugins=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(out / "run" / "report" / "index.html")
    return out / "run"


def test_every_command_of_the_contract_is_there(printed: Command) -> None:
    text = printed("--help").stdout
    for command in COMMANDS:
        assert f"\n  {command} " in text


def test_the_columns_are_those_of_the_contract(folder: Path) -> None:
    store = Store(folder)
    assert list(store.trials.columns)[: len(TRIALS)] == TRIALS
    assert list(store.measurements.columns)[: len(MEASUREMENTS)] == MEASUREMENTS


def test_every_file_of_the_contract_is_there(folder: Path) -> None:
    for name in FILES:
        assert (folder / name).is_file(), name
    trial = Store(folder).trials.set_index("engine").loc["sound"].iloc[0]
    assert (folder / "trajectories" / f"{trial['trajectory_hash']}.npz").is_file()
    assert (folder / "recordings" / "stress_fall.rrd").is_file()
    assert (folder / "report" / "index.html").is_file()


def test_show_prints_one_json_array_and_nothing_else(folder: Path, printed: Command) -> None:
    done = printed("show", folder, "--format", "json")
    rows = json.loads(done.stdout)
    assert {row["engine"]: row["status"] for row in rows} == {"sound": "passed", "segfault": "crashed"}
    assert done.stderr == ""
    (sound, *_) = [row for row in rows if row["engine"] == "sound"]
    assert sound["cpu_low"] <= sound["cpu_per_sim_s"] <= sound["cpu_high"]


@pytest.mark.parametrize("table", ["trials", "measurements", "samples"])
def test_show_prints_every_table_in_every_format(folder: Path, printed: Command, table: str) -> None:
    rows = json.loads(printed("show", folder, "--table", table, "--format", "json").stdout)
    sheet = list(csv.DictReader(io.StringIO(printed("show", folder, "--table", table, "--format", "csv").stdout)))
    assert [row["trial"] for row in sheet] == [row["trial"] for row in rows]
    markdown = printed("show", folder, "--table", table, "--format", "markdown").stdout
    assert len(markdown.splitlines()) == 2 + len(rows)
    assert rows[0]["trial"][:6] in printed("show", folder, "--table", table).stdout


def test_a_trial_run_again_is_bit_identical(folder: Path, printed: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(PLUGINS))
    trial = Store(folder).trials.set_index("engine").loc["sound"].iloc[0]["trial"]
    done = printed("reproduce", folder, trial)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "bit-identical"


def test_the_report_is_rebuilt_from_the_store_alone(folder: Path, printed: Command) -> None:
    index = folder / "report" / "index.html"
    before = index.read_text()
    index.unlink()
    done = printed("report", folder)  # the plug-ins are not installed here: the store has to be enough
    assert done.returncode == 0, done.stderr
    assert index.read_text() == before


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("run", "quikc"), 2, "quikc"),
        (("run", "quick", "--engine", "nonsense"), 2, "nonsense"),
        (("run", "quick", "--case", "nonsense*"), 2, "nonsense"),
        (("run", "quick", "--shard", "5/4"), 2, "5/4"),
        (("run", "quick", "--workers", "0"), 2, "workers"),
        (("check", "nonsense"), 2, "expected one of"),
        (("show", "nowhere"), 2, "nowhere"),
        (("report", "nowhere"), 2, "nowhere"),
        (("verify", "nowhere"), 2, "nowhere"),
        (("run", "quick", "--resume=again"), 2, "expected merge"),
        (("view", "nowhere", "x"), 2, "nowhere"),
        (("reproduce", "nowhere", "x"), 2, "nowhere"),
        (("show", ".", "--table", "nonsense"), 2, "nonsense"),
    ],
)
def test_wrong_usage_has_its_exit_code_and_names_what_was_wrong(
    arguments: tuple[str, ...],
    code: int,
    words: str,
    plumbline: Command,
    printed: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One in a process, whose exit code a script sees."""
    monkeypatch.chdir(tmp_path)
    done = (plumbline if arguments == ("show", "nowhere") else printed)(*arguments)
    assert done.returncode == code, done.stderr
    assert words in done.stderr
    assert done.stdout == ""
    assert list(tmp_path.iterdir()) == []
