"""URDF: links and joints from elements that the grammar has checked.

URDF says nothing of how the root is held, of gravity, friction, gains and the start: the companion file does. Angles are
radians, the origin of a joint is its child's frame where its coordinate is 0, rpy turns about fixed axes, x first.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import listed
from plumbline.harness.intake.safe_text import readable
from plumbline.harness.scene.importers import urdf_grammar, urdf_shapes
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.files import text_of
from plumbline.harness.scene.importers.importer import Reading
from plumbline.harness.scene.importers.poses import IDENTITY, Array
from plumbline.harness.scene.importers.robot import Coordinate, Link, Need, Robot, Solid, Tie
from plumbline.harness.scene.importers.urdf_grammar import end_of, numbers
from plumbline.harness.scene.importers.urdf_shapes import pose_of
from plumbline.harness.scene.importers.xml_text import Element, elements


def read(path: Path, reading: Reading) -> Robot:
    """The robot of a URDF file. Raises: RobotError."""
    where = named(path)
    root = elements(text_of(path, where), where)
    checked, left = urdf_grammar.check(root, strict=reading.strict)
    if left.unknown and reading.tell is not None:
        reading.tell(f"{where}: left out, since URDF has no such word: {listed(left.words(), 12)}; --strict refuses it")
    for kind, tag in (("bodies", "link"), ("joints", "joint")):
        if excess := beyond(kind, len(checked.all(tag))):
            raise checked.refuse(f"<{tag}>: {excess}")
    order = urdf_grammar.check_tree(checked)
    shapes = urdf_shapes.Shapes(reading.folders, reading.companion.density, reading.convex, reading.tell)
    links = {link.attributes["name"]: link for link in checked.all("link")}
    joints = {end_of(joint, "child"): joint for joint in checked.all("joint")}
    materials = {material.attributes.get("name"): material for material in checked.all("material")}
    read = {name: _link(links[name], joints.get(name), shapes, materials) for name in order}
    read, needs = _tied(read, checked.all("joint"))
    rows = [*shapes.rows(), *_rows(checked.all("joint"), left)]
    root_name = next(iter(read))
    return Robot(
        name=readable(checked.attributes.get("name", ""), 100) or path.stem,
        links=tuple(read.values()),
        root="fixed" if root_name == "world" and links[root_name].first("inertial") is None else None,
        rows=tuple(rows),
        needs=tuple(needs),
        wordless=frozenset({"drive"}),
        source=where,
    )


def _number(element: Element | None, name: str, default: float | None = None) -> float | None:
    """The number of an attribute, if the element is there and has it."""
    values = None if element is None else numbers(element, name)
    return default if values is None else values[0]


def _link(link: Element, joint: Element | None, shapes: urdf_shapes.Shapes, materials: dict[str | None, Element]) -> Link:
    geometries = shapes.of(link)
    return Link(
        name=link.attributes["name"],
        parent=None if joint is None else end_of(joint, "parent"),
        X_PL=IDENTITY if joint is None else pose_of(joint),
        coordinates=() if joint is None else _coordinates(joint),
        solid=_solid(link, shapes),
        geometries=geometries,
        looks=shapes.looks(link, materials),
        where=link.where,
    )


def _inertia(inertial: Element) -> Array | None:
    """The tensor [kg m2], (3, 3); None if there is none."""
    stated = inertial.first("inertia")
    if stated is None:
        return None
    xx, xy, xz, yy, yz, zz = (_number(stated, f"i{axes}") for axes in ("xx", "xy", "xz", "yy", "yz", "zz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=np.float64)


def _solid(link: Element, shapes: urdf_shapes.Shapes) -> Solid | None:
    """The link's own mass, or that of its shapes; a mass without a tensor is spread over them. Raises: RobotError."""
    name, inertial = link.attributes["name"], link.first("inertial")
    if inertial is None:
        return shapes.filled(name)
    mass, inertia = _number(inertial.first("mass"), "value"), _inertia(inertial)
    if mass is None:
        if inertia is not None and inertia.any():
            raise link.refuse("<inertial> has an inertia and no <mass>, expected both")
        return shapes.filled(name)
    X = pose_of(inertial)
    if mass == 0:
        # A tensor without a mass counts once it is known what it is fixed to: alone it is refused, if it moves.
        return None if inertia is None or not inertia.any() else Solid(0.0, X.p, X.R @ inertia @ X.R.T)
    if inertia is None:
        return shapes.spread(name, mass, None if inertial.first("origin") is None else X.p, link)
    return Solid(mass, X.p, X.R @ inertia @ X.R.T)


def _coordinates(joint: Element) -> tuple[Coordinate, ...]:
    name, kind, stated = joint.attributes["name"], joint.attributes["type"], joint.first("axis")
    if kind == "fixed":
        return ()
    if kind == "floating":
        return (Coordinate(name=name, kind="free", where=joint.where),)
    axis = np.array((stated and numbers(stated, "xyz", (3,))) or (1.0, 0.0, 0.0))
    axis = axis / np.linalg.norm(axis)
    damping = _number(joint.first("dynamics"), "damping") or 0.0
    if kind == "planar":
        across = np.eye(3)[int(np.argmin(np.abs(axis)))]
        first = np.cross(axis, across) / np.linalg.norm(np.cross(axis, across))
        sides = (("x", "prismatic", first), ("y", "prismatic", np.cross(axis, first)), ("angle", "revolute", axis))
        return tuple(
            Coordinate(name=f"{name}.{side}", kind=moves, axis=along, damping=damping, where=joint.where)  # type: ignore[arg-type]
            for side, moves, along in sides
        )
    limit = joint.first("limit")
    lower, upper = (None if kind == "continuous" else _number(limit, end) for end in ("lower", "upper"))
    return (
        Coordinate(
            name=name,
            kind="prismatic" if kind == "prismatic" else "revolute",
            axis=axis,
            lower=lower,
            upper=upper,
            needs_range=kind != "continuous" and (lower is None or upper is None),
            damping=damping,
            friction_loss=_number(joint.first("dynamics"), "friction") or 0.0,
            effort=_number(limit, "effort") or None,
            speed=_number(limit, "velocity") or None,
            where=joint.where,
        ),
    )


def _tied(read: dict[str, Link], joints: list[Element]) -> tuple[dict[str, Link], list[Need]]:
    """The links with the ties of their mimics, and those that no tie says: of joints without one coordinate, or locked."""
    kinds = {joint.attributes["name"]: joint.attributes["type"] for joint in joints}
    mimics = {name: mimic for name, mimic in _mimics(joints).items() if kinds[name] != "fixed"}
    for mimic in mimics.values():
        if mimic.attributes["joint"] not in kinds:
            raise mimic.refuse(f"joint is {mimic.attributes['joint'][:80]!r}, expected the name of a <joint>")
    single = {c.name for link in read.values() if len(link.coordinates) == 1 for c in link.coordinates if c.kind != "free"}
    ties = {
        name: Tie(joint=leader, ratio=ratio[0], offset=_number(mimic, "offset") or 0.0)
        for name, mimic in mimics.items()
        if {name, leader := mimic.attributes["joint"]} <= single
        and (ratio := numbers(mimic, "multiplier") or (1.0,))[0] != 0
        and leader != name
    }
    linked = {
        name: replace(link, coordinates=tuple(replace(c, tie=ties[c.name]) for c in link.coordinates))
        if any(c.name in ties for c in link.coordinates)
        else link
        for name, link in read.items()
    }
    still = tuple(name for name in mimics if name not in ties and kinds[mimics[name].attributes["joint"]] == "fixed")
    loose = tuple(name for name in mimics if name not in ties and name not in still)
    immobile = "of a fixed joint, which does not move; each then moves freely"
    needs = Need.of("mimic", "joint", loose, "each then moves freely") + Need.of("mimic", "joint", still, immobile)
    return linked, needs


def _mimics(joints: list[Element]) -> dict[str, Element]:
    return {joint.attributes["name"]: mimic for joint in joints if (mimic := joint.first("mimic")) is not None}


def _rows(joints: list[Element], left: urdf_grammar.Left) -> list[Fidelity]:
    rows = list[Fidelity]()
    for tag, count in left.foreign.items():
        rows += Fidelity.left_out(tag, "", urdf_grammar.FOREIGN.get(tag, "a dialect's own"), count=count)
    for word, owners in left.unknown.items():
        rows += Fidelity.left_out(word, owners, "no word of URDF, and near none that changes the motion")
    for tag in ("safety_controller", "calibration"):
        having = [joint.attributes["name"] for joint in joints if joint.first(tag) is not None]
        rows += Fidelity.left_out(tag, having, "a controller's own, no part of the motion of the links")
    idle = list(_mimics([joint for joint in joints if joint.attributes["type"] == "fixed"]))
    rows += Fidelity.left_out("mimic", idle, "a fixed joint moves with nobody")
    ignored = [
        joint.attributes["name"]
        for joint in joints
        if joint.attributes["type"] == "continuous"
        and (limit := joint.first("limit")) is not None
        and limit.attributes.keys() & {"lower", "upper"}
    ]
    rows += Fidelity.left_out("limit", ignored, "a continuous joint has none, as the format says", becomes="no range")
    return rows
