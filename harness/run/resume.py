"""Resuming a run: which of a folder's records still hold, which are withdrawn and why, and what is clocked anew.

A record holds where its trial's name, which covers all that decides an answer, is that of a trial of today, or where nothing
that it rests on has changed; and where its trajectory is as it was written. Where what changed judges and does not move, the
trajectory is judged anew; where there is none, the trial is run anew.
"""

import json
import re
import shutil
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from plumbline.harness.case.alteration import ALONE
from plumbline.harness.run.known_results import Guide
from plumbline.harness.store import disk
from plumbline.harness.store.journal import Journal, LineChain, StoreError
from plumbline.harness.store.machine_fingerprint import circumstances, machine_digest
from plumbline.harness.store.record import Record
from plumbline.harness.store.seal import Damaged, read_sealed
from plumbline.harness.store.store import ends_early, read_plain
from plumbline.harness.study.library_variants import obstacle
from plumbline.harness.study.provenance import moves_alike, what_changed
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import outcome

_DRAFT = re.compile(r"\..+\.\d+(\.old)?|\.timing-\w+\.log")


def damage(folder: Path, record: Record) -> str:
    """What is wrong with the trajectory that a record names; '' where nothing is."""
    if record.trajectory_hash is None or not record.trajectory_kept:
        return ""
    path = folder / "trajectories" / f"{record.trajectory_hash}.npz"
    try:
        read_sealed(path)
    except FileNotFoundError:
        return f"{path} is missing"
    except Damaged as error:
        return f"{path} is damaged: {error}"
    return ""


def kept_answers(journal: Journal, trials: Iterable[Trial], guide: Guide) -> dict[str, Record]:
    """By trial without a record, one of the same motion, withdrawn or known to the guide, whose trajectory was kept: that can
    be judged anew.

    An ensemble keeps that of one member alone; libraries that variables tell something act on who judges too.
    """
    lost = {
        record.motion: record for record in journal.written.lost.values() if record.trajectory_hash and record.trajectory_kept
    }
    plain = (trial for trial in trials if trial.trial not in journal.records and judged_alone(trial))
    return {trial.trial: known for trial in plain if (known := lost.get(trial.motion) or guide.alike(trial)) is not None}


def judged_alone(trial: Trial) -> bool:
    """Can the answer of a trial be judged without simulating it? Where it cannot after all, it is simulated beside others."""
    return trial.motion != "" and trial.members == 1 and not trial.alteration.variables and trial.alteration.name != ALONE


def _differences(value: Any, other: Any, where: str) -> list[str]:
    """The places at which two studies differ."""
    if isinstance(value, dict) and isinstance(other, dict):
        names = sorted({*value, *other})
        return [d for name in names for d in _differences(value.get(name), other.get(name), f"{where}.{name}".strip("."))]
    if isinstance(value, list) and isinstance(other, list) and len(value) == len(other):
        return [d for k, (a, b) in enumerate(zip(value, other, strict=True)) for d in _differences(a, b, f"{where}[{k}]")]
    # A switch that an older study has no word for is off.
    return [] if value == other or not (value or other) else [where]


def another_study(journal: LineChain[Any], study: Mapping[str, Any]) -> str:
    """How the study of a folder differs from this one, in words; '' where the folder is of this study too."""
    known = [session["study"] for session in journal.sessions]
    today = json.loads(json.dumps(study))
    differences = [_differences(other, today, "") for other in known]
    if not differences or [] in differences:
        return ""
    least = min(differences, key=len)
    return f"a run of study '{known[differences.index(least)].get('name')}', which differs in {', '.join(least[:5])}"


def merged(studies: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The last study with the experiments and variants of the others that it has not."""
    *others, last = studies
    experiments, variants = [*last.get("experiments", ())], dict(last.get("variants", {}))
    for other in others:
        experiments += [experiment for experiment in other.get("experiments", ()) if experiment not in experiments]
        variants = {**other.get("variants", {}), **variants}
    return {**last, "experiments": experiments, "variants": variants}


def clocked_elsewhere(journal: Journal, trials: Collection[str], machine: Mapping[str, Any]) -> list[str]:
    """In sentences, how many of these trials are clocked anew since another machine clocked them, and how that one differs."""
    counts: Counter[str] = Counter()
    for name in trials:
        if (clocked_on := journal.written.clocked_on(name)) not in (None, machine_digest(machine)):
            counts[_other_machine(journal, str(clocked_on), machine)] += 1
    return [f"clocks anew {count}: clocked on another machine ({how})" for how, count in counts.items()]


def _other_machine(journal: Journal, digest: str, machine: Mapping[str, Any]) -> str:
    today = circumstances(machine)
    for session in journal.written.sessions:
        if machine_digest(session["machine"]) == digest:
            was = circumstances(session["machine"])
            return ", ".join(f"{name} {was[name]} -> {today[name]}" for name in today if was[name] != today[name])
    return "which is not known"


def clear_drafts(folder: Path) -> None:
    """Take away what a kill left half written. Raises: OSError."""
    for directory in (folder, folder / "trajectories", folder / "truths", folder / "recordings"):
        for path in directory.glob(".*"):
            if _DRAFT.fullmatch(path.name) and path.is_dir():
                shutil.rmtree(path)
            elif _DRAFT.fullmatch(path.name):
                disk.remove(path)


def _reason(record: Record, cells: Mapping[str, Trial], versions: Mapping[str, str], journal: Journal) -> str:
    """Why a record does not hold today; '' where it does."""
    number = journal.written.made_in[record.trial]
    files = journal.written.sessions[number].get("files", {}) if number >= 0 else {}
    reason = what_changed(record.case, record.engine, record.sources, files)
    if record.engine_version != versions[record.engine]:
        change = f"{record.engine}: version {record.engine_version} -> {versions[record.engine]}"
        reason = f"{change}; {reason}" if reason else change
    today = cells.get(record.cell())
    if not reason and today is not None and today.trial != record.trial:
        reason = f"{record.case} asks something else, or {record.engine}'s settings of track '{record.track}' are others"
    return reason


def _moves_alike(record: Record, versions: Mapping[str, str]) -> bool:
    """May a search that proposes the trial of a record again judge its answer anew, as far as sources tell?"""
    alike = record.engine_version == versions[record.engine] and record.members == 1 and bool(record.motion)
    return alike and moves_alike(record.case, record.engine, record.sources)


def _possible_now(record: Record) -> str:
    """Why a run that the environment or the processor ruled out is made after all; '' if it was made, or is ruled out still."""
    variables = tuple(record.alteration.get("variables", {}).items())
    ruled_out = bool(variables) and record.status == "unavailable" and record.engine_version != "none"
    return f"{record.reason}: no longer so" if ruled_out and not obstacle(variables) else ""


def review(
    journal: Journal, folder: Path, trials: Sequence[Trial], cases: Collection[str], versions: Mapping[str, str], machine: str
) -> list[str]:
    """Withdraw what does not hold, bring back what holds again, and say what is kept, and what is judged, run and clocked anew.

    Args: cases: names of those that are asked about; versions: of the engines asked; machine: today's digest.
    Raises: StoreError, OSError.
    """
    notes = [*journal.notes, *_ended(journal, folder)]
    planned = {trial.trial for trial in trials}
    journal.restore([n for n in planned if n in journal.written.withdrawn and not damage(folder, journal.written.lost[n])])
    cells = {outcome(trial, "interrupted", "").cell(): trial for trial in trials if trial.round == 0}
    stale: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    motions = {trial.motion for trial in trials if judged_alone(trial)}
    beside: Counter[str] = Counter()
    for record in journal.records.values():
        if record.trial not in planned:
            if record.case not in cases or record.engine not in versions:
                beside[f"{record.engine} {record.engine_version}"] += 1
                continue
            if reason := _reason(record, cells, versions, journal):
                anew = record.motion in motions or (record.round > 0 and _moves_alike(record, versions))
                keeps = record.trajectory_hash is not None and record.trajectory_kept and not damage(folder, record)
                stale["judges" if anew and keeps else "runs", reason].append(record.trial)
                continue
        if reason := (record.trial in planned and _possible_now(record)) or damage(folder, record):
            stale["runs", reason].append(record.trial)
    for (verb, reason), names in stale.items():
        journal.withdraw(names, reason)
        notes.append(f"{verb} anew {len(names)}: {reason}")
    notes += _mended_truths(folder)
    rough = sum(record.rough_cost is not None and record.answered_on != machine for record in journal.records.values())
    if rough:
        notes.append(f"keeps {rough} rough costs of another machine, named in the column answered_on")
    left = sum(beside.values())
    kept = f"keeps {len(journal.records)} of {len(journal.records) + sum(map(len, stale.values()))} trials"
    if left:
        kept += f", {left} of them beside what is asked now ({', '.join(sorted(beside))})"
    return [*notes, kept]


def _ended(journal: Journal, folder: Path) -> list[str]:
    """Whether the journal lost lines at its end, as far as machine.json can tell."""
    try:
        early = ends_early(journal.written, read_plain(folder / "machine.json"))
        return [f"{journal.written.path}: {early}"] if early else []
    except StoreError as error:
        return [str(error)]


def _mended_truths(folder: Path) -> list[str]:
    """Take damaged truths away: each is made again when it is wanted."""
    notices = []
    for path in sorted((folder / "truths").glob("[!.]*")):
        try:
            read_sealed(path)
        except (Damaged, KeyError) as error:
            disk.remove(path)
            notices.append(f"{path} was damaged ({error}): removed, and made again when it is wanted")
    return notices
