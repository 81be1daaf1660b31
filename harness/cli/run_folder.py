"""Commands on a run folder: its tables, its report and recordings, whether it is as written, a trial of it again, a figure of
it, and the dataset that it may become.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plumbline.harness.cli.guard import GATE, MACHINE, fail_for, say, stop
from plumbline.harness.cli.listing import print_csv, print_json, print_latex, print_markdown, print_table
from plumbline.harness.cli.options import limited, opened, run_folder
from plumbline.harness.cli.own_scene import shown_status
from plumbline.harness.findings import tables
from plumbline.harness.findings.columns import Column, Titles, headings, milli, span
from plumbline.harness.findings.parameter_words import step_in_words, substeps_of
from plumbline.harness.statistics.interval import Interval

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store
    from plumbline.reports.html.written import WrittenReport

_TABLES = ("trials", "measurements", "samples")
"""Stored as they are; the others are worked out, one file each in `harness.findings.tables`."""


def _stored(store: "Store", table: str) -> tuple[list[dict[str, Any]], Sequence[str]]:
    """The rows of a stored table and its columns."""
    from plumbline.harness.store.rows import records

    frame = getattr(store, table)
    rows = [{name: None if value != value else value for name, value in row.items()} for row in records(frame)]
    return rows, [str(name) for name in frame.columns]


@click.command()
@run_folder
@click.option("--table", type=click.Choice([*_TABLES, *tables.names()]), default="trials", show_default=True)
@click.option(
    "--format", "form", type=click.Choice(["text", "json", "csv", "markdown", "latex"]), default="text", show_default=True
)
def show(folder: Path, table: str, form: str) -> None:
    """Print a table of the run folder DIR."""
    store = opened(folder)
    worked_out = None if table in _TABLES else tables.table(table)
    if worked_out is not None and form in ("markdown", "latex"):
        _print_for_paper(store, form, worked_out.printed(store, lambda: _titles_of(store)))
        return
    if worked_out is not None and form == "text":
        objects = tuple(worked_out.objects(store))
        print_table(table, headings(worked_out.shown), objects, worked_out.brief)
        for sentence in worked_out.sentences(objects):
            say(sentence)
        return
    rows, columns = _stored(store, table) if worked_out is None else (worked_out.rows(store), worked_out.columns)
    if form == "json":
        print_json(rows)
    elif form == "csv":
        print_csv(columns, rows)
    elif form in ("markdown", "latex"):
        whole = list(columns), [[row[name] for name in columns] for row in rows]
        _print_for_paper(store, form, _paper_trials(store, rows) if table == "trials" else whole)
    else:
        shown = _shown_trials(rows) if table == "trials" else [Column(name, _short(name)) for name in columns]
        print_table(table, headings(shown), rows, lambda row: [column.cell(row) for column in shown])


def _print_for_paper(store: "Store", form: str, printed: tuple[list[str], list[list[object]]]) -> None:
    """Headings and cells as Markdown, or as LaTeX with where they come from."""
    if form == "markdown":
        print_markdown(*printed)
    else:
        from plumbline.reports.words.citation import citation

        print_latex(*printed, citation(store))


def _titles_of(store: "Store") -> Titles:
    """What cases and engines are called on pages."""
    from plumbline.reports.words.catalogue import cases, engines

    of_cases = {name: str(case["title"]) for name, case in cases(store).items()}
    return Titles(of_cases, {name: str(engine["title"]) for name, engine in engines(store).items()})


def _paper_trials(store: "Store", rows: Sequence[Mapping[str, Any]]) -> tuple[list[str], list[list[object]]]:
    """The table of trials as a paper prints it: titles for names, units in headings, digits that count."""
    titles, cases, table = _titles_of(store), store.catalogue.get("cases", {}), store.measurements
    values = {
        (trial, metric): (float(value), str(unit))
        for trial, metric, value, unit in zip(table["trial"], table["metric"], table["value"], table["unit"], strict=True)
    }

    def error(row: Mapping[str, Any]) -> tuple[float | None, str]:
        return values.get((row["trial"], cases.get(row["case"], {}).get("headline", "")), (None, ""))

    columns = (
        Column("Case", lambda row: titles.cases[row["case"]]),
        Column("Engine", lambda row: titles.engines[row["engine"]]),
        Column("Track", "track"),
        Column("Time step [ms]", lambda row: milli(row["dt"])),
        Column("Sub-steps", lambda row: substeps_of(str(row["resolved"]))),
        Column("Error", lambda row: error(row)[0]),
        Column("Unit", lambda row: error(row)[1]),
        Column("CPU time [ms/s]", lambda row: milli(row["cpu_per_sim_s"])),
        Column("95 % interval", lambda row: span(Interval(row["cpu_per_sim_s"], row["cpu_low"], row["cpu_high"]), 1e3)),
        Column("Outcome", "status"),
    )
    return headings(columns), [[column.cell(row) for column in columns] for row in rows]


def _short(name: str) -> Callable[[Mapping[str, Any]], object]:
    """What makes a cell of a stored value: numbers in four digits."""
    return lambda row: f"{row[name]:.4g}" if isinstance(row[name], float) else row[name]


def _shown_trials(rows: Sequence[Mapping[str, Any]]) -> list[Column]:
    """What a terminal has room for of the trials."""
    recalled = ["recalled"] if any(row["recalled"] for row in rows) else []
    return [
        *(Column(name, name) for name in ("trial", "case", "engine", "track")),
        Column("dt", lambda row: step_in_words(row["dt"], substeps_of(str(row["resolved"])))),
        Column("status", lambda row: shown_status(str(row["case"]), str(row["status"]))),
        *(Column(name, _short(name)) for name in ("cpu_per_sim_s", "clocked", *recalled, "reason")),
    ]


@click.command()
@run_folder
@click.option("--open", "show_it", is_flag=True, help="Open it in the browser.")
@click.option("--pdf", is_flag=True, help="Print all its pages into report.pdf too; needs Chromium, Chrome or Edge.")
def report(folder: Path, show_it: bool, pdf: bool) -> None:
    """Rebuild the HTML report of DIR from its store; of a history, the page of its trends.

    Exit code 1 if a page could not be made: it is named, here and on the first page, and the others are written.
    """
    from plumbline.reports.html.report import write_report
    from plumbline.reports.paper.printing import print_report

    history = (folder / "history.json").is_file()
    if history and pdf:
        raise click.UsageError("--pdf is for run folders; the page of a history's trends is printed by any browser")
    written = _trends(folder) if history else write_report(opened(folder))
    say(str(written.index))
    if pdf:
        say(str(print_report(folder)))
    if show_it:
        click.launch(str(written.index))
    fail_for(written.sentences())


def _trends(folder: Path) -> "WrittenReport":
    from plumbline.harness.history.folder import opened as opened_history
    from plumbline.harness.history.regressions import read_trends
    from plumbline.reports.standalone.trends import write_trends

    return write_trends(read_trends(opened_history(folder)), folder / "report")


@click.command()
@run_folder
@click.argument("case")
def view(folder: Path, case: str) -> None:
    """Open the recording of CASE in the rerun viewer."""
    from plumbline.reports.recordings import recording_of
    from plumbline.reports.recordings.viewer import open_viewer

    path = recording_of(folder, case)
    say(f"opening {path}", err=True)
    sys.exit(open_viewer(path))


@click.command()
@run_folder
@click.option("--port", type=click.IntRange(0, 65535), default=8800, show_default=True, help="0 takes any free port.")
def serve(folder: Path, port: int) -> None:
    """Serve the report and the web viewer of DIR on loopback until interrupted."""
    from plumbline.reports.server import serve as serve_reports

    serve_reports(opened(folder).folder, port, announce=say)


@click.command()
@run_folder
def verify(folder: Path) -> None:
    """Check each file of DIR, a run or a history, against its checksum and the journal; a line for what is not as written."""
    from plumbline.harness.history.folder import opened as opened_history
    from plumbline.harness.history.retention import problems_of
    from plumbline.harness.run.verify import problems

    history = opened_history(folder) if (folder / "history.json").is_file() else None
    sentences = [str(problem) for problem in (problems(folder) if history is None else problems_of(history))]
    for sentence in sentences:
        say(sentence)
    say(f"{len(sentences)} problems" if sentences else "every file is as it was written", err=True)
    if sentences:
        sys.exit(MACHINE)


@click.command()
@run_folder
@click.argument("trial")
@limited
def reproduce(folder: Path, trial: str) -> None:
    """Run TRIAL of DIR again and say whether the answer is bit-identical."""
    from tempfile import TemporaryDirectory

    from plumbline.harness.findings.changes.answers import AS_GOOD, likeness
    from plumbline.harness.run.isolated import run_isolated
    from plumbline.harness.store.machine_fingerprint import fingerprint
    from plumbline.harness.study import plugins
    from plumbline.harness.study.reproduce import trial_of

    store = opened(folder)
    again = trial_of(store, trial)
    row = store.trials.set_index("trial").loc[again.trial]
    version, reason = plugins.version_of(plugins.adapter(again.engine))
    if reason is not None:
        stop(GATE, f"{again.engine}: unavailable: {reason}")
    if version != row["engine_version"]:
        say(f"note: {again.engine} was {row['engine_version']}, now {version}", err=True)
    with TemporaryDirectory() as scratch:
        (record,) = run_isolated([again], Path(scratch), 1)
    say(f"then: {row['status']}  {row['trajectory_hash']}  {row['reason']}")
    say(f"now:  {record.status}  {record.trajectory_hash}  {record.reason}")
    found = likeness(store, row.to_dict() | {"trial": again.trial}, record, fingerprint()["processor"])
    click.echo(found)
    if found == AS_GOOD:
        say("these settings promise their bits on one machine alone, and that run was made on another", err=True)
    elif found == "different":
        sys.exit(GATE)


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
    from plumbline.reports.html.written import NotWritten, picture_file
    from plumbline.reports.paper.printing import Printed, figures_of

    store = opened(folder)
    _known(store, case)
    drawn = [(name, made) for name, made in figures_of(store, case) if chart in (None, name)]
    if not drawn:
        raise click.UsageError(f"case '{case}' has no trial with a number to draw{f' as {chart}' if chart else ''}")
    disk.make_folder(out)
    failures: dict[str, NotWritten] = {}
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
    fail_for([str(problem) for problem in problems(folder)], MACHINE)
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
