"""SDF: one model, alone or in a world, with the models nested in it as one tree of links and joints.

A link that no joint holds is free, unless its model is static; what is not said has the specification's default.
Source: Open Robotics, SDFormat Specification 1.6 to 1.11.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import listed
from plumbline.harness.intake.safe_text import quoted, readable
from plumbline.harness.scene import WORLD, Sensor
from plumbline.harness.scene.importers import sdf_grammar
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.files import text_of
from plumbline.harness.scene.importers.importer import Reading
from plumbline.harness.scene.importers.poses import IDENTITY, Array, Pose
from plumbline.harness.scene.importers.robot import Coordinate, Link, Need, Robot, Solid, Tie, parents_first
from plumbline.harness.scene.importers.sdf_frames import ITSELF, Scope
from plumbline.harness.scene.importers.sdf_grammar import VERSIONS, flag, number, numbers, word
from plumbline.harness.scene.importers.sdf_sensors import Sensors
from plumbline.harness.scene.importers.sdf_shapes import Collisions
from plumbline.harness.scene.importers.xml_text import Element, elements

GRAVITY = (0.0, 0.0, -9.8)
"""Of a world that says none [m/s2]."""
_OPEN = 1e16
"""A bound of this size or more is none."""
_TYPES = ("revolute", "continuous", "prismatic", "ball", "fixed")


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """A link or joint. Terms: scope: its model's. X_WM: pose of that model in W."""

    element: Element
    scope: Scope
    X_WM: Pose

    @property
    def name(self) -> str:
        """With the names of the models around it."""
        return self.scope.prefix + self.element.attributes["name"]

    def pose(self) -> Pose:
        """In W."""
        return self.X_WM @ self.scope.pose_of(self.element.attributes["name"], self.element)


def read(path: Path, reading: Reading) -> Robot:
    """The robot of an SDF file. Raises: RobotError."""
    where = named(path)
    root = elements(text_of(path, where), where)
    if root.tag != "sdf":
        raise root.refuse("is the root of the file, expected <sdf>")
    version = root.attributes.get("version", "")
    if version not in VERSIONS:
        raise root.refuse(
            f"version is {quoted(version, 40)}, expected one of {', '.join(VERSIONS)}; gz sdf -p writes a newer one"
        )
    for element in root.walk():
        if element.tag == "include":
            raise element.refuse(
                f"another model is not fetched; 'gz sdf -p {path.name}' writes the file with all that it includes"
            )
    left = sdf_grammar.SdfLeft()
    model, gravity, others = _chosen(root, left, reading.strict)
    scope = Scope.of(model)
    links, joints = _parts(scope, _model_pose(model, scope))
    for kind, count in (("bodies", len(links)), ("joints", len(joints))):
        if excess := beyond(kind, count):
            raise model.refuse(excess)
    held = {} if flag(model, "static") else _held(joints, links)
    parents = {name: joint.scope.link_of(word(joint.element, "parent"), joint.element) for name, joint in held.items()}
    collisions, sensors, needs = Collisions(reading, flag(model, "self_collide")), Sensors(), list[Need]()
    robot_links, mounted = [Link(name=WORLD, parent=None, where=model.where)], list[Sensor]()
    for name in _from_the_world(links, parents):
        placed, joint, parent = links[name], held.get(name), parents.get(name, WORLD)
        X_WL, X_WP = placed.pose(), IDENTITY if parent == WORLD else links[parent].pose()
        free = joint is None and not flag(model, "static")
        X_ML = placed.scope.pose_of(placed.element.attributes["name"], placed.element)
        geometries = collisions.of(placed.element, placed.scope, X_ML, name)
        robot_links.append(
            Link(
                name=name,
                parent=parent,
                X_PL=X_WP.inverse() @ X_WL,
                coordinates=(Coordinate(name=f"{name}.root", kind="free", where=placed.element.where),)
                if free
                else _coordinates(joint, X_WL, version),
                solid=_solid(placed, X_ML, collisions, needs),
                geometries=geometries,
                where=placed.element.where,
            )
        )
        for element in placed.element.all("sensor"):
            X_MS = placed.scope.placed(element, placed.element.attributes["name"])
            sensor = sensors.of(element, name, placed.scope.prefix, X_ML.inverse() @ X_MS)
            mounted += [] if sensor is None else [sensor]
    needs += _needs(links)
    contacts, contact_rows = collisions.contacts()
    if left.unknown and reading.tell is not None:
        words = listed(list(left.unknown), 12)
        reading.tell(f"{where}: left out, since SDF has no such word: {words}; --strict refuses it")
    floating = any(c.kind == "free" for link in robot_links for c in link.coordinates)
    return Robot(
        name=readable(model.attributes.get("name", ""), 100) or path.stem,
        links=tuple(robot_links),
        root="floating" if floating else "fixed",
        gravity=gravity,
        contacts=contacts,
        filter_world=False,
        sensors=tuple(mounted),
        rows=(*collisions.rows(), *contact_rows, *sensors.rows(), *_rows(left, others, links)),
        needs=tuple(needs),
        wordless=frozenset({"drive"}),
        source=where,
    )


def _chosen(
    root: Element, left: sdf_grammar.SdfLeft, strict: bool
) -> tuple[Element, tuple[float, float, float] | None, list[str]]:
    """The one model, gravity where a world says it, and the names of models that stand still beside it. Raises: RobotError."""
    worlds, models = root.all("world"), root.all("model")
    if len(worlds) + bool(models) != 1:
        raise root.refuse(f"has {len(worlds)} worlds and {len(models)} models, expected one world or one model")
    gravity, still = None, list[Element]()
    if worlds:
        (world,) = worlds
        x, y, z = numbers(world, "gravity", (3,)) or GRAVITY
        gravity, models = (x, y, z), world.all("model")
        if world.first("joint") is not None:
            raise world.all("joint")[0].refuse("joins models of a world, expected it in a model that holds them")
    else:
        world = root
    if len(models) > 1:
        still = [model for model in models if flag(model, "static")]
        models = [model for model in models if model not in still]
    if len(models) != 1:
        names = listed([model.attributes.get("name", "") for model in models], 8)
        raise world.refuse(f"holds {len(models)} models that can move: {names or 'none'}; expected one")
    checked = [child for child in world.children if child.tag != "model" or child in models]
    around = Element(world.tag, world.attributes, world.file, world.line, checked)
    sdf_grammar.check(around if worlds else models[0], left, strict=strict)
    return models[0], gravity, [model.attributes.get("name", "") for model in still]


def _model_pose(model: Element, scope: Scope) -> Pose:
    stated = model.first("pose")
    if stated is not None and stated.attributes.get("relative_to", WORLD) not in ("", WORLD):
        raise stated.refuse("tells the model's pose in a frame of a world, expected one in the world itself")
    X_WM = scope.placed(Element("frame", {}, model.file, model.line, [] if stated is None else [_plain(stated)]), ITSELF)
    anchor = model.attributes.get("placement_frame")
    return X_WM if anchor is None else X_WM @ scope.pose_of(anchor, model).inverse()


def _plain(stated: Element) -> Element:
    """The <pose> without the frame that it is told in."""
    attributes = {name: value for name, value in stated.attributes.items() if name not in ("relative_to", "frame")}
    return Element(stated.tag, attributes, stated.file, stated.line, [], stated.text)


def _parts(scope: Scope, X_WM: Pose) -> tuple[dict[str, _Placed], list[_Placed]]:
    """All links by name, and all joints, of a model and of those nested in it."""
    links = {placed.name: placed for element in scope.model.all("link") for placed in [_Placed(element, scope, X_WM)]}
    joints = [_Placed(element, scope, X_WM) for element in scope.model.all("joint")]
    for name, inner in scope.models.items():
        more, others = _parts(inner, X_WM @ scope.pose_of(name, inner.model))
        links |= more
        joints += others
    return links, joints


def _held(joints: list[_Placed], links: dict[str, _Placed]) -> dict[str, _Placed]:
    """The joint of each link that hangs on one. Raises: RobotError, where two hold one, or an end is none."""
    held: dict[str, _Placed] = {}
    for joint in joints:
        kind = joint.element.attributes.get("type", "")
        if kind not in _TYPES:
            raise joint.element.refuse(f"type is {quoted(kind, 60)}, expected one of {', '.join(_TYPES)}")
        parent, child = (joint.scope.link_of(word(joint.element, end), joint.element) for end in ("parent", "child"))
        if child in (WORLD, parent):
            raise joint.element.refuse(f"child is {quoted(child, 80)}, expected another link")
        for end in (parent, child):
            if end != WORLD and end not in links:
                raise joint.element.refuse(f"{quoted(end, 80)} is no link, expected one of {listed(list(links), 12)}")
        if child in held:
            raise joint.element.refuse(
                f"child {quoted(child, 80)} already hangs on joint {quoted(held[child].name, 80)} (line "
                f"{held[child].element.line}); expected a tree: a loop is not read"
            )
        held[child] = joint
    return held


def _from_the_world(links: dict[str, _Placed], parents: dict[str, str]) -> list[str]:
    """The links, parents before children. Raises: RobotError, where joints go round in a circle."""
    order = parents_first(parents, [WORLD, *(name for name in links if name not in parents)])[1:]
    if len(order) < len(links):
        lost = next(placed for name, placed in links.items() if name not in order)
        raise lost.element.refuse("hangs in a circle of joints, expected a tree")
    return order


def _coordinates(joint: _Placed | None, X_WL: Pose, version: str) -> tuple[Coordinate, ...]:
    """Of a joint in the frame of its child. Raises: RobotError."""
    if joint is None or joint.element.attributes["type"] == "fixed":
        return ()
    element, kind = joint.element, joint.element.attributes["type"]
    X_MJ = joint.scope.pose_of(element.attributes["name"], element)
    anchor = X_WL.inverse().of((joint.X_WM @ X_MJ).p)
    if kind == "ball":
        return (Coordinate(name=joint.name, kind="ball", anchor=anchor, where=element.where),)
    stated = element.first("axis")
    if stated is None:
        raise element.refuse("has no <axis>, expected one")
    axis = X_WL.R.T @ joint.X_WM.R @ _direction(joint, stated, X_MJ, version)
    limit, dynamics = stated.first("limit"), stated.first("dynamics")
    lower, upper = (None if kind == "continuous" else _bound(limit, end) for end in ("lower", "upper"))
    if lower is not None and upper is not None and lower > upper:
        raise limit.refuse(f"lower is {lower:g} and upper {upper:g}, expected lower <= upper")  # type: ignore[union-attr]
    for tag in ("damping", "friction", "spring_stiffness"):
        if number(dynamics, tag, 0.0) < 0:
            raise dynamics.refuse(f"<{tag}> is negative, expected 0 or more")  # type: ignore[union-attr]  # it says so
    effort, speed = (_bound(limit, tag) for tag in ("effort", "velocity"))
    return (
        Coordinate(
            name=joint.name,
            kind="prismatic" if kind == "prismatic" else "revolute",
            axis=axis,
            anchor=anchor,
            lower=lower,
            upper=upper,
            damping=number(dynamics, "damping", 0.0),
            friction_loss=number(dynamics, "friction", 0.0),
            stiffness=number(dynamics, "spring_stiffness", 0.0),
            rest=number(dynamics, "spring_reference", 0.0),
            effort=effort if effort is not None and effort > 0 else None,
            speed=speed if speed is not None and speed > 0 else None,
            tie=_tie(joint, stated),
            where=element.where,
        ),
    )


def _direction(joint: _Placed, axis: Element, X_MJ: Pose, version: str) -> Array:
    """The unit vector of an axis in the model. Raises: RobotError."""
    stated = axis.first("xyz")
    frame = "" if stated is None else stated.attributes.get("expressed_in", "")
    if version == "1.6" and flag(axis, "use_parent_model_frame"):
        frame = ITSELF
    direction = np.array(numbers(axis, "xyz", (3,)) or (0.0, 0.0, 1.0))
    if not 1e-9 < np.linalg.norm(direction) < math.inf:
        raise axis.refuse("<xyz> has no length, expected a direction")
    R = joint.scope.pose_of(frame, axis).R if frame else X_MJ.R
    along: Array = R @ direction / np.linalg.norm(direction)
    return along


def _bound(limit: Element | None, tag: str) -> float | None:
    value = None if limit is None else numbers(limit, tag, infinite=True)
    return None if value is None or abs(value[0]) >= _OPEN else value[0]


def _tie(joint: _Placed, axis: Element) -> Tie | None:
    """x = multiplier (y - reference) + offset. Raises: RobotError."""
    mimic = axis.first("mimic")
    if mimic is None:
        return None
    leader = mimic.attributes.get("joint", "")
    element = joint.scope.named.get(leader)
    if (
        element is None
        or element.tag != "joint"
        or element.attributes.get("type") not in ("revolute", "continuous", "prismatic")
    ):
        raise mimic.refuse(f"joint is {quoted(leader, 80)}, expected a joint of the model that turns or slides")
    ratio = number(mimic, "multiplier", 1.0)
    if ratio == 0 or leader == joint.element.attributes["name"]:
        raise mimic.refuse("follows nobody, expected a multiplier that is not 0 and another joint")
    offset = number(mimic, "offset", 0.0) - ratio * number(mimic, "reference", 0.0)
    return Tie(joint=joint.scope.prefix + leader, ratio=ratio, offset=offset)


def _solid(placed: _Placed, X_ML: Pose, collisions: Collisions, needs: list[Need]) -> Solid:
    """The mass of a link: 1 kg and 1 kg m2 about each axis where nothing is said. Raises: RobotError."""
    inertial, link = placed.element.first("inertial"), placed.name
    if inertial is None:
        collisions.unsaid.append(link)
        return Solid(1.0, np.zeros(3), np.eye(3))
    if inertial.first("fluid_added_mass") is not None:
        needs += Need.of("fluid", "fluid_added_mass", (link,))
    if inertial.attributes.get("auto", "").lower() in ("true", "1"):
        return collisions.filled(link, number(inertial, "density", 1000.0), inertial)
    mass = number(inertial, "mass", 1.0)
    if mass <= 0:
        raise inertial.refuse(f"<mass> is {mass:g}, expected a number above 0")
    stated = inertial.first("inertia")
    xx, yy, zz = (number(stated, tag, 1.0) for tag in ("ixx", "iyy", "izz"))
    xy, xz, yz = (number(stated, tag, 0.0) for tag in ("ixy", "ixz", "iyz"))
    X = X_ML.inverse() @ placed.scope.placed(inertial, placed.element.attributes["name"])
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Solid(mass, X.p, X.R @ tensor @ X.R.T)


def _needs(links: dict[str, _Placed]) -> list[Need]:
    """What changes the motion and has no word in a scene. Raises: RobotError."""
    lifted, braked = list[str](), list[str]()
    for name, placed in links.items():
        if flag(placed.element, "kinematic"):
            raise placed.element.refuse("is kinematic: nothing says how it moves, expected a link that forces move")
        if not flag(placed.element, "gravity", default=True):
            lifted.append(name)
        decay = placed.element.first("velocity_decay")
        if any(number(decay, tag, 0.0) for tag in ("linear", "angular")):
            braked.append(name)
    return Need.of("gravity_compensation", "link", lifted) + Need.of("fluid", "velocity_decay", braked)


def _rows(left: sdf_grammar.SdfLeft, others: list[str], links: dict[str, _Placed]) -> list[Fidelity]:
    rows = list[Fidelity]()
    for tag, owners in left.of_sdf.items():
        rows += Fidelity.left_out(tag, owners, sdf_grammar.why(tag))
    for label, owners in left.unknown.items():
        rows += Fidelity.left_out(label, owners, "no word of SDF, and near none that changes the motion")
    rows += Fidelity.told("other models", others)
    alone = [name for name, placed in links.items() if flag(placed.element, "self_collide")]
    rows += Fidelity.left_out("self_collide", alone, "the model says whether its links touch each other, and not one of them")
    return rows
