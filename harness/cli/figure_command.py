"""The command that draws the charts of a case for a paper."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import fail_for, say
from plumbline.harness.cli.options import opened, run_folder

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store


@click.command()
@run_folder
@click.option("--case", "case", required=True, metavar="CASE", help="The case to draw.")
@click.option(
    "--chart", type=click.Choice(["step", "price"]), help="Error against time step, or cost against error; both unless said."
)
@click.option("--format", "form", type=click.Choice(["svg", "pdf", "png"]), default="pdf", show_default=True)
@click.option(
    "--width",
    type=click.IntRange(100, 4000),
    default=640,
    show_default=True,
    help="Of the frame: in a PDF points of 1/72 inch, else pixels.",
)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), default=Path(), help="The folder for the files.")
def figure(folder: Path, case: str, chart: str | None, form: str, width: int, out: Path) -> None:
    """Draw the charts of CASE in DIR: vector graphics with text as text, in the light scheme.

    Exit code 1 if a chart could not be drawn: it is named, and the others are written.
    """
    from plumbline.harness.store import disk
    from plumbline.reports.html.drawing import Drawing
    from plumbline.reports.html.written import NotMade, picture_file
    from plumbline.reports.paper.figures import Printed, figures_of

    store = opened(folder)
    _known(store, case)
    drawn = [(name, made) for name, made in figures_of(store, case) if chart in (None, name)]
    if not drawn:
        raise click.UsageError(f"case '{case}' has no trial with a number to draw{f' as {chart}' if chart else ''}")
    disk.make_folder(out)
    failures: dict[str, NotMade] = {}
    with Drawing(folder) as beside:
        files = {f"{made.name}.{form}": beside.ask(Printed(made, form, width)) for _, made in drawn}
        for name, waiting in files.items():
            content = picture_file(name, waiting, failures)
            if isinstance(content, bytes):
                disk.write_atomically(out / name, content)
                say(str(out / name))
    fail_for([each.sentence() for each in failures.values()])


def _known(store: "Store", case: str) -> None:
    cases = [str(name) for name in dict.fromkeys(store.trials["case"])] if len(store.trials) else []
    if case not in cases:
        raise click.BadParameter(f"'{case}' is no case of this run; there are {', '.join(cases)}", param_hint="--case")
