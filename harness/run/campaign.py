"""Carrying out a study into a run folder: accuracy runs first, then timing runs, every result on disk as it comes."""

import hashlib
import random
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from functools import partial
from itertools import chain, groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import tomli_w

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.case.alteration import ALONE
from plumbline.harness.case.undropped import called
from plumbline.harness.run.fork_servers import expect, preloads
from plumbline.harness.run.interrupt import TimeIsUp, stop_if_asked
from plumbline.harness.run.isolated import run_isolated
from plumbline.harness.run.known_results import UNGUIDED, Guide
from plumbline.harness.run.resume import another_study, clear_drafts, clocked_elsewhere, kept_answers, merged, review
from plumbline.harness.run.timing_protocol import clock_group, clock_time, together
from plumbline.harness.run.waiting_time import Progress
from plumbline.harness.search import dominance, first_break, front, needless_effects, refined_ladder
from plumbline.harness.store import disk
from plumbline.harness.store.journal import FolderTaken, Journal, StoreError, refuse_links
from plumbline.harness.store.machine_fingerprint import circumstances, fingerprint, machine_digest
from plumbline.harness.store.record import Record, Timing
from plumbline.harness.store.seal import sealed_json, sealed_toml
from plumbline.harness.store.store import Store, read_plain, write_json
from plumbline.harness.store.stored_tables import in_order, write_tables
from plumbline.harness.study.catalogue import describe_case, describe_engine
from plumbline.harness.study.experiment import StudyError
from plumbline.harness.study.plugins import version_of
from plumbline.harness.study.provenance import files_of, sources_of
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import outcome

if TYPE_CHECKING:
    from plumbline.harness.run.cluster.workplace import Workplace

Shard = tuple[int, int]
"""(i, n): the i-th of n parts, from 1."""

_TIMED = ("passed", "failed")


def plain_study(study: Study) -> dict[str, Any]:
    """As a session and study.toml have it."""

    def without_none(value: Any) -> Any:
        """Without what is left open: TOML has no word for nothing."""
        if isinstance(value, dict):
            return {name: without_none(element) for name, element in value.items() if element is not None}
        return [without_none(element) for element in value] if isinstance(value, list | tuple) else value

    plain: dict[str, Any] = without_none(asdict(study))
    return plain


@dataclass(frozen=True, slots=True, kw_only=True)
class _Run:
    """What every step of carrying out a study needs.

    Terms: reasons: of each engine, why it is unavailable, or None. machine: the fingerprint of who clocks.
    """

    folder: Path
    journal: Journal
    cases: Mapping[str, Case]
    adapters: Mapping[str, Adapter]
    reasons: Mapping[str, str | None]
    workers: int
    machine: Mapping[str, Any]
    cluster: "Workplace | None"
    guide: Guide


def _accuracy(run: _Run, what: str, trials: Sequence[Trial]) -> None:
    journal, guide, cluster = run.journal, run.guide, run.cluster
    machine = machine_digest(run.machine)
    waiting = [trial for trial in trials if trial.trial not in journal.records]
    unavailable = {trial.trial: reason for trial in waiting if (reason := run.reasons[trial.engine]) is not None}
    for trial in waiting:
        if trial.trial in unavailable:
            journal.append(outcome(trial, "unavailable", unavailable[trial.trial]))
    for trial in waiting:
        if trial.trial not in unavailable and (known := guide.known(trial)) is not None:
            journal.append(known)
    waiting = [trial for trial in waiting if trial.trial not in journal.records]
    if not waiting:
        return
    by_name = {trial.trial: trial for trial in waiting}
    kept = kept_answers(journal, waiting, guide) if cluster is None else {}
    alone = [trial for trial in waiting if trial.alteration.name == ALONE]
    beside = [trial for trial in waiting if trial.alteration.name != ALONE and trial.trial not in kept]
    lost: list[str] = []

    def answers(group: Sequence[Trial], side: int, at_once: int) -> Iterator[Record]:
        return run_isolated(group, run.folder, side) if cluster is None else cluster.answers(group, run.folder, at_once)

    with Progress(what, len(waiting)) as progress:
        anew = run_isolated([by_name[name] for name in kept], run.folder, run.workers, earlier=kept) if kept else ()
        for record in chain(anew, answers(beside, run.workers, 0), answers(alone, 1, 1)):
            if record.status == "interrupted":
                lost.append(record.reason)
            else:
                before = kept[record.trial] if record.simulated_as else None
                where = record.answered_on or machine if before is None else before.answered_on
                journal.append(guide.answered(by_name[record.trial], replace(record, answered_on=where)))
                if before is not None and before.timing is not None and record.status in _TIMED:
                    journal.append(replace(before.timing, trial=record.trial))
            progress.advance(f"{called(record.case)} {record.engine}/{record.track} {record.status}")
    if lost:
        raise StoreError(f"{len(lost)} of {len(waiting)} answers could not be kept, first: {lost[0]}")


def _timing(run: _Run, trials: Sequence[Trial]) -> None:
    journal, cases, guide, cluster = run.journal, run.cases, run.guide, run.cluster
    records, here = dict(journal.records), machine_digest(run.machine)
    near = front.due_for_clock(trials, records, cases) | dominance.due_for_clock(trials, records, cases)
    due = [
        trial
        for trial in trials
        if trial.experiment.timing
        and trial.alteration.clocked
        and (not (trial.experiment.sweep or trial.experiment.dominance) or trial.trial in near)
        and trial.trial in records
        and journal.written.clocked_on(trial.trial) != here
        and records[trial.trial].status in _TIMED
    ]
    wanted = guide.clocks(due, records)
    due = [trial for trial in due if trial.trial in wanted]
    _say(clocked_elsewhere(journal, [trial.trial for trial in due], run.machine))
    order: dict[tuple[object, ...], int] = {}
    due.sort(key=lambda trial: order.setdefault(together(trial), len(order)))
    shuffle, troubles = random.Random(0), list[str]()
    with Progress("timing", len(due)) as progress:
        groups = [tuple(group) for _, group in groupby(due, key=together)]
        if cluster is None:
            foreseen = {trial.trial: clock_time(trial, records[trial.trial], cases[trial.case]) for trial in due}
            groups = list(_sittings(groups, guide.sitting, foreseen))
            clocked = _one_by_one(groups, run.folder, partial(clock_group, shuffle=shuffle, say=progress.tell), guide)
        else:
            clocked = cluster.clocked(groups, run.folder)
        for timing in clocked:
            journal.append(replace(timing, clocked_on=here))
            troubles += [timing.note] if timing.note else []
            progress.advance(f"{called(records[timing.trial].case)} {records[timing.trial].engine}")
    if troubles:
        print(f"timing: trouble in {len(troubles)} of {len(due)} trials, first: {troubles[0]}", file=sys.stderr)


def _sittings(groups: Sequence[tuple[Trial, ...]], seconds: float, times: Mapping[str, float]) -> Iterator[tuple[Trial, ...]]:
    """Questions of one experiment that are clocked in one sitting: as many as are foreseen to take so long, one at least."""
    sitting, left = tuple[Trial, ...](), seconds
    for group in groups:
        left -= (foreseen := sum(times[trial.trial] for trial in group))
        if sitting and (left < 0 or group[0].experiment != sitting[0].experiment):
            yield sitting
            sitting, left = (), seconds - foreseen
        sitting += group
    if sitting:
        yield sitting


def _one_by_one(
    sittings: Sequence[tuple[Trial, ...]], folder: Path, clock: Callable[..., Iterator[Timing]], guide: Guide
) -> Iterator[Timing]:
    for sitting in sittings:
        stop_if_asked()
        timings = list(clock(sitting, folder))
        guide.clocked(sitting)
        if guide.doubts(timings):
            again = list(clock(sitting, folder))
            guide.clocked(sitting)
            timings = min(timings, again, key=lambda each: sum(bool(timing.unstable_timing) for timing in each))
        yield from timings


def _say(notes: Sequence[str]) -> None:
    for note in notes:
        print(note, file=sys.stderr)


def share(trials: Sequence[Trial], shard: Shard) -> list[Trial]:
    """One of n parts: every n-th trial, but of what is clocked every n-th question, of a search for settings every n-th case.

    Each with all engines.
    """

    def searching(trial: Trial) -> bool:
        return bool(trial.experiment.sweep or trial.experiment.dominance)

    def dealt_by(trial: Trial) -> tuple[object, ...]:
        if searching(trial):
            return "searched", trial.case
        return ("clocked", *together(trial)) if trial.experiment.timing else ("plain", trial.trial)

    number, parts = shard
    places: dict[object, dict[tuple[object, ...], int]] = {kind: {} for kind in ("searched", "clocked", "plain")}
    mine = []
    for trial in trials:
        kind, *what = dealt_by(trial)
        place = places[kind].setdefault(tuple(what), len(places[kind]))
        if place % parts == number - 1:
            mine.append(trial)
    return sorted(mine, key=searching)


def _searched(run: _Run, trials: list[Trial]) -> list[Trial]:
    """The trials with those that sweeps and limits went on to, round by round, all with a record."""
    journal, guide = run.journal, run.guide
    extended, number = list(trials), 0
    if beside := guide.beside(trials, journal.records):
        _accuracy(run, "searches, where they ended", beside)
        extended += beside
    searches = [
        go_on
        for go_on, wanted in (
            (front.next_trials, any(trial.experiment.sweep for trial in trials)),
            (first_break.next_trials, any(trial.experiment.limit for trial in trials)),
            (dominance.next_trials, any(trial.experiment.dominance for trial in trials)),
            (partial(needless_effects.next_trials, store=Store(run.folder)), any(trial.experiment.effects for trial in trials)),
            (
                partial(
                    refined_ladder.next_trials,
                    store=Store(run.folder),
                    wanted=lambda finer: guide.searches(finer, journal.records),
                ),
                any(trial.experiment.refine for trial in trials),
            ),
        )
        if wanted
    ]
    while searches:
        records = dict(journal.records)
        more = [trial for go_on in searches for trial in go_on(extended, records, run.cases, run.adapters)]
        more = [trial for trial in more if guide.searches(trial, records)]
        if not more:
            break
        number += 1
        _accuracy(run, f"search, round {number}", more)
        extended += more
    return extended


def carry_out(
    study: Study,
    folder: Path,
    cases: Mapping[str, Case],
    adapters: Mapping[str, Adapter],
    *,
    workers: int,
    resume: bool | Literal["merge"],
    shard: Shard = (1, 1),
    cluster: "Workplace | None" = None,
    guide: Guide = UNGUIDED,
) -> Store:
    """Run every trial of a study that the folder does not hold yet.

    The journal grows with each finished run, so a kill loses at most the runs under way. Interrupting leaves the same tables
    as finishing, of what was done.

    Args: resume: whether the folder may hold this study's run, or with 'merge' another's too. What no longer holds in it is
    withdrawn and run anew, and told of on standard error.
    cluster: whose workers answer and clock, in place of `workers` processes here. guide: of a history, which knows some of
    the answers.
    Raises:
        FolderTaken: where the folder holds another run. StoreError: where it is locked or cannot be read, and where an answer
        could not be kept.
        StudyError: where the study leaves no trial.
    """
    if (folder / "journal.jsonl").exists() and not resume:
        raise FolderTaken(f"{folder}: holds a run already; add --resume to go on with it, or choose another --out")
    versions = {name: version_of(adapter)[0] for name, adapter in adapters.items()}
    trials = share(list(study.trials(cases, adapters, versions, sources_of)), shard)
    if not trials:
        raise StudyError(f"study '{study.name}': no trial; its cases and engines, or --case, --engine and --shard, leave none")
    disk.make_folder(folder)
    refuse_links(folder)
    engines = {name: describe_engine(adapter) for name, adapter in adapters.items()}
    # Who clocks is the machine of a run: prices are read with it, answers name theirs one by one.
    plain, machine = plain_study(study), fingerprint()
    machine |= {} if cluster is None else circumstances(cluster.machine)
    here = machine_digest(machine)
    journal = Journal(folder)
    try:
        other = another_study(journal.written, plain)
        if other and resume != "merge":
            raise FolderTaken(f"{folder}: holds {other}; choose another --out, or keep both in it with --resume=merge")
        clear_drafts(folder)
        if journal.written.checksums:
            _say([f"{folder}: {note}" for note in review(journal, folder, trials, cases, versions, here)])
    except BaseException:
        journal.close()
        raise
    complete, stand = False, None
    try:
        chosen = {trial.case for trial in trials}
        catalogue = _catalogue(folder, {n: describe_case(case) for n, case in cases.items() if case.name in chosen}, engines)
        begun: dict[str, Any] = {
            "study": plain,
            "machine": circumstances(machine),
            "engines": versions,
            "files": files_of(chosen, adapters),
            "catalogue": hashlib.sha256(catalogue).hexdigest(),
            "trials": sorted({trial.trial for trial in trials}),
        }
        journal.begin(begun)
        stand = _standing_tables(folder, journal, machine)
        whole = merged([session["study"] for session in journal.written.sessions])
        disk.write_atomically(folder / "study.toml", sealed_toml("study.toml", tomli_w.dumps(whole)))
        disk.write_atomically(folder / "catalogue.json", catalogue)
        write_json(folder / "machine.json", machine | {"journal": journal.written.reached, "complete": False})
        reasons = {name: row["unavailable"] for name, row in engines.items()}
        modules = preloads({case.name: case for case in cases.values() if case.name in chosen}, adapters)
        (expect if cluster is None else cluster.expect)(modules)
        run = _Run(
            folder=folder,
            journal=journal,
            cases=cases,
            adapters=adapters,
            reasons=reasons,
            workers=workers,
            machine=machine,
            cluster=cluster,
            guide=guide,
        )
        try:
            for batch in guide.batches(trials):
                _accuracy(run, "accuracy", batch)
                _timing(run, _searched(run, batch))
        except TimeIsUp as up:
            guide.broken_off(up.under_way)
        journal.begin(begun | {"trials": sorted(guide.asked(begun["trials"], journal.records))})
        complete = True
    finally:
        journal.close()
        if stand is None or stand["journal"] != journal.written.reached:
            digests = write_tables(folder, in_order(journal.records.values()))
            stand = {"journal": journal.written.reached, "tables": digests}
        ended = {"finished": datetime.now(UTC).isoformat(timespec="seconds"), "complete": complete}
        write_json(folder / "machine.json", machine | ended | stand)
    return Store(folder)


def _standing_tables(folder: Path, journal: Journal, machine: Mapping[str, Any]) -> dict[str, Any] | None:
    """What machine.json says of a journal that has not gone on and of its tables, where these are whole and this version
    wrote them; else None."""
    store = Store(folder)
    try:
        written = store.machine
    except StoreError:
        return None
    same = all(written.get(name) == machine[name] for name in ("commit", "packages")) and not machine["commit"].endswith("+")
    if not (same and written.get("journal") == journal.written.reached and store.up_to_date):
        return None
    return {"journal": written["journal"], "tables": written["tables"]}


def _catalogue(folder: Path, cases: Mapping[str, Any], engines: Mapping[str, Any]) -> bytes:
    """The file with the rows of these cases and engines, and with those of others that the folder has."""
    path = folder / "catalogue.json"
    try:
        kept = read_plain(path)
    except StoreError as error:
        _say([f"{error}: written anew"])
        kept = {}
    return sealed_json(path.name, {"cases": kept.get("cases", {}) | cases, "engines": kept.get("engines", {}) | engines})
