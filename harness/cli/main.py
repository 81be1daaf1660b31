"""The command line: the one place that knows every part; each command imports what it needs when it is called."""

import re
import sys
from io import StringIO, TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NoReturn

import click

from harness.cli.listing import print_csv, print_json, print_markdown, print_table
from harness.findings import tables
from harness.intake.allowance import allowing
from harness.intake.documents import document
from harness.intake.mendable import Mendable
from harness.intake.safe_text import one_line, quoted, readable
from harness.run.interrupt import listen

if TYPE_CHECKING:
    from collections.abc import Sequence

    from harness.case import Case
    from harness.store.store import Store
    from harness.study.study import Study

__all__ = ["main"]

_GATE, _USAGE, _MACHINE, _INTERRUPTED = 1, 2, 3, 130
_TABLES = ("trials", "measurements", "samples")
"""Stored as they are; the others are worked out, one file each in `harness.findings.tables`."""


_CODES = {"usage": _USAGE, "machine": _MACHINE}


def _stop(code: int, message: str) -> NoReturn:
    click.echo(readable(message), err=True)
    sys.exit(code)


def _misused(error: click.ClickException) -> NoReturn:
    """Say what click says of a wrong use, cleaned."""
    said = StringIO()
    error.show(file=said)
    _stop(error.exit_code, said.getvalue().rstrip("\n"))


def _say(sentence: str, err: bool = False) -> None:
    """A line of text that may come from engines and files."""
    click.echo(one_line(sentence), err=err)


class _Guarded(click.Group):
    """Turns the errors that people can mend into a line and an exit code; anything else keeps its trace."""

    def make_context(self, *arguments: Any, **extra: Any) -> click.Context:
        """Parse the part of the command line that comes before the command."""
        try:
            return super().make_context(*arguments, **extra)
        except click.ClickException as error:
            _misused(error)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command. Requests to stop are heard even where the shell has told its children to ignore them."""
        listen()
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")  # a terminal that lacks a letter is no reason to stop
        try:
            return super().invoke(ctx)
        except click.ClickException as error:
            _misused(error)
        except (click.exceptions.Exit, click.Abort, BrokenPipeError):
            raise
        except KeyboardInterrupt:
            _stop(_INTERRUPTED, "interrupted")
        except OSError as error:
            _stop(_MACHINE, f"{error.filename or 'machine'}: {error.strerror or error}")
        except MemoryError:
            _stop(_MACHINE, "no memory is left for this process; free some, and go on with --resume")
        except Mendable as error:
            _stop(_CODES[error.lies_in], str(error))


@click.group(cls=_Guarded, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="plumbline")
def main() -> None:
    """Compare rigid-body physics engines: what accuracy costs in time, and where each engine breaks."""


@main.command()
@click.option("--json", "as_json", is_flag=True, help="One JSON array of flat rows.")
def engines(as_json: bool) -> None:
    """List what is installed: version, features, and why something is unavailable."""
    from harness.study import plugins
    from harness.study.catalogue import describe_engine

    rows = [describe_engine(adapter) for adapter in plugins.adapters().values()]
    if as_json:
        print_json(rows)
        return
    shown = [
        (r["name"], r["title"], r["version"] or f"unavailable: {r['unavailable']}", ", ".join(r["features"])) for r in rows
    ]
    print_table("Engines", ("name", "engine", "version", "features"), shown)


def _left_out(*kinds: str) -> list[str]:
    """Third parties' plug-ins of these kinds that cannot be loaded, in words."""
    from harness.study import plugins

    return [f"{kind[:-1]} '{name}' is left out: {said}" for kind in kinds for name, said in plugins.left_out(kind).items()]


@main.command()
@click.option("--json", "as_json", is_flag=True, help="One JSON array of flat rows.")
def cases(as_json: bool) -> None:
    """List the catalogue: question, truth, effects, source."""
    from harness.study import plugins
    from harness.study.catalogue import describe_case

    found = plugins.cases().values()
    for sentence in _left_out("cases"):
        _say(sentence, err=True)
    if as_json:
        print_json([describe_case(case) for case in found])
        return
    effects = [", ".join(case.scene(**case.parameters).effects.names) for case in found]
    shown = [(one.name, one.question, one.truth, acting, one.source) for one, acting in zip(found, effects, strict=True)]
    print_table("Cases", ("name", "question", "truth", "effects", "source"), shown)


@main.command()
@click.argument("engine")
@click.option("--track", "tracks", multiple=True, type=click.Choice(["default", "tuned"]), help="Only this track.")
@click.option("--json", "as_json", is_flag=True, help="One JSON array of flat rows.")
def check(engine: str, tracks: tuple[str, ...], as_json: bool) -> None:
    """Put one adapter, built in or third-party, through the conformance kit."""
    from dataclasses import asdict

    from harness.conformance import gate, run_conformance
    from harness.study import plugins

    adapter = plugins.adapter(engine)
    version, reason = plugins.version_of(adapter)
    if reason is not None:
        _stop(_GATE, f"{engine}: unavailable: {reason}")
    outcomes = run_conformance(adapter, tracks=tracks or ("default", "tuned"))
    if as_json:
        print_json([asdict(outcome) for outcome in outcomes])
    else:
        rows = [(o.track, o.check, o.status, o.message) for o in outcomes]
        print_table(f"{adapter.title} {version}", ("track", "check", "status", "finding"), rows)
        counts = {status: sum(o.status == status for o in outcomes) for status in dict.fromkeys(o.status for o in outcomes)}
        checks = len({o.check for o in outcomes})
        _say(f"{checks} checks: " + ", ".join(f"{n} {status}" for status, n in counts.items()), err=True)
    if not gate(outcomes):
        sys.exit(_GATE)


def _parse_shard(_context: click.Context, _parameter: click.Parameter, text: str) -> tuple[int, int]:
    told = re.fullmatch("([0-9]{1,6})/([0-9]{1,6})", text)
    part, whole = (int(number) for number in told.groups()) if told else (0, 0)
    if not 1 <= part <= whole:
        raise click.BadParameter(f"{quoted(text)}, expected i/n with 1 <= i <= n, like 2/4")
    return part, whole


def _is_scene(name: str) -> bool:
    """Is it a scene file? What cannot be read is refused before anything is imported for it. Raises: InputError."""
    path = Path(name)
    if path.suffix not in {".json", ".toml"}:
        return False
    told = document(path)
    return path.suffix == ".json" or "bodies" in told


def _once(name: str, given: "Sequence[str]") -> None:
    """Refuse an option's value that is given twice."""
    from harness.study.roll_call import twice

    if double := twice(given):
        raise click.BadParameter(f"{quoted(double)} is given twice, expected once", param_hint=name)


def _study_and_cases(name: str, own: bool, globs: tuple[str, ...]) -> "tuple[Study, dict[str, Case]]":
    from fnmatch import fnmatchcase

    from harness.study import plugins
    from harness.study.roll_call import call_roll
    from harness.study.study import Experiment, Study, load_study

    if own:
        case = plugins.case(f"{plugins.SCENE_PREFIX}{Path(name).resolve()}")
        if globs:
            raise click.BadParameter(f"{quoted(globs[0])}: a scene file is one case, expected none", param_hint="--case")
        ladder = Experiment(name="scene", dt=(1 / 240, 1 / 480, 1 / 960))
        needs = Experiment(name="effects", tracks=("tuned",), effects=True, samples=3, sample_seconds=0.01)
        return Study(name="scene", title=case.title, experiments=(ladder, needs)), {case.name: case}
    study = load_study(name)
    _once("--case", globs)
    for sentence in _left_out("cases", "metrics", "pages"):
        _say(sentence, err=True)
    names = plugins.names("cases")
    call_roll(study, names, plugins.names("adapters"))
    for glob in globs:
        if not any(fnmatchcase(case, glob) for case in names):
            raise click.BadParameter(
                f"{quoted(glob)} names no case, expected a pattern over: {', '.join(names)}", param_hint="--case"
            )

    def asked(case: str) -> bool:
        called = any(experiment.asks(case) for experiment in study.experiments)
        return called and (not globs or any(fnmatchcase(case, glob) for glob in globs))

    return study, plugins.cases(asked)


def _of_file(study: str, error: Exception) -> str:
    """What is wrong with a study, with the file that says it."""
    said = str(error)
    return said if not study.endswith(".toml") or said.startswith(study) else f"{study}: {said}"


def _publish(store: "Store", recordings: bool) -> Path:
    from harness.findings.summary import write_summary
    from reports import build, write_recordings

    write_summary(store)
    if recordings:
        write_recordings(store.folder)
    return build(store.folder)


def _allow(context: click.Context, _parameter: click.Parameter, given: tuple[str, ...]) -> None:
    if given:
        context.with_resource(allowing(given, "--limit"))


_limited = click.option(
    "--limit",
    multiple=True,
    metavar="NAME=VALUE",
    expose_value=False,
    is_eager=True,
    callback=_allow,
    help="Allow a file so much: bytes, bodies, joints, vertices, rays, steps, ...; may be repeated.",
)


_MERGE = "--resume-with-another-study"


class _Resumable(click.Command):
    """A command with a flag that may have a value: click would take the word behind a plain `--resume` for it."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click does, where `--resume=merge` is a flag of its own."""
        for word in args:
            value = word.removeprefix("--resume=")
            if value not in (word, "merge"):
                raise click.BadParameter(f"'{value}', expected merge, or --resume alone", param_hint="--resume")
        return super().parse_args(ctx, [_MERGE if word == "--resume=merge" else word for word in args])


@main.command(cls=_Resumable)
@click.argument("study")
@click.option("--engine", "engine_names", multiple=True, help="Only this engine; may be repeated.")
@click.option("--case", "globs", multiple=True, metavar="GLOB", help="Only cases of this pattern; may be repeated.")
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="The run folder [build/STUDY].")
@click.option("--workers", type=click.IntRange(1, 1024), default=2, show_default=True, help="Accuracy runs side by side.")
@click.option("--shard", default="1/1", callback=_parse_shard, metavar="I/N", help="Only the I-th of N parts.")
@click.option("--resume", "resume", flag_value="same", help="Go on with a stopped run; =merge: with another study.")
@click.option(_MERGE, "resume", flag_value="merge", hidden=True)
@_limited
def run(
    study: str,
    engine_names: tuple[str, ...],
    globs: tuple[str, ...],
    out: Path | None,
    workers: int,
    shard: tuple[int, int],
    resume: Literal["same", "merge"] | None,
) -> None:
    """Run STUDY: a built-in name (quick, accuracy, price, limits, effects, ...), a study file, or a scene file of your own."""
    own = _is_scene(study)
    _once("--engine", engine_names)

    from harness.run.campaign import carry_out
    from harness.study import plugins
    from harness.study.study import StudyError

    try:
        plan, chosen = _study_and_cases(study, own, globs)
    except StudyError as error:
        _stop(_USAGE, _of_file(study, error))
    adapters = {name: plugins.adapter(name) for name in engine_names} if engine_names else plugins.adapters()
    folder = out or Path("build") / plan.name
    try:
        how: bool | Literal["merge"] = "merge" if resume == "merge" else resume is not None
        store = carry_out(plan, folder, chosen, adapters, workers=workers, resume=how, shard=shard)
    except StudyError as error:
        _stop(_USAGE, _of_file(study, error))
    except KeyboardInterrupt:
        _stop(_INTERRUPTED, f"interrupted; what finished is in {folder}; go on with the same command and --resume")
    index = _publish(store, plan.recordings)
    counts = store.trials["status"].value_counts()
    _say(f"{len(store.trials)} trials: " + ", ".join(f"{n} {status}" for status, n in counts.items()), err=True)
    _say(str(index))
    failures = _failures(store, audited=not own)
    for sentence in failures:
        _say(sentence, err=True)
    if own:
        effects = tables.table("effects")
        for sentence in tables.sentences(effects, effects.rows(store)):
            _say(sentence, err=True)
    if failures:
        sys.exit(_GATE)


def _failures(store: "Store", audited: bool) -> list[str]:
    """What the gate is about: our own engine's checks on the tuned track and its determinism, and the audit of effects."""
    from harness.findings.tables import determinism
    from harness.findings.tables.effects import JUDGE, audit, rows

    ours = [name for name, row in store.catalogue["engines"].items() if row["ours"]]
    # Bounds are meant for the steps that a study names, not for those that a sweep goes on to.
    trials = store.asked[store.asked["round"] == 0]
    broken = trials[
        trials["engine"].isin(ours) & (trials["track"] == "tuned") & ~trials["status"].isin(("passed", "unsupported"))
    ]
    told = [
        f"gate: {row.case} on {row.engine}/{row.track} at dt {row.dt:g}: {row.status}: {row.reason}"
        for row in broken.itertuples()
    ]
    told += [f"determinism: {sentence}" for sentence in determinism.broken(determinism.agreements(store), ours)]
    if audited:
        # Another engine that stands in for the judge may see worse than it: its word is in the table, and gates nothing.
        judged = audit([row for row in rows(store) if row["engine"] == JUDGE])
        told += [f"audit: {sentence}" for sentence in judged.sentences]
    return told


def _opened(folder: Path) -> "Store":
    """The store of a folder; what a reader has to know of it goes to standard error."""
    from harness.store.store import Store

    store = Store(folder)
    for note in store.notes:
        click.echo(note, err=True)
    return store


def _stored(store: "Store", table: str) -> "tuple[list[dict[str, Any]], Sequence[str]]":
    """The rows of a stored table and its columns."""
    frame = getattr(store, table)
    rows = [
        {str(name): None if value != value or str(value) == "<NA>" else value for name, value in row.items()}
        for row in frame.to_dict(orient="records")
    ]
    return rows, [str(name) for name in frame.columns]


@main.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--table", type=click.Choice([*_TABLES, *tables.names()]), default="trials", show_default=True)
@click.option("--format", "form", type=click.Choice(["text", "json", "csv", "markdown"]), default="text", show_default=True)
def show(folder: Path, table: str, form: str) -> None:
    """Print a table of the run folder DIR."""
    store = _opened(folder)
    worked_out = None if table in _TABLES else tables.table(table)
    rows, columns = _stored(store, table) if worked_out is None else (worked_out.rows(store), worked_out.COLUMNS)
    if form == "json":
        print_json(rows)
    elif form == "csv":
        print_csv(columns, rows)
    elif form == "markdown":
        print_markdown(columns, rows)
    elif worked_out is not None:
        print_table(table, worked_out.BRIEF, [worked_out.brief(row) for row in rows])
        for sentence in tables.sentences(worked_out, rows):
            _say(sentence)
    else:
        brief = (
            ["trial", "case", "engine", "track", "dt", "status", "cpu_per_sim_s", "reason"] if table == "trials" else columns
        )
        shown = [[f"{row[c]:.4g}" if isinstance(row[c], float) else row[c] for c in brief] for row in rows]
        print_table(table, brief, shown)


@main.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--open", "show_it", is_flag=True, help="Open it in the browser.")
def report(folder: Path, show_it: bool) -> None:
    """Rebuild the HTML report of DIR from its store."""
    from reports import build

    index = build(_opened(folder).folder)
    _say(str(index))
    if show_it:
        click.launch(str(index))


@main.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.argument("case")
def view(folder: Path, case: str) -> None:
    """Open the recording of CASE in the rerun viewer."""
    from reports import open_viewer, recording_of

    path = recording_of(folder, case)
    _say(f"opening {path}", err=True)
    sys.exit(open_viewer(path))


@main.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--port", type=click.IntRange(0, 65535), default=8800, show_default=True, help="0 takes any free port.")
def serve(folder: Path, port: int) -> None:
    """Serve the report and the web viewer of DIR on loopback until interrupted."""
    from reports import serve as serve_reports

    serve_reports(_opened(folder).folder, port, announce=_say)


@main.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def verify(folder: Path) -> None:
    """Check every file that DIR keeps against its checksum and the journal; one line for each that is not as written."""
    from harness.run.verify import problems

    found = [str(problem) for problem in problems(folder)]
    for sentence in found:
        _say(sentence)
    _say(f"{len(found)} problems" if found else "every file is as it was written", err=True)
    if found:
        sys.exit(_MACHINE)


@main.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.argument("trial")
@_limited
def reproduce(folder: Path, trial: str) -> None:
    """Run TRIAL of DIR again and say whether the answer is bit-identical."""
    from tempfile import TemporaryDirectory

    from harness.run.isolated import run_isolated
    from harness.study import plugins
    from harness.study.reproduce import trial_of

    store = _opened(folder)
    again = trial_of(store, trial)
    row = store.trials.set_index("trial").loc[again.trial]
    version, reason = plugins.version_of(plugins.adapter(again.engine))
    if reason is not None:
        _stop(_GATE, f"{again.engine}: unavailable: {reason}")
    if version != row["engine_version"]:
        _say(f"note: {again.engine} was {row['engine_version']}, now {version}", err=True)
    with TemporaryDirectory() as scratch:
        (record,) = run_isolated([again], Path(scratch), 1)
    _say(f"then: {row['status']}  {row['trajectory_hash']}  {row['reason']}")
    _say(f"now:  {record.status}  {record.trajectory_hash}  {record.reason}")
    same = record.trajectory_hash == row["trajectory_hash"] and record.status == row["status"]
    click.echo("bit-identical" if same else "different")
    if not same:
        sys.exit(_GATE)


if __name__ == "__main__":
    main()
