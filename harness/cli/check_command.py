"""The command that puts one adapter through the conformance kit."""

import sys
from dataclasses import asdict

import click

from plumbline.harness.cli.chosen_engines import chosen_engines
from plumbline.harness.cli.guard import GATE, say, stop
from plumbline.harness.cli.listing import print_json, print_table
from plumbline.harness.cli.options import json_rows
from plumbline.harness.conformance import gate, run_conformance
from plumbline.harness.conformance.apart import outcomes_in
from plumbline.harness.study import plugins
from plumbline.harness.study.environments import environment_of

_ORDER = {"failed": 0, "improved": 1, "known": 2, "not_applicable": 3, "passed": 4}
"""Of outcomes in a listing: what has to be looked at first; the last two only where all is asked for."""


@click.command()
@click.argument("engine")
@click.option("--track", "tracks", multiple=True, type=click.Choice(["default", "tuned"]), help="Only this track.")
@click.option("--verbose", is_flag=True, help="Each check on each track, with what passed and what is not claimed.")
@json_rows
def check(engine: str, tracks: tuple[str, ...], verbose: bool, as_json: bool) -> None:
    """Put one adapter, built in or third-party, through the conformance kit; also ENGINE==VERSION or ENGINE=FILE.whl."""
    ((name, adapter),) = chosen_engines((engine,)).items()
    environment = environment_of(name) if name != engine else None
    chosen = tracks or ("default", "tuned")
    if environment is not None and environment.executable:
        # Also where the smoke checks say no: the kit names all that does.
        version = environment.version
        title, outcomes = adapter.title, outcomes_in(environment, name, chosen)
    else:
        version, reason = plugins.version_of(adapter)
        if reason is not None:
            stop(GATE, f"{engine}: unavailable: {reason}")
        title, outcomes = f"{adapter.title} {version}", run_conformance(adapter, tracks=chosen)
    if as_json:
        print_json([asdict(outcome) for outcome in outcomes])
    else:
        shown = [o for o in outcomes if verbose or _ORDER[o.status] < _ORDER["not_applicable"]]
        rows = [(o.track, o.check, o.status, o.message) for o in sorted(shown, key=lambda o: _ORDER[o.status])]
        if rows:
            print_table(title, ("track", "check", "status", "finding"), rows)
        counts = {status: sum(o.status == status for o in outcomes) for status in dict.fromkeys(o.status for o in outcomes)}
        checks = len({o.check for o in outcomes})
        told = ", ".join(f"{n} {status}" for status, n in counts.items())
        say(f"{title}: {checks} checks: {told}{'' if verbose else '; --verbose shows each'}")
    if not gate(outcomes):
        sys.exit(GATE)
