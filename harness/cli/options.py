"""Options and arguments that several commands take."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from plumbline.harness.intake.allowance import allowing

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store

json_rows = click.option("--json", "as_json", is_flag=True, help="One JSON array of flat rows.")
agreed = click.option("--yes", "agreed", is_flag=True, help="Install engines that are asked for and are not here.")
run_folder = click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))


def _allow(context: click.Context, _parameter: click.Parameter, given: tuple[str, ...]) -> None:
    if given:
        context.with_resource(allowing(given, "--limit"))


limited = click.option(
    "--limit",
    multiple=True,
    metavar="NAME=VALUE",
    expose_value=False,
    is_eager=True,
    callback=_allow,
    help="Allow a file so much: bytes, bodies, joints, vertices, rays, steps, ...; may be repeated.",
)


def opened(folder: Path) -> "Store":
    """The store of a folder; what a reader has to know of it goes to standard error."""
    from plumbline.harness.store.store import Store

    store = Store(folder)
    for note in store.notes:
        click.echo(note, err=True)
    return store
