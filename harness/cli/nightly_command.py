"""The command of every night: carry it out within its budget, say what changed, keep it."""

import math
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, redirect_stderr
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plumbline.api.engines import chosen_engines
from plumbline.harness.cli.diff_command import write_changes
from plumbline.harness.cli.guard import GATE, INTERRUPTED, USAGE, say, stop
from plumbline.harness.cli.options import Seconds, agreed
from plumbline.harness.intake.safe_text import quoted

if TYPE_CHECKING:
    from plumbline.harness.history.changes_since import News
    from plumbline.harness.history.folder import History
    from plumbline.harness.history.night_policy import NightWish, Steering
    from plumbline.harness.history.remote_storage import Elsewhere

_UNBOUNDED = 86400.0
"""Seconds that a night without a budget may hold an address for."""
_SPARE = 3600.0
"""Seconds beyond its budget; and for which a command that is notified may run, where there is none."""
_LEAST = 10.0
"""Seconds that such a command has at least."""


@click.command()
@click.option("--history", "address", metavar="DIR", help="Where it is kept: a folder, or what fsspec reaches.")
@click.option("--budget", type=Seconds(10.0, 7 * 86400.0), metavar="T", help="Wall time for all of it: 30m, 2h [no end].")
@click.option("--engine", "engines", multiple=True, help="Only this engine, or its ==VERSION or =WHEEL; may be repeated.")
@click.option("--gate", "gated", multiple=True, metavar="ENGINE",
              help="Exit 1 where it is worse; may be repeated [the reference engine].")  # fmt: skip
@click.option("--judged", "least", type=click.FloatRange(0.0, 1.0), default=0.0, metavar="SHARE",
              help="Exit 1 where less could be judged, of answers or prices of gated engines, like 0.9.")  # fmt: skip
@click.option("--case", "globs", multiple=True, metavar="GLOB", help="Only cases of this pattern; may be repeated.")
@click.option("--study", default="nightly", show_default=True, help="Another study, built in or a file.")
@click.option("--workers", type=click.IntRange(1, 1024), default=2, show_default=True, help="Accuracy runs side by side.")
@click.option("--keep", type=click.Choice(["all", "changed", "none"]), default="changed", show_default=True,
              help="Trajectories and recordings: of all, without those of what passed as before, of none.")  # fmt: skip
@click.option("--notify", metavar="CMD", help="A shell command that is given summary.md on its standard input.")
@click.option("--seed", default="", metavar="TEXT", help="Of what is drawn at random [the night's name].")
@click.option("--report/--no-report", "reported", default=True, show_default=True, help="Write the pages too.")
@agreed
@click.option("--drill", "drilled", is_flag=True, help="Plant two faults in nights of their own: exit 0 where both are named.")
def nightly(address: str | None, budget: float | None, notify: str | None, reported: bool, drilled: bool, **given: Any) -> None:
    """Run what a night's budget allows, recall what is known, and say what changed since it was last seen."""
    from plumbline.harness.history.folder import created, locked
    from plumbline.harness.history.remote_storage import copy_of, is_elsewhere

    if drilled:
        _drill(given["engines"])
        return
    if address is None:
        raise click.MissingParameter(param_hint="--history", param_type="option")
    asked = _asked(budget=math.inf if budget is None else budget, **given)
    elsewhere = copy_of(address) if is_elsewhere(address) else None
    root = Path(address) if elsewhere is None else elsewhere.root
    with ExitStack() as held:
        if elsewhere is not None:
            held.enter_context(elsewhere.locked(_UNBOUNDED if budget is None else budget + _SPARE))
            elsewhere.fetch()
        history = created(root)
        held.enter_context(locked(history))
        barred, summary, left = _night(history, asked, elsewhere, reported)
    if notify is not None:
        _notify(notify, summary, left())
    if barred:
        sys.exit(GATE)


def _drill(engines: Sequence[str]) -> None:
    """Two nights of their own, the second with two faults; exit 1 where its gate does not name both."""
    from tempfile import mkdtemp

    from plumbline.harness.history.drill import nights
    from plumbline.harness.study.plugins import version_of

    engine = (
        engines[0] if engines else next(name for name, adapter in chosen_engines(()).items() if version_of(adapter)[1] is None)
    )
    folder = Path(mkdtemp(prefix="plumbline-drill-"))
    say(f"drill: two nights of two cases on {engine}, in {folder}")
    (first, _), (second, named) = nights(folder, engine)
    say(f"first night: exit {first.returncode}; second: exit {second.returncode}")
    for what, seen in named.items():
        say(f"{'named' if seen else 'NOT NAMED'}: {what}{': ' if seen else ''}{seen}")
    if (first.returncode, second.returncode) == (0, GATE) and all(named.values()):
        shutil.rmtree(folder)
        say("this set-up sees a regression")
        return
    failed = first if first.returncode else second
    say((failed.stdout + failed.stderr).strip())
    say(f"this set-up would not see them; {folder} holds both nights: a busier machine needs more samples, or other hours")
    sys.exit(GATE)


def _asked(
    *, study: str, engines: Sequence[str], globs: tuple[str, ...], gated: tuple[str, ...], keep: Any, agreed: bool, **rest: Any
) -> "NightWish":
    from plumbline.api.studies import study_and_cases
    from plumbline.harness.history.night_policy import NightWish
    from plumbline.harness.study.catalogue import describe_engine
    from plumbline.harness.study.engine_versions import asked as as_asked
    from plumbline.harness.study.experiment import StudyError

    try:
        plan, cases = study_and_cases(study, globs)
    except StudyError as error:
        stop(USAGE, str(error))
    adapters = chosen_engines(engines, agreed)
    by_words = {as_asked(name): name for name in adapters}
    gated = tuple(by_words.get(engine, engine) for engine in gated)
    for engine in gated:
        if engine not in adapters:
            raise click.BadParameter(
                f"{quoted(engine)} is not asked, expected some of {', '.join(adapters)}", param_hint="--gate"
            )
    ours = tuple(name for name, adapter in adapters.items() if describe_engine(adapter)["ours"])
    return NightWish(study=plan, cases=cases, adapters=adapters, gated=gated or ours, keep=keep, **rest)


def _night(
    history: "History", asked: "NightWish", elsewhere: "Elsewhere | None", reported: bool
) -> tuple[bool, Path, Callable[[], float]]:
    """Carry it out and close it.

    Returns: does its gate fail, or was a page of the report not made? summary.md; what is left of its budget [s], when called.
    """
    from plumbline.harness.findings.summary import write_summary
    from plumbline.harness.findings.vendor_findings import shelf
    from plumbline.harness.history.changes_since import asked_again, turned
    from plumbline.harness.history.night import accounted, carry_out_night, close, compared, night_to_do
    from plumbline.harness.history.readings import said_by
    from plumbline.harness.history.sentences import lines_of, reasons
    from plumbline.harness.study.experiment import StudyError

    night, not_made = night_to_do(history, asked), list[str]()
    night.folder.mkdir(parents=True, exist_ok=True)
    try:
        with _logged(night.folder / "night.log"):
            done = carry_out_night(history, asked, night)
            ended = time.monotonic()
            write_summary(done.store)
            news = compared(done)
            if news is not None:  # before the report, whose first page leads to it
                write_changes(news.changes, done.store, night.folder / "changes", asked.gated, asked.least)
            if reported and done.budget.rest() < done.budget.closing / 2:
                say(f"no time was left for the pages; plumbline report {night.folder} makes them", err=True)
            elif reported:
                not_made = _present(done, news)
            about = shelf()
            rows = asked_again(about, asked.adapters, done.budget.rest)
            changed = turned(about, rows, [earlier.plan for earlier in history.whole_nights() if earlier != night])
            account = accounted(done, news, time.monotonic() - ended) | {"findings": rows}
            summary = _write_summary(history, done, news, account, changed)
            close(night, account)
            said_by(history, night, done.store)
    except StudyError as error:
        if not (night.folder / "journal.jsonl").exists():
            shutil.rmtree(night.folder)
        stop(USAGE, str(error))
    except KeyboardInterrupt:
        stop(INTERRUPTED, f"interrupted; the same command goes on with the night {night.stamp}")
    if elsewhere is not None:
        elsewhere.send()
    failing = reasons(news, account, asked.gated, asked.least)
    for line in (*lines_of(news, account, changed, failing), *not_made):
        say(line)
    say(str(summary))
    return bool(failing or not_made), summary, done.budget.rest


@contextmanager
def _logged(path: Path) -> Iterator[None]:
    """On a terminal as it is; elsewhere what is said on the way goes to a file, so that a timer's mail holds the outcome."""
    if sys.stderr.isatty():
        yield
        return
    with path.open("a", encoding="utf-8", errors="backslashreplace") as log, redirect_stderr(log):
        yield


def _present(done: "Steering", news: "News | None") -> list[str]:
    """Recordings of what is kept, and the report. Returns: a line for each page that could not be made."""
    from plumbline.reports.html.report import write_report
    from plumbline.reports.recordings import write_recordings

    trials = done.store.trials
    fresh = trials[(trials["recalled"] == "") & trials["trajectory_kept"] & trials["trajectory_hash"].notna()]
    if done.request.keep == "changed" and news is not None:
        changed = {row.trial_b for row in news.changes.rows if row.trial_b}
        fresh = fresh[fresh["trial"].isin(changed)]
    if done.request.keep != "none" and done.request.study.recordings:
        write_recordings(done.night.folder, sorted(set(fresh["case"])))
    return write_report(done.night.folder).sentences()


def _write_summary(
    history: "History", done: "Steering", news: "News | None", account: dict[str, Any], findings: Sequence[str]
) -> Path:
    """What changed, for people. Returns: summary.md."""
    from plumbline.harness.history.identity import acknowledged
    from plumbline.harness.history.sentences import open_since, summary
    from plumbline.harness.store.disk import make_folder, write_atomically

    plans = [night.plan for night in history.whole_nights() if night != done.night]
    standing = open_since(plans, acknowledged(history)[0], () if news is None else news.ended, account["told"])
    path = done.night.folder / "changes" / "summary.md"
    make_folder(path.parent)
    write_atomically(path, summary(news, account, standing, findings).encode())
    return path


def _notify(command: str, summary: Path, left: float) -> None:
    """Give the summary to a command; that it fails is said, and changes nothing. Args: left [s]: of the budget, with which it
    ends, and all that it began."""
    most = min(max(left, _LEAST), _SPARE)
    with subprocess.Popen(command, shell=True, stdin=subprocess.PIPE, start_new_session=True) as process:
        try:
            process.communicate(summary.read_bytes(), most)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            say(f"--notify: ended after {most:.0f} s, with the budget: {command}", err=True)
            return
    if process.returncode:
        say(f"--notify: exit code {process.returncode}: {command}", err=True)
