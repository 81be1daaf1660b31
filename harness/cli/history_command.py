"""The command on a history: its nights, and what of it may go."""

from typing import TYPE_CHECKING, Any

import click

from plumbline.harness.cli.guard import say
from plumbline.harness.cli.listing import print_json, print_table
from plumbline.harness.cli.options import DAY, Age, json_rows

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plumbline.harness.history.folder import History

_SHOWN = 200
"""Nights that a table for people shows, the last ones: each costs a millisecond and a half."""


@click.command()
@click.argument("address", metavar="DIR")
@click.option("--prune", is_flag=True, help="Take old nights away, and what of the pool no other night names.")
@click.option("--older", type=Age(0.0, 1e11), metavar="T", help="Nights that began longer ago, like 90d.")
@click.option("--keep-nights", type=click.IntRange(min=1), metavar="N", help="All nights but the last N.")
@click.option("--dry-run", is_flag=True, help="Say what would go, and leave it.")
@json_rows
def history(address: str, prune: bool, older: float | None, keep_nights: int | None, dry_run: bool, as_json: bool) -> None:
    """List the nights of the history DIR: machines, versions, what was reused and computed, sizes."""
    from plumbline.harness.history.retention import COLUMNS, rows

    if not prune and (older is not None or keep_nights is not None or dry_run):
        raise click.UsageError("--older, --keep-nights and --dry-run are for --prune")
    if prune:
        if older is None and keep_nights is None:
            raise click.UsageError("--prune: say which nights: --older 90d, --keep-nights 30, or both")
        _prune(address, older, keep_nights, dry_run)
        return
    with at_hand(address) as kept:
        nights, unread = rows(kept)
    for error in unread:
        say(f"left out: {error}", err=True)
    if as_json:
        print_json(nights)
        return
    shown = [[_cell(row[name]) for name in COLUMNS] for row in nights[-_SHOWN:]]
    print_table(f"{address}: {len(nights)} nights", COLUMNS, shown)
    if len(nights) > _SHOWN:
        say(f"and {len(nights) - _SHOWN} earlier nights; --json prints all {len(nights)}")


def _cell(value: object) -> object:
    return "" if value is None else f"{value:.0f}" if isinstance(value, float) else value


def at_hand(address: str) -> Any:
    """A context with the history at an address, fetched where it lies elsewhere. Raises: NoRun, StoreError."""
    from contextlib import contextmanager
    from pathlib import Path

    from plumbline.harness.history.folder import opened
    from plumbline.harness.history.remote_storage import copy_of, is_elsewhere

    @contextmanager
    def reached() -> "Iterator[History]":
        if is_elsewhere(address):
            elsewhere = copy_of(address)
            elsewhere.fetch()
            yield opened(elsewhere.root)
        else:
            yield opened(Path(address))

    return reached()


def _prune(address: str, older: float | None, keep_nights: int | None, dry_run: bool) -> None:
    from contextlib import ExitStack

    from plumbline.harness.history.folder import locked
    from plumbline.harness.history.remote_storage import copy_of, is_elsewhere
    from plumbline.harness.history.retention import prune, pruning

    with ExitStack() as held:
        elsewhere = copy_of(address) if is_elsewhere(address) else None
        if elsewhere is not None:
            held.enter_context(elsewhere.locked(DAY))
        kept = held.enter_context(at_hand(address))
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
