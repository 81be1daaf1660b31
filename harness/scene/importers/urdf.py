"""URDF: links and joints as yourdfpy reads them, after our own checks of the text.

URDF says nothing of how the root is held, of gravity, friction, gains and the start: the companion file does. Angles are
radians, the origin of a joint is its child's frame where its coordinate is 0, rpy turns about fixed axes, x first.
"""

from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from harness.intake.allowance import beyond
from harness.intake.documents import named
from harness.intake.refusal import RobotError, listed
from harness.intake.safe_text import readable
from harness.scene.importers import urdf_grammar, urdf_shapes
from harness.scene.importers.fidelity import Fidelity
from harness.scene.importers.files import Folders, text_of
from harness.scene.importers.poses import IDENTITY, Array, Pose
from harness.scene.importers.robot import Coordinate, Link, Need, Robot, Solid, Tie
from harness.scene.importers.urdf_parser import yourdfpy_module
from harness.scene.importers.xml_text import Element, elements


def read(
    path: Path,
    folders: Folders,
    density: float | None = None,
    convex: int | None = None,
    tell: Callable[[str], object] | None = None,
) -> Robot:
    """The robot of a URDF file.

    Args: density [kg/m3] of shapes where no mass is given. convex: the most pieces of a mesh, None for its hull.
        tell: is told of what takes long.
    Raises: RobotError.
    """
    where = named(path)
    root = elements(text_of(path, where), where)
    checked, foreign = urdf_grammar.check(root)
    for kind, tag in (("bodies", "link"), ("joints", "joint")):
        if excess := beyond(kind, len(checked.all(tag))):
            raise checked.refuse(f"<{tag}>: {excess}")
    urdf_grammar.check_tree(checked)
    parsed = _parsed(checked)
    shapes = urdf_shapes.Shapes(folders, density, convex, tell)
    links = {link.name: link for link in parsed.links}
    joints = {joint.child: joint for joint in parsed.joints}
    lines = {(tag, element.attributes["name"]): element for tag in ("link", "joint") for element in checked.all(tag)}
    colours = {material.name: material.color for material in parsed.materials}
    made = {name: _link(links[name], joints.get(name), lines, shapes, colours) for name in _from_the_root(links, joints)}
    made, needs = _tied(made, parsed.joints, lines)
    rows = [*shapes.rows(), *_rows(parsed.joints, foreign)]
    root_name = next(iter(made))
    return Robot(
        name=readable(parsed.name, 100) or path.stem,
        links=tuple(made.values()),
        root="fixed" if root_name == "world" and links[root_name].inertial is None else None,
        rows=tuple(rows),
        needs=tuple(needs),
        source=where,
    )


def _parsed(checked: Element) -> Any:
    """yourdfpy's robot. Raises: RobotError."""
    from xml.sax.saxutils import quoteattr

    yourdfpy = yourdfpy_module()

    def written(element: Element) -> str:
        attributes = "".join(
            f" {name}={quoteattr(text)}" for name, text in element.attributes.items() if ":" not in name and name != "xmlns"
        )
        inner = "".join(written(child) for child in element.children)
        return f"<{element.tag}{attributes}>{inner}</{element.tag}>"

    try:
        text = BytesIO(written(checked).encode())
        return yourdfpy.URDF.load(text, build_scene_graph=False, load_meshes=False).robot
    except Exception as error:  # the parser raises whatever comes
        message = readable(f"{type(error).__name__}: {error}", 300)
        raise RobotError(f"{checked.file}: the URDF parser gives up: {message}") from None


def _from_the_root(links: dict[str, Any], joints: dict[str, Any]) -> list[str]:
    below: dict[str, list[str]] = {}
    for child, joint in joints.items():
        below.setdefault(joint.parent, []).append(child)
    order, waiting = [], [next(name for name in links if name not in joints)]
    while waiting:
        name = waiting.pop()
        order.append(name)
        waiting += reversed(below.get(name, []))
    return order


def _pose(origin: Array | None) -> Pose:
    return IDENTITY if origin is None else Pose(np.array(origin[:3, :3]), np.array(origin[:3, 3]))


def _link(
    link: Any, joint: Any, lines: dict[tuple[str, str], Element], shapes: urdf_shapes.Shapes, colours: dict[str, Any]
) -> Link:
    element = lines["link", link.name]
    geometries = shapes.of(link, element)
    return Link(
        name=link.name,
        parent=None if joint is None else joint.parent,
        X_PL=IDENTITY if joint is None else _pose(joint.origin),
        coordinates=() if joint is None else _coordinates(joint, lines["joint", joint.name]),
        solid=_solid(link, element, shapes),
        geometries=geometries,
        looks=shapes.looks(link, element, colours),
        where=element.where,
    )


def _solid(link: Any, element: Element, shapes: urdf_shapes.Shapes) -> Solid | None:
    """The link's own mass, or that of its shapes; a mass without a tensor is spread over them. Raises: RobotError."""
    given = link.inertial
    if given is None:
        return shapes.filled(link.name)
    mass = given.mass
    if mass is None:
        if given.inertia is not None and given.inertia.any():
            raise element.refuse("<inertial> has an inertia and no <mass>, expected both")
        return shapes.filled(link.name)
    X = _pose(given.origin)
    if mass == 0:
        # A tensor without a mass counts once it is known what it is fixed to: alone it is refused, if it moves.
        none = given.inertia is None or not given.inertia.any()
        return None if none else Solid(0.0, X.p, X.R @ given.inertia @ X.R.T)
    if given.inertia is None:
        return shapes.spread(link.name, mass, X.p if given.origin is not None else None, element)
    return Solid(mass, X.p, X.R @ given.inertia @ X.R.T)


def _coordinates(joint: Any, element: Element) -> tuple[Coordinate, ...]:
    if joint.type == "fixed":
        return ()
    axis = np.array(joint.axis, dtype=np.float64)
    axis = axis / np.linalg.norm(axis)
    if joint.type == "floating":
        return (Coordinate(name=joint.name, kind="free", where=element.where),)
    dynamics, limit = joint.dynamics, joint.limit
    damping = float(dynamics.damping or 0.0) if dynamics is not None else 0.0
    friction = float(dynamics.friction or 0.0) if dynamics is not None else 0.0
    if joint.type == "planar":
        across = np.eye(3)[int(np.argmin(np.abs(axis)))]
        first = np.cross(axis, across) / np.linalg.norm(np.cross(axis, across))
        sides = (("x", "prismatic", first), ("y", "prismatic", np.cross(axis, first)), ("angle", "revolute", axis))
        return tuple(
            Coordinate(name=f"{joint.name}.{side}", kind=kind, axis=along, damping=damping, where=element.where)  # type: ignore[arg-type]
            for side, kind, along in sides
        )
    bounded = joint.type != "continuous" and limit is not None
    return (
        Coordinate(
            name=joint.name,
            kind="prismatic" if joint.type == "prismatic" else "revolute",
            axis=axis,
            lower=limit.lower if bounded else None,
            upper=limit.upper if bounded else None,
            needs_range=joint.type != "continuous" and (limit is None or limit.lower is None or limit.upper is None),
            damping=damping,
            friction_loss=friction,
            effort=None if limit is None or not limit.effort else limit.effort,
            speed=None if limit is None or not limit.velocity else limit.velocity,
            where=element.where,
        ),
    )


def _tied(
    made: dict[str, Link], joints: list[Any], lines: dict[tuple[str, str], Element]
) -> tuple[dict[str, Link], list[Need]]:
    """The links with the ties of their mimics, and those that no tie says: of joints without one coordinate, or locked."""
    mimics = {joint.name: joint.mimic for joint in joints if joint.mimic is not None and joint.type != "fixed"}
    names = {joint.name for joint in joints}
    for name, mimic in mimics.items():
        if mimic.joint not in names:
            element = lines["joint", name].first("mimic")
            assert element is not None
            raise element.refuse(f"joint is {mimic.joint[:80]!r}, expected the name of a <joint>")
    single = {c.name for link in made.values() if len(link.coordinates) == 1 for c in link.coordinates if c.kind != "free"}
    ties = {
        name: Tie(joint=mimic.joint, ratio=1.0 if mimic.multiplier is None else mimic.multiplier, offset=mimic.offset or 0.0)
        for name, mimic in mimics.items()
        if {name, mimic.joint} <= single and mimic.multiplier != 0 and mimic.joint != name
    }
    linked = {
        name: replace(link, coordinates=tuple(replace(c, tie=ties.get(c.name)) for c in link.coordinates))
        for name, link in made.items()
    }
    loose = tuple(name for name in mimics if name not in ties)
    return linked, [Need(kind="mimic", element="joint", names=loose, size="each then moves freely")] if loose else []


def _rows(joints: list[Any], foreign: dict[str, int]) -> list[Fidelity]:
    rows = [
        Fidelity(
            element=tag, name="", count=count, outcome="left_out", consequence=urdf_grammar.FOREIGN.get(tag, "a dialect's own")
        )
        for tag, count in foreign.items()
    ]
    for word, tag in (("safety_controller", "safety_controller"), ("calibration", "calibration")):
        having = [joint.name for joint in joints if getattr(joint, word) is not None]
        if having:
            rows.append(
                Fidelity(
                    element=tag,
                    name=listed(having),
                    count=len(having),
                    outcome="left_out",
                    consequence="a controller's own, no part of the motion of the links",
                )
            )
    ignored = [
        joint.name
        for joint in joints
        if joint.type == "continuous"
        and joint.limit is not None
        and (joint.limit.lower is not None or joint.limit.upper is not None)
    ]
    if ignored:
        rows.append(
            Fidelity(
                element="limit",
                name=listed(ignored),
                count=len(ignored),
                outcome="left_out",
                becomes="no range",
                consequence="a continuous joint has none, as the format says",
            )
        )
    return rows
