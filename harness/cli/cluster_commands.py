"""What reaches past one machine: the workers of a scheduler, and run folders of several machines made into one."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from plumbline.api.present import present
from plumbline.harness.cli.guard import GATE, fail_for, say, stop

if TYPE_CHECKING:
    from plumbline.harness.run.cluster.workplace import Workplace


@contextmanager
def at_work(scheduler: str | None) -> "Iterator[Workplace | None]":
    """The workers of a scheduler while a run lasts; None where none was named. Raises: NoScheduler, NoDask."""
    if scheduler is None:
        yield None
        return

    from plumbline.harness.run.cluster.workplace import Workplace

    with Workplace(scheduler) as cluster:
        for sentence in cluster.described():
            say(sentence, err=True)
        yield cluster


@click.command()
@click.argument("folders", nargs=-1, required=True, metavar="DIR...", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(file_okay=False, path_type=Path), help="The folder of all of them.")
def merge(folders: tuple[Path, ...], out: Path) -> None:
    """Make the folders of one study's parts, run by --shard anywhere, into one."""
    from plumbline.harness.run.merge_folders import conflicts, merge_folders

    if sentences := conflicts(folders):
        for sentence in sentences:
            say(sentence, err=True)
        stop(GATE, f"{len(sentences)} conflicts; nothing was written")
    store, notes = merge_folders(folders, out)
    for note in notes:
        say(note, err=True)
    report = present(store, bool(store.study.get("recordings", True)))
    say(str(report.index))
    fail_for(report.sentences())
