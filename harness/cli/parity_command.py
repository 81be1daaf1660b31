"""`plumbline parity`: are two robot files the same robot?"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from harness.cli.guard import GATE, say
from harness.cli.listing import print_json, print_table
from harness.cli.options import json_rows, limited
from harness.intake.import_wishes import DROPPABLE, Wishes, package_roots

if TYPE_CHECKING:
    from harness.scene.parity.difference import Difference

__all__ = ["parity"]

_robot_file = click.Path(path_type=Path, dir_okay=False)


@click.command()
@click.argument("file", type=_robot_file)
@click.argument("other", type=_robot_file, required=False)
@click.option("--map", "names", type=_robot_file, help='TOML: [joints] with a line "name in FILE" = "name in OTHER" for each.')
@click.option("--tolerance", type=click.FloatRange(min=0, min_open=True), help="Relative; 1e-5, what decimals of files hold.")
@click.option("--seed", type=click.IntRange(min=0), default=0, help="Of the ten states at which torques are compared.")
@click.option(
    "--drop", "drop", multiple=True, type=click.Choice(sorted(DROPPABLE)), help="Leave this kind of elements out of both."
)
@click.option("--root", type=click.Choice(["fixed", "floating"]), help="How a root is held of which its file says nothing.")
@click.option("--package", "packages", multiple=True, metavar="NAME=DIR", help="Where package://NAME lies; may be repeated.")
@limited
@json_rows
def parity(file: Path, other: Path | None, as_json: bool, **told: Any) -> None:
    """Say whether FILE and OTHER (URDF, MJCF) are the same robot, and what each difference is worth.

    Without OTHER, FILE is compared with what each engine's own loader makes of it, its root fixed.

    Exit code 1 where they differ beyond the tolerance.
    """
    wishes = Wishes(drop=frozenset(told["drop"]), packages=package_roots(tuple(told["packages"])), root=told["root"])

    from harness.scene.parity.comparison import TOLERANCE, compare, renamed
    from harness.scene.parity.difference import plain
    from harness.scene.parity.joint_names import joint_names
    from harness.scene.parity.stated import pair_of

    tolerance = told["tolerance"] or TOLERANCE
    if other is None:
        _audit(file, wishes, tolerance, told["seed"], as_json)
        return
    a, b = pair_of(file, other, wishes)
    if told["names"] is not None:
        b = renamed(b, joint_names(told["names"], a, b))
    rows = compare(a, b, tolerance, told["seed"])
    if as_json:
        print_json([plain(row) for row in rows])
    elif rows:
        print_table(f"A: {a.source}; B: {b.source}", _COLUMNS, [_cells(row) for row in rows])
        say(f"not the same robot: {len(rows)} quantities differ by more than {tolerance:g}")
    else:
        say(f"the same robot: {len(a.joints)} joints and what they move agree to {tolerance:g}")
    if rows:
        raise click.exceptions.Exit(GATE)


def _audit(file: Path, wishes: Wishes, tolerance: float, seed: int, as_json: bool) -> None:
    """Compare a file with what each engine's own loader makes of it."""
    from dataclasses import replace

    from harness.adapter import Unsupported
    from harness.run.robot_loaders import loaded_apart
    from harness.scene.parity.comparison import compare
    from harness.scene.parity.difference import plain
    from harness.scene.parity.kinds import kind_of
    from harness.scene.parity.stated import facts_of
    from harness.study import plugins

    stated = facts_of(file, replace(wishes, root=None))
    rows = []
    engines = plugins.names("adapters")
    for name, loader in ((engine, way) for engine in engines for way in plugins.adapter(engine).loaders):
        title = f"{name} {loader}".strip()
        try:
            loaded = loaded_apart(name, loader, file)
        except Unsupported as error:
            say(f"{title}: {error}", err=True)
            continue
        for note in loaded.notes:
            say(f"{title}: {note}", err=True)
        if loaded.matrix_gap is not None and loaded.matrix_gap > tolerance:
            say(
                f"{title}: its own mass matrix is {loaded.matrix_gap:.3g} off what its queries say; do not trust the rows",
                err=True,
            )
        changes = [replace(row, kind=kind_of(row)) for row in compare(stated, loaded.facts, tolerance, seed)]
        rows += [{"loader": title, **plain(row)} for row in changes]
        if as_json:
            continue
        if changes:
            cells = [(row.kind, *_cells(row)) for row in changes]
            print_table(f"A: {stated.source}; B: {loaded.facts.source}", ("kind", *_COLUMNS), cells)
        say(f"{title}: {f'{len(changes)} quantities differ' if changes else 'reads the robot that the file states'}")
    if as_json:
        print_json(rows)
    if rows:
        raise click.exceptions.Exit(GATE)


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
