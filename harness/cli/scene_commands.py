"""The commands on scene files of one's own: what is in one, what would be refused, our own words for it, a template."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plumbline.harness.cli.guard import GATE, say
from plumbline.harness.cli.listing import print_json, print_table
from plumbline.harness.cli.options import json_rows, limited
from plumbline.harness.cli.robot_options import imported_from, robot_options

if TYPE_CHECKING:
    from plumbline.harness.scene import Scene
    from plumbline.harness.scene.importers.fidelity import Imported

_file = click.argument("file", type=click.Path(path_type=Path))


@click.group()
def scene() -> None:
    """Look at scene and robot files: TOML, JSON, URDF, MJCF, SDF."""


@scene.command()
@_file
@robot_options
@limited
@json_rows
def check(file: Path, as_json: bool, **options: Any) -> None:
    """Say what would be refused of FILE, or that nothing is, and which engines cannot express the scene."""
    from plumbline.harness.study import plugins
    from plumbline.harness.study.zoo.taking_in import expressed_apart

    imported = imported_from(file, options)
    rows = [
        {"engine": name, "verdict": verdict, "reason": reason}
        for name in plugins.names("adapters")
        for verdict, reason in (expressed_apart(name, imported.scene),)
    ]
    if as_json:
        print_json(rows)
    else:
        say(f"{imported.source}: a scene of {len(imported.scene.bodies)} bodies and {len(imported.scene.joints)} joints")
        print_table("Engines", ("engine", "verdict", "reason"), [tuple(row.values()) for row in rows])
    if any(row["verdict"] == "failed" for row in rows):
        sys.exit(GATE)


@scene.command()
@_file
@robot_options
@limited
@json_rows
def show(file: Path, as_json: bool, **options: Any) -> None:
    """List the bodies, joints and totals of FILE, and what became of each element."""
    from plumbline.harness.scene.importers.fidelity import BRIEF, brief, plain

    imported = imported_from(file, options)
    rows = [plain(row) for row in imported.fidelity]
    if as_json:
        print_json([*_bodies(imported.scene), *_joints(imported), *({"kind": "fidelity", **row} for row in rows)])
        return
    bodies, joints = _bodies(imported.scene), _joints(imported)
    print_table(
        "Bodies", ("name", "motion", "mass kg", "least, most inertia kg m2", "shapes", "material"), [_cells(b) for b in bodies]
    )
    if joints:
        print_table(
            "Joints",
            ("name", "type", "parent", "child", "start", "range", "spring", "drive"),
            [_joint_cells(j) for j in joints],
        )
    moving = [body for body in bodies if body["motion"] == "dynamic"]
    say(f"{len(moving)} bodies move, with {sum(body['mass'] for body in moving):.6g} kg in all; {len(joints)} joints")
    say(
        f"gravity {', '.join(f'{g:g}' for g in imported.scene.gravity)} m/s2; "
        f"effects: {', '.join(imported.scene.effects.names)}"
    )
    if rows:
        print_table("What became of each element", BRIEF, [brief(row) for row in rows])


def _bodies(scene: "Scene") -> list[dict[str, Any]]:
    import numpy as np

    rows = []
    for body in scene.bodies:
        least, _, most = np.linalg.eigvalsh(np.array(body.inertia)).tolist()
        row = {"kind": "body", "name": body.name, "motion": body.motion, "mass": body.mass}
        row |= {"least_inertia": least, "most_inertia": most}
        row |= {"shapes": ", ".join(dict.fromkeys(placed.shape.type for placed in body.collision)), "material": body.material}
        rows.append(row | {"p_WB": list(body.p_WB)})
    return rows


def _cells(body: dict[str, Any]) -> tuple[object, ...]:
    inertia = f"{body['least_inertia']:.3g}, {body['most_inertia']:.3g}"
    moves = body["motion"] == "dynamic"
    return (body["name"], body["motion"], f"{body['mass']:.4g}" * moves, inertia * moves, body["shapes"], body["material"])


def _joints(imported: "Imported") -> list[dict[str, Any]]:
    rows = []
    for joint in imported.scene.joints:
        row: dict[str, Any] = {"kind": "joint"} | {name: getattr(joint, name) for name in ("name", "type", "parent", "child")}
        limits, spring, drive = (getattr(joint, name, None) for name in ("limits", "spring", "drive"))
        row["position"] = getattr(joint, "position", None)
        row |= {"lower": limits.lower, "upper": limits.upper} if limits else {"lower": None, "upper": None}
        row |= {f"spring_{name}": getattr(spring, name) for name in ("stiffness", "damping", "rest")} if spring else {}
        row |= {f"drive_{name}": getattr(drive, name) for name in ("stiffness", "damping", "target", "limit")} if drive else {}
        rows.append(row)
    return rows


def _joint_cells(row: dict[str, Any]) -> tuple[object, ...]:
    def number(value: float | None) -> str:
        return "" if value is None else f"{value:.4g}"

    bounded = row["lower"] is not None or row["upper"] is not None
    limits = f"{number(row['lower']) or '-inf'} .. {number(row['upper']) or 'inf'}" if bounded else ""
    spring = f"{row['spring_stiffness']:.3g}, {row['spring_damping']:.3g}" if "spring_stiffness" in row else ""
    drive = (
        f"{row['drive_stiffness']:.3g}, {row['drive_damping']:.3g} to {row['drive_target']:.3g}"
        if "drive_target" in row
        else ""
    )
    return (row["name"], row["type"], row["parent"], row["child"], number(row["position"]), limits, spring, drive)


@scene.command()
@_file
@robot_options
@limited
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="Write it there instead; ending .toml or .json.")
def convert(file: Path, out: Path | None, **options: Any) -> None:
    """Write FILE as our own TOML."""
    from plumbline.harness.scene.file import dump_json, dump_toml

    if out is not None and out.suffix not in (".toml", ".json"):
        raise click.BadParameter(f"'{out.suffix}', expected .toml or .json", param_hint="--out")
    imported = imported_from(file, options)
    if out is None:
        click.echo(dump_toml(imported.scene), nl=False)
        return
    out.write_text((dump_json if out.suffix == ".json" else dump_toml)(imported.scene), encoding="utf-8")
    say(str(out), err=True)


@scene.command()
def schema() -> None:
    """Print the JSON schema of scene files."""
    import json

    from plumbline.harness.scene.file import schema as of_scenes

    click.echo(json.dumps(of_scenes(), indent=1))


@scene.command()
@_file
def new(file: Path) -> None:
    """Write a commented template to FILE, which is not there yet."""
    from plumbline.harness.scene.file import TEMPLATE

    if file.suffix != ".toml":
        raise click.BadParameter(f"'{file.suffix}', expected the ending .toml", param_hint="FILE")
    try:
        with file.open("x", encoding="utf-8") as out:
            out.write(TEMPLATE.read_text(encoding="utf-8"))
    except FileExistsError:
        raise click.BadParameter(f"'{file}' is there already; expected a new name", param_hint="FILE") from None
    say(f"{file}; plumbline run {file} puts it to every engine", err=True)
