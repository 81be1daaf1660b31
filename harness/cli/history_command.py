"""The commands on a history: its nights where nothing else is asked, what of it may go, its trends, and what one has seen."""

from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import fail_for, say
from plumbline.harness.cli.listing import print_json, print_table
from plumbline.harness.cli.options import DAY, Age, json_rows

if TYPE_CHECKING:
    from plumbline.harness.history.regressions import Trends

_SHOWN = 200
"""Nights that a table for people shows, the last ones: each costs a millisecond and a half."""


class _NightsByDefault(click.Group):
    """`plumbline history DIR` lists; a first word that is a command is that command."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the listing before what names no command."""
        if args and args[0] not in {*self.commands, "-h", "--help"}:
            args = ["nights", *args]
        return super().parse_args(ctx, args)


@click.group(cls=_NightsByDefault, invoke_without_command=False)
def history() -> None:
    """The nights of a history: `history DIR` lists them, `history trends DIR` what changed over them."""


@history.command()
@click.argument("address", metavar="DIR")
@click.option("--prune", is_flag=True, help="Take old nights away, and what of the pool no other night names.")
@click.option("--older", type=Age(0.0, 1e11), metavar="T", help="Nights that began longer ago, like 90d.")
@click.option("--keep-nights", type=click.IntRange(min=1), metavar="N", help="All nights but the last N.")
@click.option("--dry-run", is_flag=True, help="Say what would go, and leave it.")
@json_rows
def nights(address: str, prune: bool, older: float | None, keep_nights: int | None, dry_run: bool, as_json: bool) -> None:
    """List the nights of the history DIR: machines, versions, what was reused and computed, sizes."""
    from plumbline.harness.history.remote_storage import at_hand
    from plumbline.harness.history.retention import COLUMNS, rows

    if not prune and (older is not None or keep_nights is not None or dry_run):
        raise click.UsageError("--older, --keep-nights and --dry-run are for --prune")
    if prune:
        if older is None and keep_nights is None:
            raise click.UsageError("--prune: say which nights: --older 90d, --keep-nights 30, or both")
        _prune(address, older, keep_nights, dry_run)
        return
    every, unread = rows(at_hand(address))
    for error in unread:
        say(f"left out: {error}", err=True)
    if as_json:
        print_json(every)
        return
    shown = [[_cell(row[name]) for name in COLUMNS] for row in every[-_SHOWN:]]
    print_table(f"{address}: {len(every)} nights", COLUMNS, shown)
    if len(every) > _SHOWN:
        say(f"and {len(every) - _SHOWN} earlier nights; --json prints all {len(every)}")


def _cell(value: object) -> object:
    return "" if value is None else f"{value:.0f}" if isinstance(value, float) else value


def _prune(address: str, older: float | None, keep_nights: int | None, dry_run: bool) -> None:
    from contextlib import ExitStack

    from plumbline.harness.history.folder import locked
    from plumbline.harness.history.remote_storage import at_hand, copy_of, is_elsewhere
    from plumbline.harness.history.retention import prune, pruning

    with ExitStack() as held:
        elsewhere = copy_of(address) if is_elsewhere(address) else None
        if elsewhere is not None:
            held.enter_context(elsewhere.locked(DAY))
        kept = at_hand(address)
        held.enter_context(locked(kept))
        what = pruning(kept, older=older, keep_nights=keep_nights)
        for night in what.nights:
            say(f"{'would go' if dry_run else 'goes'}: night {night.stamp}")
        for night in what.standing:
            say(f"stays: night {night.stamp}, the last that did some of its work")
        for path in what.links:
            say(f"stays: {path} lies elsewhere by a link; delete it there")
        say(
            f"{len(what.nights)} nights, {len(what.answers)} answers and {len(what.trajectories)} trajectories of the pool: "
            f"{what.bytes / 2**20:.1f} MB {'would be freed; without --dry-run they go' if dry_run else 'freed'}"
        )
        if not dry_run:
            prune(what)
            if elsewhere is not None:
                elsewhere.send(remove=True)


@history.command()
@click.argument("address", metavar="DIR")
@json_rows
def trends(address: str, as_json: bool) -> None:
    """What got worse over the nights of DIR, first bad night first, and a page of every series."""
    from plumbline.harness.history.regressions import read_trends
    from plumbline.harness.history.remote_storage import at_hand
    from plumbline.reports.standalone.trends import write_trends

    kept = at_hand(address)
    read = read_trends(kept)
    if as_json:
        print_json(_rows(read))
    else:
        _print(read, address)
    for error in read.unread:
        say(f"left out: {error}", err=True)
    try:
        written = write_trends(read, kept.root / "report")
        say(str(written.index), err=as_json)
        fail_for(written.sentences())
    except OSError as error:
        say(f"{kept.root / 'report'}: the page was not written: {error.strerror or error}", err=True)


def _print(read: "Trends", address: str) -> None:
    standing = read.standing()
    say(f"{len(read.nights)} nights; {len(standing)} regressions stand, of {len(read.regressions)}")
    for one in read.regressions:
        state = one.state if one.until is None else f"{one.state} {read.nights[one.until].stamp}"
        say(f"{one.stamp}  {one.id}  {state}: {one.sentence()}{f' ({one.note})' if one.note else ''}")
        if one.command and one.state == "open":
            say(f"    {one.command}")
    if standing:
        say(f"seen one? plumbline history ack ID --note '...' --history {address}", err=True)


def _rows(read: "Trends") -> list[dict[str, object]]:
    return [
        {
            "id": one.id, "first_bad_night": one.stamp, "state": one.state,
            "until": None if one.until is None else read.nights[one.until].stamp,
            "kind": one.first.kind, "sense": one.first.sense,
            "case": one.first.case, "engine": one.first.engine, "track": one.first.track, "metric": one.first.metric,
            "ratio": one.first.ratio, "low": one.first.low, "high": one.first.high, "count": len(one.changes), "note": one.note,
            "sentence": one.sentence(), "command": one.command,
        }
        for one in read.dated
    ]  # fmt: skip


@history.command()
@click.argument("name", metavar="ID")
@click.option("--note", required=True, help="What there is to say of it: a cause, a ticket.")
@click.option("--history", "address", required=True, metavar="DIR", help="The history that the change is of.")
def ack(name: str, note: str, address: str) -> None:
    """Write down that the change ID was seen: it is not reported again."""
    from dataclasses import replace

    from plumbline.harness.history.identity import Named, acknowledge
    from plumbline.harness.history.regressions import read_trends
    from plumbline.harness.history.remote_storage import at_hand, copy_of, is_elsewhere

    kept = at_hand(address)
    known = {one.id: (one.sentence(), replace(Named.of(one.first, one.stamp), id=one.id)) for one in read_trends(kept).dated}
    rows = [row for night in kept.nights() for row in night.plan.get("told", ())]
    known |= {str(row["id"]): (str(row["sentence"]), Named.told(row)) for row in rows}
    matching = sorted(full for full in known if full.startswith(name))
    if len(matching) != 1:
        what = "no change of this history" if not matching else f"{len(matching)} changes begin so"
        raise click.BadParameter(f"{name!r}: {what}; `plumbline history trends` lists them", param_hint="ID")
    text, change = known[matching[0]]
    acknowledge(kept, change, note)
    say(f"{change.id} acknowledged: {text}")
    if is_elsewhere(address):
        copy_of(address).send()
