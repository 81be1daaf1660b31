"""`plumbline parity`: are two robot files the same robot, and what does each engine's own loader make of one?"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plumbline.harness.cli.guard import GATE, say
from plumbline.harness.cli.listing import print_json, print_table
from plumbline.harness.cli.options import json_rows, limited
from plumbline.harness.cli.robot_options import drop_option
from plumbline.harness.intake.import_wishes import Wishes, package_roots

if TYPE_CHECKING:
    from plumbline.harness.run.importer_audit import LoaderReading
    from plumbline.harness.scene.parity.canonical import Canonical
    from plumbline.harness.scene.parity.difference import Difference
    from plumbline.harness.scene.parity.parting import Parting
    from plumbline.harness.store.imported_scenes import ParityRecord, ParitySide

_robot_file = click.Path(path_type=Path, dir_okay=False)


@click.command()
@click.argument("file", type=_robot_file)
@click.argument("other", type=_robot_file, required=False)
@click.option("--map", "names", type=_robot_file, help='TOML: [joints] with a line "name in FILE" = "name in OTHER" for each.')
@click.option("--tolerance", type=click.FloatRange(min=0, min_open=True), help="Relative; 1e-5, what decimals of files hold.")
@click.option("--seed", type=click.IntRange(min=0), default=0, help="Of the ten states at which torques are compared.")
@drop_option("Leave out of both")
@click.option("--root", type=click.Choice(["fixed", "floating"]), help="How a root is held of which its file says nothing.")
@click.option("--package", "packages", multiple=True, metavar="NAME=DIR", help="Where package://NAME lies; may be repeated.")
@click.option("--move", metavar="drop|sines|CSV", help="Move FILE and OTHER by the same torques: when and where do they part?")
@click.option("--commands", type=_robot_file, metavar="LOG", help="Move both by recorded torques: time, knee:torque, ...")
@click.option("--interpolate", is_flag=True, help="Join the values of --commands by straight lines; else they are held.")
@click.option("--seconds", type=click.FloatRange(min=0.01, max=60.0), default=2.0, help="How long they are moved; 2.")
@click.option("--gate", "gated", multiple=True, metavar="ENGINE", help="Exit 1 where a loader of it changes FILE undocumented.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Write the comparison and its page there.")
@limited
@json_rows
def parity(file: Path, other: Path | None, as_json: bool, **options: Any) -> None:
    """Say whether FILE and OTHER (URDF, MJCF, SDF) are the same robot, and what each difference is worth.

    Without OTHER, FILE is compared with what each engine's own loader makes of it.

    Exit code 1 where FILE and OTHER differ beyond the tolerance. What loaders change is a finding and no failure, unless --gate
    names their engine: then 1 where it changes something that its documentation does not tell.
    """
    wishes = Wishes(drop=frozenset(options["drop"]), packages=package_roots(tuple(options["packages"])), root=options["root"])
    from plumbline.harness.scene.parity.comparison import TOLERANCE

    options["tolerance"] = options["tolerance"] or TOLERANCE
    if other is None:
        for option, name in (("--map", "names"), ("--move", "move"), ("--commands", "commands")):
            if options[name] is not None:
                raise click.UsageError(f"{option} is for two files, and OTHER is not given")
        failed = _audit(file, wishes, as_json, options)
    else:
        if options["gated"]:
            raise click.UsageError("--gate is for one file: two files that differ always end in exit code 1")
        failed = _pair(file, other, wishes, as_json, options)
    if failed:
        raise click.exceptions.Exit(GATE)


def _pair(file: Path, other: Path, wishes: Wishes, as_json: bool, options: dict[str, Any]) -> bool:
    """Compare two files. Do they differ?"""
    from dataclasses import asdict

    from plumbline.harness.scene.parity.canonical import joint_names, pair_of, renamed
    from plumbline.harness.scene.parity.comparison import compare, compared
    from plumbline.harness.scene.parity.difference import plain
    from plumbline.harness.store.imported_scenes import ParitySide

    if options["move"] is not None and options["commands"] is not None:
        raise click.UsageError("--move and --commands both say what moves the robots, expected one of them")
    if options["interpolate"] and options["commands"] is None:
        raise click.UsageError("--interpolate is about --commands, which is not given")
    tolerance, move = options["tolerance"], options["move"] or options["commands"]
    a, b = pair_of(file, other, wishes)
    if options["names"] is not None:
        b = renamed(b, joint_names(options["names"], a, b))
    rows = compare(a, b, tolerance, options["seed"])
    if as_json:
        print_json([plain(row) for row in rows])
    elif rows:
        print_table(f"A: {a.source}; B: {b.source}", _COLUMNS, [_cells(row) for row in rows])
        say(f"not the same robot: {len(rows)} quantities differ by more than {tolerance:g}")
    else:
        say(f"the same robot: {len(a.joints)} joints and what they move agree to {tolerance:g}")
    looked_at, passed_over = compared(a, b)
    parted = None if move is None else _moved(a, b, options, as_json)
    if parted is not None:
        say(_told(parted), err=as_json)
    say(f"compared: {', '.join(looked_at)}; not compared: {', '.join(passed_over)}", err=as_json)
    side = ParitySide(name=other.name, source=b.source, rows=tuple(plain(row) for row in rows))
    parting = None if parted is None else {"move": _move_name(str(move)), **asdict(parted)}
    _keep(file, a, "floating" if a.joints and a.joints[0].kind == "free" else "fixed", (side,), options, parting)
    return bool(rows)


def _moved(a: "Canonical", b: "Canonical", options: dict[str, Any], as_json: bool) -> "Parting":
    """Both under the same torques. Raises: RobotError, Unsupported."""
    import numpy as np

    from plumbline.harness.intake.error import RobotError
    from plumbline.harness.scene import EARTH_GRAVITY
    from plumbline.harness.scene.parity.canonical import aligned
    from plumbline.harness.scene.parity.motion import Configuration, drawn
    from plumbline.harness.scene.parity.parting import motion_of, parting
    from plumbline.harness.study import plugins

    partner = aligned(a, b)
    if partner is None or not a.joints:
        raise RobotError(
            "--move: the trees of the two files differ, so that no motion of both can be compared; --map may mend it"
        )
    gravity = np.array(a.gravity or b.gravity or EARTH_GRAVITY)
    start: Configuration = drawn(a, partner, options["seed"])[0]
    if any(closure.kind != "spring" for closure in (*a.closures, *partner.closures)):
        start = Configuration(np.zeros(len(a.joints)), {}, start.rates)
    commands, held = options["commands"], options["commands"] is not None and not options["interpolate"]
    motion = motion_of(
        str(options["move"] or commands), a, start, gravity, options["seconds"], replay=commands is not None, held=held,
        tell=lambda line: say(line, err=as_json),
    )  # fmt: skip
    engine = plugins.adapter("mujoco")
    return parting(a, engine.move_robot(a, motion), engine.move_robot(partner, motion))


def _told(parted: "Parting") -> str:
    far = f"'{parted.farthest}' is the farthest, {parted.distance:.3g} {parted.farthest_unit} at most"
    if parted.time is None:
        return f"moved alike, they do not part in {parted.duration:g} s: {far}"
    return f"moved alike, they part after {parted.time:.4g} s, at '{parted.joint}'; {far} within {parted.duration:g} s"


def _move_name(move: str) -> str:
    from plumbline.harness.scene.parity.parting import MOVES

    return move if move in MOVES else Path(move).name


def _audit(file: Path, wishes: Wishes, as_json: bool, options: dict[str, Any]) -> bool:
    """Compare a file with what each engine's own loader makes of it. Does a gated engine change it undocumented?"""
    from dataclasses import replace

    from plumbline.harness.run.importer_audit import audit
    from plumbline.harness.scene.parity.comparison import compared
    from plumbline.harness.scene.parity.difference import plain
    from plumbline.harness.scene.parity.loaded import UNTOLD
    from plumbline.harness.study import plugins

    for name in options["gated"]:
        if name not in plugins.names("adapters") or not plugins.adapter(name).loaders:
            having = [engine for engine in plugins.names("adapters") if plugins.adapter(engine).loaders]
            raise click.BadParameter(f"'{name}', expected one of {', '.join(having)}", param_hint="--gate")
    readings = []
    for reading in audit(file, wishes, options["tolerance"], options["seed"]):
        readings.append(reading)
        _report(reading, options["tolerance"], as_json)
    if as_json:
        print_json([{"loader": reading.title, **plain(row)} for reading in readings for row in (*reading.rows, *reading.own)])
    stated = readings[0].stated
    looked_at, passed_over = compared(stated, replace(stated, wordless=stated.wordless | UNTOLD))
    if not all(reading.refused for reading in readings):
        say(f"compared: {', '.join(looked_at)}; not compared: {', '.join(passed_over)}", err=as_json)
    _keep(file, stated, readings[0].root, tuple(map(_side, readings)), options)
    return any(reading.engine in options["gated"] and (reading.refused or reading.undocumented) for reading in readings)


def _report(reading: "LoaderReading", tolerance: float, as_json: bool) -> None:
    """What one loader made, on the terminal."""
    if reading.refused:
        say(f"{reading.title}: {reading.refused}", err=True)
        return
    for note in reading.notes:
        say(f"{reading.title}: {note}", err=True)
    if reading.matrix_gap is not None and reading.matrix_gap > tolerance:
        gap = f"its own mass matrix is {reading.matrix_gap:.3g} off what its queries say; do not trust the rows"
        say(f"{reading.title}: {gap}", err=True)
    if as_json:
        return
    if reading.rows:
        cells = [(row.kind + " (documented)" * bool(row.documented), *_cells(row)) for row in reading.rows]
        print_table(f"A: {reading.stated.source}; B: {reading.source}", ("kind", *_COLUMNS), cells)
    count = len(reading.rows)
    documented = count - len(reading.undocumented)
    summary = f"{count} quantities differ, {documented} of them by a documented default"
    say(f"{reading.title}: {summary if count else 'reads the robot that the file states'}")
    if reading.own:
        say(f"{reading.title}: of its own, where the file has no word, it gives {reading.own_words}")


def _side(reading: "LoaderReading") -> "ParitySide":
    from plumbline.harness.scene.parity.difference import plain
    from plumbline.harness.store.imported_scenes import ParitySide
    from plumbline.harness.study import plugins

    name = f"{plugins.adapter(reading.engine).title} {reading.way}".strip()
    own = (f"of its own, where the file has no word, it gives {reading.own_words}",) if reading.own else ()
    return ParitySide(
        name=name, engine=reading.engine, source=reading.source, refused=reading.refused,
        rows=tuple(plain(row) for row in reading.rows), notes=(*reading.notes, *own), matrix_gap=reading.matrix_gap,
    )  # fmt: skip


def _keep(
    file: Path,
    a: "Canonical",
    root: str,
    sides: "tuple[ParitySide, ...]",
    options: dict[str, Any],
    parting: dict[str, Any] | None = None,
) -> None:
    """Where --out asks for it, the record of the comparison and its page."""
    if options["out"] is None:
        return
    from plumbline.harness.store import imported_scenes
    from plumbline.reports.standalone.parity import write_page

    record: ParityRecord = imported_scenes.ParityRecord(
        file=file.name, joints=len(a.joints), root=root, tolerance=options["tolerance"], seed=options["seed"], sides=sides,
        parting=parting,
    )  # fmt: skip
    imported_scenes.write(options["out"], record)
    say(f"page: {write_page(options['out'])}", err=True)


_COLUMNS = ("quantity", "of", "A", "B", "unit", "differs by", "relative", "consequence")


def _cells(row: "Difference") -> tuple[object, ...]:
    def shown(value: object) -> str:
        if value is None:
            return "none"
        if isinstance(value, tuple):
            return ", ".join(f"{number:.5g}" for number in value)
        return f"{value:.7g}" if isinstance(value, float) else str(value)

    sizes = ("" if size is None else f"{size:.3g}" for size in (row.absolute, row.relative))
    return (row.quantity.replace("_", " "), row.element, shown(row.value_A), shown(row.value_B), row.unit, *sizes, row.words)
