"""The command that compiles what engines need before a study, so that no trial waits for it."""

import os
import time
from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import MACHINE, say, stop

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter

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
