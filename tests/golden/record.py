"""Everything that users see, as files of a folder: records of the same runs before and after a change are equal byte for byte.

    python -m tests.golden.record build/before RUN ...
    (change the code)
    python -m tests.golden.record build/after RUN ... && diff -r build/before build/after

The record holds the scene of each case as JSON, each check and observation of each trajectory that the runs keep, all tables of
the runs in every format, their reports, summaries and differences, the help of all commands, the texts of errors and the hashes
of the engine's states. What depends on no run is held by `make test` as well, by its digest in record.json beside this file;
after an intended change, `PLUMBLINE_GOLDEN=write` and `tests/golden/test_record.py` renew it.
"""

import json
import signal
import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click
import numpy as np
from click.testing import CliRunner

from plumbline.harness.case import Case, Converged
from plumbline.harness.cli.main import main
from plumbline.harness.findings import tables
from plumbline.harness.findings.summary import summaries
from plumbline.harness.scene.file import dump_json, parse
from plumbline.harness.store.store import Store
from plumbline.harness.store.stored_tables import TABLES
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import Contacts, Trajectory
from plumbline.harness.trial.accuracy import judge
from plumbline.reports.html.report import rendered
from tests.golden import engine_states

CONTACTS = ("body_A", "body_B", "point_W", "normal_W", "gap", "force_W")
TEXTS = {".html", ".json", ".csv", ".md", ".svg", ".xml", ".txt"}
Named = tuple[str, str | bytes]
"""The name of a file and its content."""
FORMATS = ("text", "json", "csv", "markdown", "latex")
BAD_SCENES = {
    "no_name.toml": "[[bodies]]\nmass = 1.0\n",
    "unknown_key.toml": '[[bodies]]\nname = "ball"\nmas = 1.0\n',
    "negative_mass.toml": '[[bodies]]\nname = "ball"\nmass = -1.0\n',
    "no_inertia.toml": '[[bodies]]\nname = "ball"\nmass = 1.0\ninertia = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 5.0]]\n',
    "not_toml.toml": "name = \n",
    "not_json.json": '{"name": "s",',
    "empty.urdf": "",
    "no_link.urdf": '<robot name="r"><joint name="j" type="hinge"/></robot>',
    "bad_number.urdf": '<robot name="r"><link name="a"><inertial><mass value="one"/></inertial></link></robot>',
    "not_mjcf.xml": "<robot/>",
    "unknown_element.xml": "<mujoco><worldbody><bod/></worldbody></mujoco>",
    "picture.png": "",
}
BAD_STUDIES = {
    "no_experiment.toml": 'name = "s"\n',
    "unknown_case.toml": 'name = "s"\n[[experiments]]\nname = "e"\ncases = ["stak_tower"]\n',
    "unknown_field.toml": 'name = "s"\n[[experiments]]\nname = "e"\ncases = ["stack_tower"]\nsweeep = 4\n',
    "negative_dt.toml": 'name = "s"\n[[experiments]]\nname = "e"\ncases = ["stack_tower"]\ndt = -0.1\n',
    "unknown_knob.toml": 'name = "s"\n[[experiments]]\nname = "e"\ncases = ["stack_tower"]\ntracks = ["fast"]\n',
}
WRONG_USAGE = (
    ("run", "quikc"),
    ("run", "quick", "--engine", "nonsense"),
    ("run", "quick", "--case", "nonsense*"),
    ("run", "quick", "--shard", "5/4"),
    ("run", "quick", "--workers", "0"),
    ("run", "quick", "--resume=again"),
    ("check", "nonsense"),
    ("show", "nowhere"),
    ("show", ".", "--table", "nonsense"),
    ("report", "nowhere"),
    ("verify", "nowhere"),
    ("view", "nowhere", "x"),
    ("reproduce", "nowhere", "x"),
    ("diff", "nowhere", "elsewhere"),
    ("figure", "nowhere", "stack_tower"),
    ("select", "nowhere"),
    ("history", "nowhere"),
    ("merge", "nowhere", "--out", "elsewhere"),
    ("findings", "nonsense"),
    ("nonsense",),
)


def scenes() -> Iterator[Named]:
    """Each case of the catalogue: its scene at its own parameters, and its bounds at three steps."""
    for name, case in sorted(plugins.cases().items()):
        yield f"scenes/{name}.json", dump_json(case.scene(case.parameters))
        yield (
            f"bounds/{name}.json",
            json.dumps(
                [
                    [
                        check.metric.name,
                        check.metric.unit,
                        check.because,
                        *(check.bound(dt, case.parameters) for dt in (1 / 60, 1 / 240, 1e-3)),
                    ]
                    for check in case.checks
                ],
                indent=1,
            ),
        )


def helps() -> Iterator[Named]:
    """The help of each command and subcommand."""

    def below(command: click.Command, names: tuple[str, ...]) -> Iterator[Named]:
        yield f"help/{'-'.join(('plumbline', *names))}.txt", _said(*names, "--help")
        if isinstance(command, click.Group):
            context = click.Context(command)
            for name in command.list_commands(context):
                inner = command.get_command(context, name)
                assert inner is not None
                yield from below(inner, (*names, name))

    yield from below(main, ())


def errors() -> Iterator[Named]:
    """What wrong usage and bad files are answered."""
    with TemporaryDirectory() as folder:
        here = Path(folder)
        for kind, texts in (("scene", BAD_SCENES), ("study", BAD_STUDIES)):
            for name, text in texts.items():
                path = here / name
                path.write_text(text)
                command = ("scene", "check", str(path)) if kind == "scene" else ("run", str(path), "--out", str(here / "run"))
                yield f"errors/{kind}-{name}.txt", _said(*command).replace(str(here), "HERE")
    for usage in WRONG_USAGE:
        yield f"errors/usage-{'-'.join(usage).replace('/', '_').replace('*', '_')}.txt", _said(*usage)


def listings() -> Iterator[Named]:
    """What is listed of the catalogue, and the schema of scene files."""
    yield "lists/cases.json", _said("cases", "--json")
    yield "lists/scene-schema.json", _said("scene", "schema")
    yield "lists/findings.txt", _said("findings")


def states() -> Iterator[Named]:
    """The hashes of the engine's states."""
    yield (
        "states.json",
        json.dumps({name: engine_states.digest(engine_states.last_state(name, 1)) for name in engine_states.WORLDS}, indent=1),
    )


def measured(run: Path) -> Iterator[Named]:
    """Each trajectory of a run, judged anew by its case."""
    cases, rows = plugins.cases(), json.loads(_said("show", str(run), "--table", "trials", "--format", "json"))
    for row in rows:
        path = run / "trajectories" / f"{row['trajectory_hash']}.npz"
        if row["case"] in cases and path.is_file():
            yield f"metrics/{row['trial']}.json", _judged(cases[row["case"]], path)


def _judged(case: Case, path: Path) -> str:
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    scene = parse(str(arrays["scene"]))
    actual = _trajectory(arrays, "")
    truth = (
        Converged(trajectory=_trajectory(arrays, "truth_"), position_error=0.0, velocity_error=0.0)
        if any(name.startswith("truth_") for name in arrays)
        else None
    )
    return json.dumps(
        [[m.metric, float(m.value).hex(), m.unit, m.because] for m in judge(case, scene, actual, truth)], indent=1
    )


def _trajectory(arrays: Mapping[str, Any], prefix: str) -> Trajectory:
    """The trajectory that a file holds: the engine's, or the truth's with the prefix `truth_`."""
    named = {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
    contacts: tuple[Contacts, ...] | None = None
    if "contacts_count" in named:
        ends = np.cumsum(named["contacts_count"])
        spans = zip(ends - named["contacts_count"], ends, strict=True)
        contacts = tuple(Contacts(**{name: named[f"contacts_{name}"][a:b] for name in CONTACTS}) for a, b in spans)
    count = len(named["time"])
    empty = {"p_WB": (count, 0, 3), "q_WB": (count, 0, 4), "v_WB": (count, 0, 3), "w_WB": (count, 0, 3)}
    return Trajectory(
        time=named["time"],
        **{name: named.get(name, np.zeros(shape)) for name, shape in empty.items()},
        dt=float(arrays["dt"]),
        contacts=contacts,
        streams={name.removeprefix("stream:"): signal for name, signal in named.items() if name.startswith("stream:")},
    )


def printed(run: Path) -> Iterator[Named]:
    """The tables of a run in every format, its report, and its files for people and build servers."""
    for table in (*TABLES, *tables.names()):
        for form in FORMATS:
            yield f"tables/{table}.{form}", _said("show", str(run), "--table", table, "--format", form)
    store = Store(run)
    for name, text in rendered(store).items():
        yield f"report/{name}", text
    for name, content in summaries(store).items():
        yield name, content


def differences(before: Path, after: Path) -> Iterator[Named]:
    """What `plumbline diff` says of two runs, and the files that it writes."""
    with TemporaryDirectory() as folder:
        yield "said.txt", _said("diff", str(before), str(after), "--out", folder).replace(folder, "OUT")
        for path in sorted(Path(folder).rglob("*")):
            if path.suffix in TEXTS:
                yield str(path.relative_to(folder)), path.read_text().replace(folder, "OUT")


def of_no_run() -> Iterator[Named]:
    """All that depends on no run but the engine's states."""
    for part in (scenes, helps, errors, listings):
        yield from part()


def record(out: Path, runs: Sequence[Path]) -> None:
    """Write the record into an empty folder."""
    parts = [("", of_no_run()), ("", states())]
    for run in runs:
        parts += [(f"runs/{run.name}/", printed(run)), (f"runs/{run.name}/", measured(run))]
    parts += [(f"diff/{a.name}-{b.name}/", differences(a, b)) for a, b in pairwise(runs)]
    for prefix, part in parts:
        for name, content in part:
            path = out / f"{prefix}{name}"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content if isinstance(content, bytes) else content.encode())


def _said(*arguments: str) -> str:
    """What the command line prints, with its exit code if that is not 0."""
    heard = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        done = CliRunner().invoke(main, arguments, env={"COLUMNS": "100"})
    finally:
        for number, handler in heard.items():
            signal.signal(number, handler)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output if done.exit_code == 0 else f"{done.output}exit {done.exit_code}\n"


if __name__ == "__main__":
    record(Path(sys.argv[1]), [Path(run) for run in sys.argv[2:]])
