"""Commands on what is installed: the engines, the cases, the conformance kit for one adapter, and what engines compile
beforehand.
"""

import os
import sys
import time
from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import GATE, MACHINE, say, stop
from plumbline.harness.cli.listing import print_json, print_table
from plumbline.harness.cli.options import DAY, Age, agreed, json_rows

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter

_ORDER = {"failed": 0, "improved": 1, "known": 2, "not_applicable": 3, "passed": 4}
"""Of outcomes in a listing: what has to be looked at first; the last two only where all is asked for."""


@click.command()
@click.option("--prune", is_flag=True, help="Delete version environments built from an older lock file.")
@click.option("--older", type=Age(0.0, 1e11), default="30d", show_default=True, metavar="T", help="Not used for this long.")
@click.option("--dry-run", is_flag=True, help="Say what would go, and leave it.")
@json_rows
def engines(prune: bool, older: float, dry_run: bool, as_json: bool) -> None:
    """List what is installed: version, features, and why something is unavailable; or prune environments of versions."""
    from plumbline.harness.study import plugins

    if dry_run and not prune:
        raise click.UsageError("--dry-run is for --prune")
    if prune:
        _prune(older, dry_run)
        return
    from plumbline.harness.study.catalogue import describe_engine

    rows = [describe_engine(adapter) for adapter in plugins.adapters().values()]
    if as_json:
        print_json(rows)
        return
    shown = [
        (r["name"], r["title"], r["version"] or f"unavailable: {r['unavailable']}", ", ".join(r["features"])) for r in rows
    ]
    print_table("Engines", ("name", "engine", "version", "features"), shown)


def _prune(older: float, dry_run: bool) -> None:
    from plumbline.harness.run.make_environment import old_environments, remove

    old = [each for each in old_environments(older) if dry_run or remove(each)]
    for each in old:
        say(f"{'would go' if dry_run else 'went'}: {each.folder.name}, unasked for {each.unasked / DAY:.0f} days")
    freed = "would be freed; without --dry-run they go" if dry_run else "freed"
    say(f"{len(old)} environments: {sum(each.bytes for each in old) / 2**20:.1f} MB {freed}")


@click.command()
@json_rows
def cases(as_json: bool) -> None:
    """List the catalogue: question, truth, effects, source."""
    from plumbline.harness.study import plugins
    from plumbline.harness.study.catalogue import describe_case

    catalogue = plugins.cases().values()
    for sentence in plugins.left_out_in_words("cases"):
        say(sentence, err=True)
    if as_json:
        print_json([describe_case(case) for case in catalogue])
        return
    effects = [", ".join(case.scene(case.parameters).effects.names) for case in catalogue]
    shown = [
        (case.name, case.question, case.truth, acting, case.source) for case, acting in zip(catalogue, effects, strict=True)
    ]
    print_table("Cases", ("name", "question", "truth", "effects", "source"), shown)


@click.command()
@click.argument("engine")
@click.option("--track", "tracks", multiple=True, type=click.Choice(["default", "tuned"]), help="Only this track.")
@click.option("--verbose", is_flag=True, help="Each check on each track, with what passed and what is not claimed.")
@json_rows
@agreed
def check(engine: str, tracks: tuple[str, ...], verbose: bool, as_json: bool, agreed: bool) -> None:
    """Put one adapter, built in or third-party, through the conformance kit; also ENGINE==VERSION or ENGINE=FILE.whl."""
    from dataclasses import asdict

    from plumbline.api.engines import chosen_engines
    from plumbline.harness.conformance import gate
    from plumbline.harness.conformance.apart import outcomes_in
    from plumbline.harness.conformance.outcomes import in_brief
    from plumbline.harness.study import plugins
    from plumbline.harness.study.engine_versions import version_asked
    from plumbline.harness.study.environments import home_of

    ((name, adapter),) = chosen_engines((engine,), agreed).items()
    environment = home_of(name)
    chosen = tracks or ("default", "tuned")
    if environment is not None and environment.executable:
        # Also where the smoke checks say no: the kit names all that does.
        title = adapter.title if version_asked(name) else f"{adapter.title} {environment.version}"
        outcomes = outcomes_in(environment, name, chosen)
    else:
        version, reason = plugins.version_of(adapter)
        if reason is not None:
            stop(GATE, f"{engine}: unavailable: {reason}")
        title, outcomes = f"{adapter.title} {version}", outcomes_in(None, name, chosen)
    if as_json:
        print_json([asdict(outcome) for outcome in outcomes])
    else:
        shown = [o for o in outcomes if verbose or _ORDER[o.status] < _ORDER["not_applicable"]]
        rows = [(o.track, o.check, o.status, o.message) for o in sorted(shown, key=lambda o: _ORDER[o.status])]
        if rows:
            print_table(title, ("track", "check", "status", "finding"), rows)
        say(f"{title}: {in_brief(outcomes)}{'' if verbose else '; --verbose shows each'}")
    if not gate(outcomes):
        sys.exit(GATE)


_MOST = 8
"""Processes, unless more are asked for: each works out anew what functions share."""


@click.command()
@click.option(
    "--workers",
    type=click.IntRange(1, 1024),
    default=lambda: min(_MOST, os.cpu_count() or 1),
    show_default=f"one for each core, {_MOST} at most",
    help="Processes that compile.",
)
@click.option("--first", is_flag=True, help="Only what most scenes need; the quick study needs no more.")
def warm(workers: int, first: bool) -> None:
    """Compile the functions that engines would compile in the first trials that need them; compiled ones are stored."""
    from plumbline.harness.study import plugins

    failures = [
        f"{name}: {failure}" for name, adapter in plugins.adapters().items() for failure in _warm(adapter, workers, first)
    ]
    for failure in failures:
        say(failure, err=True)
    if failures:
        stop(MACHINE, f"{len(failures)} could not be compiled; trials will try again")


def _warm(adapter: "Adapter", workers: int, first: bool) -> list[str]:
    """Compile what one engine lacks. Returns: what could not be compiled, with the reasons."""
    from plumbline.harness.adapter import Unavailable
    from plumbline.harness.run.warm_up import warm_up

    begun = time.monotonic()
    try:
        kernels = adapter.kernels()
        asked = {number: group for number, group in enumerate(kernels.groups) if group.first or not first}
        wanted = [number for number, group in asked.items() if not group.is_stored()]
    except Unavailable as error:
        say(f"{adapter.name}: unavailable: {error}")
        return []
    except Exception as error:  # of a third party's, which costs no other engine
        return [f"{type(error).__name__}: {error}"]
    for note in kernels.notes:
        say(f"{adapter.name}: {note}")
    if not asked:
        say(f"{adapter.name}: nothing to compile")
        return []
    stored = f"{len(asked) - len(wanted)} of {len(asked)} groups of functions are stored"
    say(f"{adapter.name}: {stored}{f' in {kernels.folder}' if kernels.folder else ''}")
    failures = warm_up(f"{adapter.name}: compiling", adapter.kernels, wanted, adapter.loads, workers) if wanted else []
    say(f"{adapter.name}: {len(wanted) - len(failures)} compiled in {time.monotonic() - begun:.1f} s")
    return failures
