"""What fixed joints hold together, as one: groups of links with one mass, one tensor and all their shapes.

What stands between two joints: a link of the file without mass, or a share of the mass of a link that has several joints.

A scene has one joint between two bodies. Where the axes of all later joints of a link meet in a
point, that point is fixed in the link and in what stands before it, so that a part of the link's mass which lies there moves
alike whether it belongs to the one or the other: nothing changes but by the moment of inertia that a body has to have.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.scene.importers.kinematics import Line
from plumbline.harness.scene.importers.poses import IDENTITY, Array, Pose
from plumbline.harness.scene.importers.robot import ContactRules, Coordinate, Geometry, Link, Robot, Solid
from plumbline.harness.scene.importers.solids import moved, together


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Links that do not move against each other.

    Terms:
        lead: the link that the others hang on; its frame G is the group's. parent: the lead of the group above, None for the
        world. still: is it fixed to the world? solid: all mass, in G; None without any. geometries, drawn: each with its pose
        in G and the contact key of its own link.
        members: pose in G of each link.
    """

    lead: Link
    parent: str | None
    still: bool
    solid: Solid | None
    geometries: tuple[Geometry, ...]
    drawn: tuple[Geometry, ...]
    members: dict[str, Pose]


def grouped(robot: Robot) -> dict[str, Group]:
    """The groups by the name of their lead, parents before children. What is fixed to the world has one each root."""
    leads: dict[str, Link] = {}
    owner: dict[str, str] = {}
    members: dict[str, dict[str, Pose]] = {}
    above: dict[str, str | None] = {}
    links = {link.name: link for link in robot.links}
    for link in robot.links:
        if link.coordinates or link.parent is None:
            leads[link.name] = link
            owner[link.name] = link.name
            members[link.name] = {link.name: IDENTITY}
            above[link.name] = None if link.parent is None else owner[link.parent]
        else:
            lead = owner[link.parent]
            owner[link.name] = lead
            members[lead][link.name] = members[lead][link.parent] @ link.X_PL
    made: dict[str, Group] = {}
    contacts = robot.contacts or ContactRules()
    for name, lead_link in leads.items():
        poses = members[name]
        solids = [moved(solid, X) for member, X in poses.items() if (solid := links[member].solid) is not None]
        shapes, drawn = (
            tuple(
                Geometry(geometry.shape, X @ geometry.X_LG, contacts.key(member, geometry.contact))
                for member, X in poses.items()
                for geometry in getattr(links[member], kind)
            )
            for kind in ("geometries", "drawn")
        )
        still = not lead_link.coordinates
        made[name] = Group(lead_link, above[name], still, together(solids) if solids else None, shapes, drawn, poses)
    return made


def check_masses(groups: Mapping[str, Group]) -> None:
    """Refuse a tensor that moves and has no mass. Raises: RobotError."""
    for group in groups.values():
        if group.solid is not None and not group.still and group.solid.mass <= 0:
            where = group.lead.where
            raise RobotError(f"{where}: <inertial> has mass 0 and an inertia that is not 0, expected a mass above 0")


def check_inertia(group: Group, tensor: Array) -> None:
    """Refuse a tensor that no body has, once all that is fixed together is merged; a mass point that flies or slides has none.

    Raises: RobotError.
    """
    a, b, c = (float(moment) for moment in np.linalg.eigvalsh((tensor + tensor.T) / 2))
    if a > 0 and a + b >= c * (1 - 1e-9):
        return
    several = len(group.members) > 1
    links = f"link{'s' * several} {listed(list(group.members))}{', fixed together, have' if several else ' has'}"
    if not tensor.any() and group.lead.coordinates and {c.kind for c in group.lead.coordinates} <= {"free", "prismatic"}:
        return
    if a <= 0:
        raise RobotError(
            f"{group.lead.where}: {links} principal moments ({a:.6g}, {b:.6g}, {c:.6g}) kg m2, expected all above 0"
        )
    raise RobotError(
        f"{group.lead.where}: {links} principal moments ({a:.6g}, {b:.6g}, {c:.6g}) kg m2, of which the largest "
        "exceeds the sum of the others; no body has such a tensor (triangle inequality)"
    )


SHARE = 0.01
"""Of the link's mass that all that stands before it takes together; a tenth of that, again and again, where the rest would have
a tensor that no body has."""
LEAST = 1e-5
MOMENT = 1e-4
"""Of the link's least principal moment of inertia that each gets: what it adds is smaller than what engines agree to."""
MEETS = 1e-9
"""How far from an axis a point may be that lies on it [m]: rounding of numbers of a metre."""


@dataclass(frozen=True, slots=True, eq=False)
class StandIns:
    """Terms: centres (k, 3) m in W, of one behind each joint but the last; mass [kg], moment [kg m2] of each; rest: what the
    link keeps, in its frame."""

    centres: Array
    mass: float
    moment: float
    rest: Solid


def stand_ins(lines: Sequence[Line], solid: Solid | None, X: Pose) -> StandIns | None:
    """What stands between these joints of a link with this mass at the pose X; None where nothing can without changing more."""
    if solid is None or solid.inertia is None or any(line.coordinate.kind not in ("revolute", "ball") for line in lines[1:]):
        return None
    centres = [_meeting(lines[k + 1 :]) for k in range(len(lines) - 1)]
    points = [centre for centre in centres if centre is not None]
    least = float(np.linalg.eigvalsh(solid.inertia)[0])
    if len(points) < len(centres) or least <= 0:
        return None
    share = SHARE
    while share >= LEAST:
        mass = share * solid.mass / len(points)
        rest = _without(solid, mass, [X.R.T @ (point - X.p) for point in points])
        assert rest.inertia is not None
        a, b, c = np.linalg.eigvalsh(rest.inertia)
        if a > 0 and a + b >= c:
            return StandIns(np.array(points), mass, MOMENT * least, rest)
        share /= 10
    return None


def _meeting(lines: Sequence[Line]) -> Array | None:
    """The point in W [m] in which the axes of all these joints meet, nearest to the first one's anchor; None without one."""
    normal, offset, anchor = np.zeros((3, 3)), np.zeros(3), lines[0].anchor_W
    for line in lines:
        # A ball has no axis: its point alone.
        across = np.eye(3) if line.coordinate.kind == "ball" else np.eye(3) - np.outer(line.axis_W, line.axis_W)
        normal += across
        offset += across @ (line.anchor_W - anchor)
    point: Array = anchor + np.linalg.lstsq(normal, offset, rcond=1e-9)[0]
    for line in lines:
        away = point - line.anchor_W
        if line.coordinate.kind == "revolute":
            away = away - line.axis_W * (line.axis_W @ away)
        if np.linalg.norm(away) > MEETS:
            return None
    return point


def _without(solid: Solid, mass: float, points: Sequence[Array]) -> Solid:
    """The solid without so much mass at each of these points of its frame."""
    assert solid.inertia is not None
    left = solid.mass - mass * len(points)
    centre = (solid.mass * solid.centre - mass * np.sum(points, axis=0)) / left
    tensor = solid.inertia + solid.mass * _of_point(solid.centre - centre)
    for point in points:
        tensor = tensor - mass * _of_point(point - centre)
    return Solid(left, centre, tensor)


def _of_point(r: Array) -> Array:
    """The inertia of 1 kg at a place r [m]."""
    tensor: Array = float(r @ r) * np.eye(3) - np.outer(r, r)
    return tensor


def between_joints(groups: Mapping[str, Group]) -> frozenset[str]:
    """The leads of groups without mass and shapes that hang on joints with one coordinate each and carry one such group."""
    single = {
        lead for lead, group in groups.items() if group.lead.coordinates and all(map(_turns_or_slides, group.lead.coordinates))
    }
    carried = Counter(group.parent for group in groups.values())
    carries = {group.parent for lead, group in groups.items() if lead in single}
    return frozenset(
        lead
        for lead in single & carries
        if carried[lead] == 1 and groups[lead].solid is None and not groups[lead].geometries and not groups[lead].drawn
    )


def _turns_or_slides(c: Coordinate) -> bool:
    return c.kind in ("revolute", "prismatic")
