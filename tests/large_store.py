"""What the report of a large run costs: `python -m tests.large_store [TRIALS] [--keep DIR] [--of DIR] [--browser]`.

A run folder of the nightly study is written through the project's own journal and tables: the trials that the study names,
those that its searches then ask for, and a variant of the ladders, with answers from formulas. Nothing in it says anything of a
real engine, and of a trajectory its hash alone is kept, so that repetitions, which are compared by them, are left out. Then its
report is made, and what that took and how large its pages are is printed; with `--browser` also how soon its front page can be
read from disk, and with `--of` all this of a run that is there already.
"""

import argparse
import hashlib
import math
import resource
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any
from unittest.mock import patch

import tomli_w

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.findings.summary import write_summary
from plumbline.harness.run.campaign import plain_study
from plumbline.harness.search import first_break, front
from plumbline.harness.store import disk
from plumbline.harness.store.journal import Journal, read_journal
from plumbline.harness.store.machine_fingerprint import circumstances, fingerprint, machine_digest
from plumbline.harness.store.record import Measurement, Record, Sample, Status, Timing
from plumbline.harness.store.seal import sealed_json, sealed_toml
from plumbline.harness.store.store import Store, write_json
from plumbline.harness.store.stored_tables import in_order, write_tables
from plumbline.harness.study import plugins
from plumbline.harness.study.catalogue import describe_case, describe_engine
from plumbline.harness.study.provenance import files_of, sources_of
from plumbline.harness.study.study import load_study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import outcome

__all__ = ["write_large_store"]

ENGINES = ("reference", "mujoco", "bullet", "dart")
TRIALS = 10_000


def _share(*parts: object) -> float:
    """A number in 0..1 that is the same in every process."""
    return int(hashlib.sha256(repr(parts).encode()).hexdigest()[:12], 16) / 16**12


def _answer(trial: Trial, case: Case, here: str) -> Record:
    """What an engine of first order would say: error = C dt, cost = K / dt, with one trial in fifty that ends in no answer."""
    lost = _share(trial.trial, "lost")
    if lost < 0.02:
        statuses: tuple[Status, ...] = ("diverged", "unsupported", "timeout", "crashed")
        return outcome(trial, statuses[int(lost * 200)], "made: no answer")
    dt = trial.settings.dt
    error = 10 ** (2 * _share(trial.case, trial.engine, trial.track) - 2) * dt
    measurements, failed = [], []
    for check in case.checks:
        scale = case.scale if check.metric.name == case.headline and case.scale else 1.0
        holds = _share(trial.trial, check.metric.name) > 0.1
        failed += [] if holds else [check.metric.name]
        measurements.append(
            Measurement(
                metric=check.metric.name,
                value=scale * error,
                unit=check.metric.unit,
                at_most=scale * error * (2.0 if holds else 0.2),
                passed=holds,
                because=check.because,
            )
        )
    cost = (1 + 9 * _share(trial.case, trial.engine)) * 1e-5 / dt
    timed = trial.experiment.timing and trial.experiment.limit is None
    clock: dict[str, Any] = {"rough_cost": cost, "rough_ratio": cost, "timing": None}
    if timed:
        samples = [
            Sample(
                process=0,
                block=k,
                steps=1000,
                cpu=1000 * cost * dt * (1 + 0.01 * k),
                wall=1010 * cost * dt,
                canary=1e-3,
                switches=0,
            )
            for k in range(trial.experiment.samples)
        ]
        prices = {"cpu_per_sim_s": cost, "cpu_low": 0.98 * cost, "cpu_high": 1.03 * cost, "wall_per_sim_s": 1.01 * cost}
        prices |= {"cpu_per_unit": cost * dt, "cpu_per_unit_low": 0.98 * cost * dt, "cpu_per_unit_high": 1.03 * cost * dt}
        prices |= {"realtime_factor": 1 / cost}
        clock["timing"] = Timing(
            trial=trial.trial, unit="step", clocked_on=here, unstable_timing=False, samples=tuple(samples), **prices
        )
    return replace(
        outcome(trial, "failed" if failed else "passed", f"made: {', '.join(failed)}" if failed else "every check holds"),
        resolved=trial.settings.plain(),
        sim_seconds=case.duration,
        steps=math.ceil(case.duration / dt),
        substep=dt / (trial.settings.substeps or 1),
        trajectory_hash=hashlib.sha256(repr((trial.question, trial.engine, trial.settings)).encode()).hexdigest()[:16],
        measurements=tuple(measurements),
        trajectory_kept=False,
        answered_on=here,
        **clock,
    )


def _trials(
    known: list[Trial], cases: Mapping[str, Case], adapters: Mapping[str, Adapter], records: Mapping[str, Record], most: int
) -> Iterator[tuple[list[Trial], bool]]:
    """What a study knows, what its searches ask for round by round, then more and more iterations, until there are enough.

    With True once its searches have all that they ask for.
    """
    ladder = [trial for trial in known if trial.experiment.name == "ladder" and trial.track == "tuned"]

    def with_iterations(track: str, iterations: int, search_round: int = 0) -> list[Trial]:
        return [
            trial.probing(
                cases[trial.case],
                track=track,
                base="tuned",
                settings=replace(trial.settings, iterations=iterations),
                round=search_round,
            )
            for trial in ladder
        ]

    batch = known + with_iterations("few", 7)
    while batch and len(records) < most:
        yield batch[: most - len(records)], False
        searched = dict(records)
        batch = [
            trial for go_on in (front.next_trials, first_break.next_trials) for trial in go_on(known, searched, cases, adapters)
        ]
        known = known + batch
    for iterations in count(8):
        if len(records) >= most:
            return
        yield with_iterations(f"tuned, iterations {iterations}", iterations, search_round=8)[: most - len(records)], True


@contextmanager
def unsynchronised() -> Iterator[None]:
    """What is written is not waited for: a folder that is made for a measurement need not outlive a power cut."""
    with patch.object(disk.Calls, "sync", lambda _calls, _descriptor: None):
        yield


def write_large_store(folder: Path, most: int = TRIALS) -> int:
    """Write the run folder; returns how many trials it holds."""
    adapters = {name: plugins.adapter(name) for name in ENGINES}
    cases, whole = dict(plugins.cases()), load_study("nightly")
    # Repetitions are compared by their trajectories, of which there are none.
    study = replace(whole, experiments=tuple(each for each in whole.experiments if not each.determinism))
    versions = {name: plugins.version_of(adapter)[0] for name, adapter in adapters.items()}
    known = list(study.trials(cases, adapters, versions, sources_of))
    folder.mkdir(parents=True, exist_ok=True)
    journal, complete, here = Journal(folder), False, machine_digest(fingerprint())
    try:
        for batch, searched in _trials(known, cases, adapters, journal.records, most):
            complete = searched
            for trial in batch:
                if trial.trial not in journal.records:
                    journal.append(_answer(trial, cases[trial.case], here))
        stored = len(journal.records)
        engines = {name: describe_engine(adapter) for name, adapter in adapters.items()}
        described = {"cases": {name: describe_case(case) for name, case in cases.items()}, "engines": engines}
        catalogue = sealed_json("catalogue.json", described)
        journal.begin(
            {
                "study": plain_study(study),
                "machine": circumstances(fingerprint()),
                "engines": versions,
                "files": files_of(set(cases), adapters),
                "catalogue": hashlib.sha256(catalogue).hexdigest(),
                "trials": sorted({*journal.records, *(trial.trial for trial in known)}),
            }
        )
    finally:
        journal.close()
    (folder / "study.toml").write_bytes(sealed_toml("study.toml", tomli_w.dumps(plain_study(study))))
    (folder / "catalogue.json").write_bytes(catalogue)
    ended = {"journal": journal.written.reached, "tables": write_tables(folder, in_order(journal.records.values()))}
    write_json(folder / "machine.json", fingerprint() | {"complete": complete} | ended)
    write_summary(Store(folder))
    return stored


READABLE = """() => {
  const [visit] = performance.getEntriesByType("navigation"), paint = performance.getEntriesByName("first-contentful-paint")[0];
  return [paint.startTime, visit.domInteractive, performance.now()];
}"""
DRAWN = "() => [...document.querySelectorAll('figure.chart')].every(one => one.dataset.drawn || !one.clientWidth)"


def print_readable(page: Path) -> None:
    """Open a page from disk in Chromium three times and print how soon it shows something, is whole, and has its charts."""
    from playwright.sync_api import sync_playwright

    from tests.browser.conftest import CHROMIUM, QUIET

    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=[*QUIET, "--disable-gpu"])
        for _ in range(3):
            tab = browser.new_context(viewport={"width": 1440, "height": 900}).new_page()
            tab.goto(page.as_uri(), wait_until="commit")
            tab.wait_for_load_state()
            tab.wait_for_function(DRAWN, timeout=60_000)
            painted, interactive, drawn = (1e-3 * float(value) for value in tab.evaluate(READABLE))
            print(f"front page: first paint {painted:.2f} s, DOM interactive {interactive:.2f} s, charts drawn {drawn:.2f} s")
            tab.context.close()
        browser.close()


def print_report(folder: Path, count: int) -> Path:
    """Make the report of a folder, and print what that took and the sizes of its pages; returns its front page."""
    from plumbline.reports.html.report import write_report

    before, wall = time.process_time(), time.perf_counter()
    index = write_report(folder).index
    spent, wall = time.process_time() - before, time.perf_counter() - wall
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{count} trials: report in {spent:.1f} CPU s, {wall:.1f} s; peak {peak:.0f} MB")
    pages = sorted((path for path in index.parent.rglob("*") if path.is_file()), key=lambda path: -path.stat().st_size)
    whole = sum(path.stat().st_size for path in pages)
    print(f"front page {index.stat().st_size / 1e6:.2f} MB; {len(pages)} files, {whole / 1e6:.0f} MB")
    for path in [path for path in pages if path.suffix == ".html"][:6]:
        print(f"  {path.stat().st_size / 1e6:6.2f} MB  {path.name}")
    return index


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trials", nargs="?", type=int, default=TRIALS)
    parser.add_argument("--keep", type=Path, help="A new folder for the run; a temporary one unless said.")
    parser.add_argument("--of", type=Path, help="A run folder that is there already; its report is made anew.")
    parser.add_argument(
        "--browser", action="store_true", help="Open the front page in Chromium, and print how soon it is there."
    )
    parser.add_argument("--no-report", action="store_true", help="Write the folder alone.")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.of or given.keep or Path(scratch) / "run"
        if given.of:
            stored = len(read_journal(folder / "journal.jsonl"))
        else:
            with unsynchronised():
                stored = write_large_store(folder, given.trials)
        if not given.no_report:
            front = print_report(folder, stored)
            if given.browser:
                print_readable(front)
