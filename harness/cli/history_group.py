"""The commands on a history: its nights where nothing else is asked, its trends, and what somebody has seen of them."""

from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import fail_for, say
from plumbline.harness.cli.history_command import at_hand
from plumbline.harness.cli.history_command import history as nights
from plumbline.harness.cli.listing import print_json
from plumbline.harness.cli.options import json_rows

if TYPE_CHECKING:
    from plumbline.harness.history.regressions import Trends


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


history.add_command(nights, "nights")


@history.command()
@click.argument("address", metavar="DIR")
@json_rows
def trends(address: str, as_json: bool) -> None:
    """What got worse over the nights of DIR, first bad night first, and a page of every series."""
    from plumbline.harness.history.regressions import read_trends
    from plumbline.reports import trends_page

    with at_hand(address) as kept:
        read = read_trends(kept)
        if as_json:
            print_json(_rows(read))
        else:
            _print(read, address)
        for error in read.unread:
            say(f"left out: {error}", err=True)
        try:
            written = trends_page(read, kept.root / "report")
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

    with at_hand(address) as kept:
        known = {
            one.id: (one.sentence(), replace(Named.of(one.first, one.stamp), id=one.id)) for one in read_trends(kept).dated
        }
        rows = [row for night in kept.nights() for row in night.plan.get("told", ())]
        known |= {str(row["id"]): (str(row["sentence"]), Named.told(row)) for row in rows}
        matching = sorted(full for full in known if full.startswith(name))
        if len(matching) != 1:
            what = "no change of this history" if not matching else f"{len(matching)} changes begin so"
            raise click.BadParameter(f"{name!r}: {what}; `plumbline history trends` lists them", param_hint="ID")
        text, change = known[matching[0]]
        acknowledge(kept, change, note)
        say(f"{change.id} acknowledged: {text}")
    _send(address)


def _send(address: str) -> None:
    """Take the acknowledgement to where the history lies, where that is elsewhere."""
    from plumbline.harness.history.remote_storage import copy_of, is_elsewhere

    if is_elsewhere(address):
        copy_of(address).send()
