"""A run over the workers of a scheduler: the same bits as here, whatever is lost on the way."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.run import fork_servers
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.run.cluster.cells import OtherPlumbline
from plumbline.harness.run.cluster.workplace import NoScheduler, Workplace
from plumbline.harness.run.isolated import run_isolated
from plumbline.harness.run.verify import problems
from plumbline.harness.store.journal import read_journal
from plumbline.harness.store.machine_fingerprint import fingerprint, machine_digest
from plumbline.harness.store.record import Record
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.provenance import sources_of
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial

ABSENT = find_spec("distributed") is None
# Looked for and not imported: who runs the quick tests has no use for it.
pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(900),
    pytest.mark.skipif(ABSENT, reason="dask is not installed: pip install 'plumbline[dask]'"),
]

CASES = ("flight_box", "joint_pendulum", "flight_projectile")
ENGINES = ("mujoco", "dart")
TOML = f"""
name = "far"
recordings = false
[[experiments]]
name = "far"
cases = {list(CASES)}
engines = {list(ENGINES)}
samples = 1
sample_seconds = 0.001
"""


@pytest.fixture(scope="module")
def study() -> Study:
    return Study(
        name="far",
        recordings=False,
        experiments=(Experiment(name="far", cases=CASES, engines=ENGINES, samples=1, sample_seconds=0.001),),
    )


@pytest.fixture(scope="module")
def trials(study: Study) -> list[Trial]:
    adapters = {name: plugins.adapter(name) for name in ENGINES}
    versions = {name: plugins.version_of(adapter)[0] for name, adapter in adapters.items()}
    return list(study.trials({name: plugins.case(name) for name in CASES}, adapters, versions, sources_of))


@pytest.fixture(scope="module")
def local(trials: list[Trial], tmp_path_factory: pytest.TempPathFactory) -> dict[str, str | None]:
    """The hash of each trial of a run in this place."""
    return _hashes(run_isolated(trials, tmp_path_factory.mktemp("local"), 1))


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    import distributed

    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as both:
        yield both


def _hashes(records: Iterator[Record]) -> dict[str, str | None]:
    return {record.trial: record.trajectory_hash for record in records}


def _looks(dask_worker: Any) -> tuple[str, ...]:
    """What a worker watches itself by, which takes CPU time from cells."""
    watching = dask_worker.periodic_callbacks.items()
    return tuple(name for name, each in watching if name.startswith("profile") and each.is_running())


def _loaded() -> list[str]:
    """What fork servers of a worker load."""
    return fork_servers._preload(fork_servers.Origin())


def test_two_workers_give_the_run_folder_that_one_machine_gives(
    study: Study, local: dict[str, str | None], cluster: Any, tmp_path: Path
) -> None:
    cases = {name: plugins.case(name) for name in CASES}
    adapters = {name: plugins.adapter(name) for name in ENGINES}
    with Workplace(cluster.scheduler_address) as workplace:
        store = carry_out(study, tmp_path / "far", cases, adapters, workers=1, resume=False, cluster=workplace)
        looks, loaded = workplace._client.run(_looks), workplace._client.run(_loaded)
    assert set(looks.values()) == {()}
    assert all({"plumbline.cases.flight_box", "plumbline.adapters.dart"} <= set(modules) for modules in loaded.values())
    rows = store.trials.set_index("trial")
    assert rows["trajectory_hash"].to_dict() == local
    assert (rows["cpu_per_sim_s"] > 0).all()
    assert set(rows["clocked_on"]) == set(rows["answered_on"]) == {machine_digest(fingerprint())}
    # What else a folder has is written by who called; files of trials, tables and journal are as they have to be.
    assert [p for p in problems(tmp_path / "far") if p.path.name not in ("junit.xml", "summary.md")] == []


def test_cells_of_a_worker_that_is_killed_half_way_run_elsewhere_once(
    trials: list[Trial], local: dict[str, str | None], cluster: Any, tmp_path: Path
) -> None:
    import distributed

    with Workplace(cluster.scheduler_address) as workplace, distributed.Client(cluster.scheduler_address) as client:
        answers, records = workplace.answers(trials, tmp_path), list[Record]()
        for record in answers:
            records.append(record)
            if len(records) == 2:
                os.kill(min(client.run(os.getpid).values()), signal.SIGKILL)
    assert len(records) == len(trials)
    assert _hashes(iter(records)) == local
    assert {path.stem for path in (tmp_path / "trajectories").glob("*.npz")} == set(local.values()) - {None}


def test_a_worker_with_another_version_of_the_engine_is_refused(trials: list[Trial], cluster: Any, tmp_path: Path) -> None:
    with Workplace(cluster.scheduler_address) as workplace, pytest.raises(OtherPlumbline, match=r"the coordinator 0\.0\.1"):
        list(workplace.answers([replace(trials[0], engine_version="0.0.1").named()], tmp_path))


def test_no_scheduler_is_said_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("plumbline.harness.run.cluster.workplace._CONNECTS", 1.0)
    with pytest.raises(NoScheduler, match="no scheduler answers"):
        Workplace("tcp://127.0.0.1:9")


class _Far:
    """A scheduler and a worker, each a process of its own, as on machines of their own."""

    def __init__(self, folder: Path) -> None:
        told = folder / f"scheduler-{time.monotonic_ns()}.json"
        dask = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
        quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.scheduler = subprocess.Popen(
            [*dask, "--port", "0", "--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(told)], **quiet
        )
        until = time.monotonic() + 120
        while not told.exists() and time.monotonic() < until:
            time.sleep(0.1)
        self.address = str(json.loads(told.read_text())["address"])
        command = [sys.executable, "-m", "distributed.cli.dask_worker", self.address, "--nthreads", "1", "--no-dashboard"]
        self.worker = subprocess.Popen(
            [*command, "--death-timeout", "20", "--local-directory", str(folder)], cwd=Path(__file__).parents[2], **quiet
        )

    def end(self) -> None:
        for process in (self.worker, self.scheduler):
            process.terminate()
            process.wait(60)


def test_a_scheduler_that_is_killed_costs_nothing_that_had_finished(local: dict[str, str | None], tmp_path: Path) -> None:
    (tmp_path / "far.toml").write_text(TOML.replace("samples = 1", "timing = false"))
    out = tmp_path / "out"
    command = [sys.executable, "-m", "plumbline", "run", str(tmp_path / "far.toml"), "--out", str(out), "--scheduler"]
    first = _Far(tmp_path)
    try:
        run = subprocess.Popen([*command, first.address], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while run.poll() is None and (not (out / "journal.jsonl").exists() or len(read_journal(out / "journal.jsonl")) < 2):
            time.sleep(0.2)
        first.scheduler.kill()
        said = run.communicate(timeout=300)[1]
    finally:
        first.end()
    assert run.returncode == 3
    assert "the scheduler is gone" in said
    assert "--resume" in said
    before = read_journal(out / "journal.jsonl")
    assert 2 <= len(before) < len(local)
    second = _Far(tmp_path)
    try:
        done = subprocess.run([*command, second.address, "--resume"], capture_output=True, text=True, timeout=600, check=False)
    finally:
        second.end()
    assert done.returncode == 0, done.stderr
    after = read_journal(out / "journal.jsonl")
    assert len(after) == len(local)
    assert {name: after[name].trajectory_hash for name in before} == {n: r.trajectory_hash for n, r in before.items()}
    assert sorted(map(str, (r.trajectory_hash for r in after.values()))) == sorted(map(str, local.values()))
