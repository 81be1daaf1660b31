"""What a cell costs the coordinator of a cluster: `python -m tests.coordinator_cost [CELLS]`.

A scheduler in this process, two workers, and cells that do nothing: what is left is handing out, gathering, and the journal
with its synchronised line for each. The CPU time is that of this process, scheduler and all its threads included.
"""

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from plumbline.harness.run.cluster.cells import Answered
from plumbline.harness.run.cluster.workplace import Workplace
from plumbline.harness.store.journal import Journal
from plumbline.harness.store.record import plain
from plumbline.harness.store.stored_tables import in_order, write_tables
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.provenance import sources_of
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import outcome

__all__: list[str] = []


def nothing(trial: Trial, *_: object, **_of_run: object) -> Answered:
    """A cell that does nothing."""
    return Answered(plain(outcome(trial, "unsupported", "nothing was asked")), {})


def main(cells: int) -> None:
    """Print the CPU and wall time that a cell costs, and what the tables cost behind them."""
    from distributed import LocalCluster

    adapters, cases = {"mujoco": plugins.adapter("mujoco")}, {"flight_box": plugins.case("flight_box")}
    study = Study(name="nothing", experiments=(Experiment(name="nothing", tracks=("tuned",)),))
    versions = {"mujoco": plugins.version_of(adapters["mujoco"])[0]}
    (first,) = study.trials(cases, adapters, versions, sources_of)
    trials = [replace(first, seed=number).named() for number in range(cells)]
    with (
        tempfile.TemporaryDirectory() as scratch,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Workplace(cluster.scheduler_address) as workplace,
    ):
        journal = Journal(Path(scratch))
        wall, cpu = time.perf_counter(), time.process_time()
        for record in workplace.answers(trials, Path(scratch), answer=nothing):
            journal.append(record)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        journal.close()
        tables = time.process_time()
        write_tables(Path(scratch), in_order(journal.records.values()))
        tables = time.process_time() - tables
        size = (Path(scratch) / "journal.jsonl").stat().st_size
    print(f"{cells} cells: {1e3 * cpu / cells:.2f} ms of CPU and {1e3 * wall / cells:.2f} ms each")
    print(f"journal: {size / cells:.0f} bytes a cell; tables: {1e3 * tables / cells:.3f} ms of CPU a cell")


if __name__ == "__main__":
    from tests import coordinator_cost

    coordinator_cost.main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
