"""One night: begun or gone on with, carried out within its budget, compared with what was seen before, and closed."""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

from plumbline.harness.findings.changes import Change
from plumbline.harness.findings.summary import SUMMARIES
from plumbline.harness.history.blocks import cells_of, last_seen
from plumbline.harness.history.budget import bytes_of, memory_peaks
from plumbline.harness.history.changes_since import News, news_of
from plumbline.harness.history.folder import NIGHT, History, Night, stamp_of
from plumbline.harness.history.identity import acknowledged
from plumbline.harness.history.night_policy import NightWish, Steering
from plumbline.harness.history.regressions import Dated, over_nights
from plumbline.harness.history.retention import counted
from plumbline.harness.history.sentences import told
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.run.interrupt import until
from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile, read_journal
from plumbline.harness.store.store import write_json


def night_to_do(history: History, asked: NightWish) -> Night:
    """The last night, where it asked the same, did not come to its end and can be read; otherwise a new one."""
    nights = history.nights()
    last = nights[-1] if nights else None
    if last is not None and not last.whole and last.plan.get("asked") == asked.digest and _damage(last) is None:
        return last
    begins = datetime.now(UTC)
    if nights and nights[-1].stamp >= stamp_of(begins):
        begins = nights[-1].began + timedelta(seconds=1)
    while os.path.lexists(history.night(stamp_of(begins)).folder):  # that of a night which cannot be read
        begins += timedelta(seconds=1)
    return history.night(stamp_of(begins))


def _damage(night: Night) -> DamagedFile | None:
    """Why its records cannot be read; None where they can."""
    try:
        read_journal(night.folder / "journal.jsonl")
    except DamagedFile as error:
        return error
    return None


def _readable(nights: Sequence[Night]) -> tuple[list[Night], list[DamagedFile]]:
    """Nights without those that something was last seen in and that cannot be read; and why these cannot."""
    readable, unread = list(nights), list[DamagedFile]()
    while True:
        wanted = {night for seen in last_seen(readable).values() for night in seen.nights}
        damaged = {night: damage for night in wanted if (damage := _damage(night)) is not None}
        if not damaged:
            return readable, unread
        unread += damaged.values()
        readable = [night for night in readable if night not in damaged]


def carry_out_night(history: History, request: NightWish, night: Night) -> Steering:
    """Answer and clock as much as the budget allows. Who calls this holds the history's lock.

    Args: night: as `night_to_do` gave it.
    Raises: StoreError, StudyError, OSError.
    """
    before, unread = _readable(history.whole_nights())
    unfinished = [other for other in history.nights() if not other.whole and other != night]
    unread += [damage for other in unfinished if (damage := _damage(other)) is not None]
    disk.make_folder(night.folder)
    steering = Steering(history, night, request, before, unread)
    if not night.plan:
        steering.save()
    with until(lambda: steering.budget.end):
        carry_out(
            request.study, night.folder, request.cases, request.adapters, workers=request.workers, resume=True, guide=steering
        )
    steering.close()
    _without_idle_logs(night, set(steering.store.trials["trial"]))
    return steering


def _without_idle_logs(night: Night, recorded: set[str]) -> None:
    """Take away the logs of trials that were under way when time was up: they have no record that would name them."""
    logs = night.folder / "logs"
    for path in logs.glob("*.log"):
        if path.stem not in recorded:
            disk.remove(path)
    if logs.is_dir() and not any(logs.iterdir()):
        logs.rmdir()


def compared(done: Steering) -> News | None:
    """What changed since each block was last seen; None where nothing of the night was seen before. Raises: StoreError."""
    known = acknowledged(done.history)[0]

    def over(rows: Sequence[Change]) -> Sequence[Dated]:
        return over_nights(done.history, done.before, done.night, done.store, known, rows, done.budget.rest())

    return news_of(done.store, done.night.stamp, done.before, done.done, known, _first_told(done.history), over)


def accounted(done: Steering, news: News | None, closing: float) -> dict[str, Any]:
    """What the night's own file says when it is whole. Args: closing [s]: what tables and report took. Raises: StoreError."""
    night, unread = done.night, (*done.history.unread(), *acknowledged(done.history)[1], *done.unread)
    trials, rows = done.store.trials, () if news is None else news.changes.rows
    where = {row.trial: (row.experiment, row.case) for row in trials.itertuples()}
    clocked = trials[trials["cpu_per_unit"] > 0]
    unstable = Counter(where[trial] for trial in clocked["trial"][clocked["unstable_timing"].fillna(value=False).astype(bool)])
    cells = cells_of(trials.itertuples())
    worse = Counter(where[row.trial_b] for row in rows if row.regression and row.trial_b in where)
    changed = [told(row, news.changes, news.since[row]) for row in rows if news and row.sense in ("worse", "better")]
    return {name: value for name, value in night.plan.items() if name != "blocks"} | {
        "gated": list(done.request.gated),
        "least": done.request.least,
        "complete": True,
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "seconds": {"whole": done.budget.taken(), "closing": closing, "set_aside": done.budget.closing, "slow": done.slow},
        "memory_mb": memory_peaks(),
        "bytes": _bytes(done.history, night),
        **counted(trials, sum(row.kind == "digest" for row in rows)),
        "blocks": [row | {"saw": cells.get((row["experiment"], row["case"]), {})} for row in done.sights(unstable, worse)],
        "outcomes": {
            str(engine): {str(status): int(count) for status, count in of["status"].value_counts().items()}
            for engine, of in trials.groupby("engine", sort=False)
        },
        "versions": {engine: saw["version"] for of in cells.values() for engine, saw in of.items() if saw["version"]},
        "unconfirmed": [told(row, news.changes, night.stamp) for row in rows if news and row.sense == "unconfirmed"],
        "unread": [str(error) for error in unread],
        "summaries": {name: disk.digest(path) for name in SUMMARIES if (path := night.folder / name).is_file()},
        "left_out": done.out,
        "unanswered": done.unanswered,
        "distrusted": [[*cell, stamp] for cell, stamp in done.distrusted.items()],
        "told": changed,
    }


def close(night: Night, account: Mapping[str, Any]) -> None:
    """Write the night's own file, by which it is whole. Raises: OSError."""
    write_json(night.folder / NIGHT, account)


def _first_told(history: History) -> dict[str, str]:
    """The first nights of disagreements, which last until the digest is another: by what they are called without a night."""
    earlier: dict[str, str] = {}
    for night in history.whole_nights():
        for row in night.plan.get("told", ()):
            if row["kind"] == "digest":
                earlier.setdefault(row["lasting"], row["first_seen"])
    return earlier


def _bytes(history: History, night: Night) -> dict[str, int]:
    """What lies on the disk, by what it is; a trajectory that the pool keeps too counts there alone."""
    parts = ("trajectories", "recordings", "report", "truths")
    sizes = {name: bytes_of([night.folder / name], shared=False) for name in parts}
    return {"night": bytes_of([night.folder], shared=False), **sizes, "pool": bytes_of([history.pool])}
