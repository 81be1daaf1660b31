"""The command that compares two run folders."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import fail_for, say
from plumbline.harness.cli.listing import print_json
from plumbline.harness.cli.options import opened

if TYPE_CHECKING:
    from plumbline.harness.findings.changes import Changes
    from plumbline.harness.store.store import Store

_MOST = 60
"""Sentences that a terminal is given; the other formats have all."""


@click.command()
@click.argument("folder_a", metavar="DIR_A", type=click.Path(path_type=Path))
@click.argument("folder_b", metavar="DIR_B", type=click.Path(path_type=Path))
@click.option("--format", "form", type=click.Choice(["text", "json", "markdown"]), default="text", show_default=True)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Also a page, and files for build servers.")
@click.option("--gate", "gated", multiple=True, metavar="ENGINE", help="Exit 1 where this engine is worse; may be repeated.")
@click.option("--judged", "least", type=click.FloatRange(0.0, 1.0), default=0.0, metavar="SHARE",
              help="Exit 1 where less could be judged, of answers or prices of gated engines, like 0.9.")  # fmt: skip
def diff(folder_a: Path, folder_b: Path, form: str, out: Path | None, gated: tuple[str, ...], least: float) -> None:
    """What changed from DIR_A to DIR_B: accuracy exactly, time over what else was clocked in the same run."""
    from plumbline.harness.findings.changes import compare
    from plumbline.harness.findings.changes.files import comment, flat_rows
    from plumbline.harness.findings.changes.words import gate_in_short, sentence

    store_a, store_b = opened(folder_a), opened(folder_b)
    for engine in gated:
        if engine not in {*store_a.trials["engine"], *store_b.trials["engine"]}:
            raise click.BadParameter(f"'{engine}' is in neither folder", param_hint="--gate")
    changes = compare(store_a, store_b)
    if form == "json":
        print_json(flat_rows(changes))
    elif form == "markdown":
        click.echo(comment(changes, gated, least), nl=False)
    else:
        _print(changes)
    if out is not None:
        say(str(write_changes(changes, store_b, out, gated, least)), err=form != "text")
    barred = [sentence(row) for row in changes.regressions(gated)]
    if changes.judged_of(gated).share < least:
        barred.append(gate_in_short(changes, gated, least))
    fail_for([f"gate: {reason}" for reason in barred])


def _print(changes: "Changes") -> None:
    from plumbline.harness.findings.changes.words import command, first_line, folded, headline, judged_in_short, one_a_side

    say(first_line(changes))
    say(f"{headline(changes)}; {changes.clocked} were clocked on both")
    say(judged_in_short(changes.judged_of()))
    groups = one_a_side(folded(changes.rows))
    for text, group in groups[:_MOST]:
        say(text)
        if shown := command(group[0], changes):
            say(f"    {shown}")
    if len(groups) > _MOST:
        say(f"... and {len(groups) - _MOST} more: --format json")
    for text in changes.unread:
        say(f"not compared: {text}", err=True)


def write_changes(changes: "Changes", store: "Store", out: Path, gated: tuple[str, ...], least: float) -> Path:
    """What changed, for build servers and other trackers, and as a page. Returns: the page. Raises: OSError."""
    from plumbline.harness.findings.changes.files import changes_files
    from plumbline.harness.store.disk import make_folder, write_atomically
    from plumbline.reports.standalone.what_changed import write_what_changed

    make_folder(out)
    for name, content in changes_files(changes, store, gated, least).items():
        write_atomically(out / name, content)
    return write_what_changed(changes, out, gated)
