"""The command that makes a run folder the dataset that ships with the package."""

import sys
from pathlib import Path

import click

from plumbline.harness.cli.guard import MACHINE, say
from plumbline.harness.cli.options import opened, run_folder


@click.command()
@run_folder
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="The folder to write [the package's own].")
def publish(folder: Path, out: Path | None) -> None:
    """Make the run in DIR the dataset that ships with Plumbline: what `select --published` and front pages show.

    In a checkout, the table of README.md is written anew from it.
    """
    from plumbline.harness.run.verify import problems
    from plumbline.harness.store.published import FOLDER, MOST_BYTES, publish

    store, target = opened(folder), out or FOLDER
    problems_found = [str(problem) for problem in problems(folder)]
    for sentence in problems_found:
        say(sentence, err=True)
    if problems_found:
        sys.exit(MACHINE)
    total = publish(store, target)
    say(f"{target}: {total} of at most {MOST_BYTES} bytes, {len(store.trials)} trials")
    if out is None and (readme := FOLDER.resolve().parents[2] / "README.md").is_file():
        say(f"{readme}: {_write_table(readme)}")


def _write_table(readme: Path) -> str:
    """Put the table in the place of the one that is there; what came of it, in words."""
    from plumbline.reports.tables.published import BEGIN, END, in_markdown, published_table

    text, table = readme.read_text(encoding="utf-8"), published_table()
    before, begins, rest = text.partition(BEGIN)
    _, ends, after = rest.partition(END)
    if table is None or not begins or not ends:
        return f"has no place for the table, expected the lines {BEGIN} and {END}"
    readme.write_text(f"{before}{BEGIN}\n{in_markdown(table)}\n{END}{after}", encoding="utf-8")
    return "its table is written anew"
