"""What fixed joints hold together, as one: groups of links with one mass, one tensor and all their shapes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.scene.importers.poses import IDENTITY, Array, Pose
from plumbline.harness.scene.importers.robot import ContactRules, Geometry, Link, Robot, Solid
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
