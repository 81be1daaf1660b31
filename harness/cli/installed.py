"""Commands on what is installed: the engines and the cases."""

import click

from plumbline.harness.cli.guard import say
from plumbline.harness.cli.listing import print_json, print_table
from plumbline.harness.cli.options import json_rows
from plumbline.harness.cli.seconds import DAY, Age
from plumbline.harness.run.old_environments import old_environments, remove
from plumbline.harness.study import plugins
from plumbline.harness.study.catalogue import describe_case, describe_engine


@click.command()
@click.option("--prune", is_flag=True, help="Delete version environments built from an older lock file.")
@click.option("--older", type=Age(0.0, 1e11), default="30d", show_default=True, metavar="T", help="Not used for this long.")
@click.option("--dry-run", is_flag=True, help="Say what would go, and leave it.")
@json_rows
def engines(prune: bool, older: float, dry_run: bool, as_json: bool) -> None:
    """List what is installed: version, features, and why something is unavailable; or prune environments of versions."""
    if dry_run and not prune:
        raise click.UsageError("--dry-run is for --prune")
    if prune:
        _prune(older, dry_run)
        return
    rows = [describe_engine(adapter) for adapter in plugins.adapters().values()]
    if as_json:
        print_json(rows)
        return
    shown = [
        (r["name"], r["title"], r["version"] or f"unavailable: {r['unavailable']}", ", ".join(r["features"])) for r in rows
    ]
    print_table("Engines", ("name", "engine", "version", "features"), shown)


def _prune(older: float, dry_run: bool) -> None:
    old = [each for each in old_environments(older) if dry_run or remove(each)]
    for each in old:
        say(f"{'would go' if dry_run else 'went'}: {each.folder.name}, unasked for {each.unasked / DAY:.0f} days")
    freed = "would be freed; without --dry-run they go" if dry_run else "freed"
    say(f"{len(old)} environments: {sum(each.bytes for each in old) / 2**20:.1f} MB {freed}")


def left_out(*kinds: str) -> list[str]:
    """Third parties' plug-ins of these kinds that cannot be loaded, in words."""
    return [f"{kind[:-1]} '{name}' is left out: {reason}" for kind in kinds for name, reason in plugins.left_out(kind).items()]


@click.command()
@json_rows
def cases(as_json: bool) -> None:
    """List the catalogue: question, truth, effects, source."""
    catalogue = plugins.cases().values()
    for sentence in left_out("cases"):
        say(sentence, err=True)
    if as_json:
        print_json([describe_case(case) for case in catalogue])
        return
    effects = [", ".join(case.scene(case.parameters).effects.names) for case in catalogue]
    shown = [
        (case.name, case.question, case.truth, acting, case.source) for case, acting in zip(catalogue, effects, strict=True)
    ]
    print_table("Cases", ("name", "question", "truth", "effects", "source"), shown)
