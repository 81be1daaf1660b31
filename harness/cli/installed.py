"""Commands on what is installed: the engines, the cases, and the conformance kit for one adapter."""

import sys

import click

from harness.cli.guard import GATE, say, stop
from harness.cli.listing import print_json, print_table
from harness.cli.options import json_rows

__all__ = ["cases", "check", "engines", "left_out"]

_ORDER = {"failed": 0, "improved": 1, "known": 2, "not_applicable": 3, "passed": 4}
"""Of outcomes in a listing: what has to be looked at first; the last two only where all is asked for."""


@click.command()
@json_rows
def engines(as_json: bool) -> None:
    """List what is installed: version, features, and why something is unavailable."""
    from harness.study import plugins
    from harness.study.catalogue import describe_engine

    rows = [describe_engine(adapter) for adapter in plugins.adapters().values()]
    if as_json:
        print_json(rows)
        return
    shown = [
        (r["name"], r["title"], r["version"] or f"unavailable: {r['unavailable']}", ", ".join(r["features"])) for r in rows
    ]
    print_table("Engines", ("name", "engine", "version", "features"), shown)


def left_out(*kinds: str) -> list[str]:
    """Third parties' plug-ins of these kinds that cannot be loaded, in words."""
    from harness.study import plugins

    return [f"{kind[:-1]} '{name}' is left out: {reason}" for kind in kinds for name, reason in plugins.left_out(kind).items()]


@click.command()
@json_rows
def cases(as_json: bool) -> None:
    """List the catalogue: question, truth, effects, source."""
    from harness.study import plugins
    from harness.study.catalogue import describe_case

    catalogue = plugins.cases().values()
    for sentence in left_out("cases"):
        say(sentence, err=True)
    if as_json:
        print_json([describe_case(case) for case in catalogue])
        return
    effects = [", ".join(case.scene(**case.parameters).effects.names) for case in catalogue]
    shown = [
        (case.name, case.question, case.truth, acting, case.source) for case, acting in zip(catalogue, effects, strict=True)
    ]
    print_table("Cases", ("name", "question", "truth", "effects", "source"), shown)


@click.command()
@click.argument("engine")
@click.option("--track", "tracks", multiple=True, type=click.Choice(["default", "tuned"]), help="Only this track.")
@click.option("--verbose", is_flag=True, help="Each check on each track, with what passed and what is not claimed.")
@json_rows
def check(engine: str, tracks: tuple[str, ...], verbose: bool, as_json: bool) -> None:
    """Put one adapter, built in or third-party, through the conformance kit."""
    from dataclasses import asdict

    from harness.conformance import gate, run_conformance
    from harness.study import plugins

    adapter = plugins.adapter(engine)
    version, reason = plugins.version_of(adapter)
    if reason is not None:
        stop(GATE, f"{engine}: unavailable: {reason}")
    outcomes = run_conformance(adapter, tracks=tracks or ("default", "tuned"))
    if as_json:
        print_json([asdict(outcome) for outcome in outcomes])
    else:
        shown = [o for o in outcomes if verbose or _ORDER[o.status] < _ORDER["not_applicable"]]
        rows = [(o.track, o.check, o.status, o.message) for o in sorted(shown, key=lambda o: _ORDER[o.status])]
        if rows:
            print_table(f"{adapter.title} {version}", ("track", "check", "status", "finding"), rows)
        counts = {status: sum(o.status == status for o in outcomes) for status in dict.fromkeys(o.status for o in outcomes)}
        checks = len({o.check for o in outcomes})
        told = ", ".join(f"{n} {status}" for status, n in counts.items())
        say(f"{adapter.title} {version}: {checks} checks: {told}{'' if verbose else '; --verbose shows each'}")
    if not gate(outcomes):
        sys.exit(GATE)
