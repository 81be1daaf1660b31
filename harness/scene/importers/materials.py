"""Contact laws per pair of materials, from what a file says of links and what its companion says of materials."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

from plumbline.harness.intake.refusal import listed
from plumbline.harness.scene import Surface
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.merging import Group
from plumbline.harness.scene.importers.robot import Robot
from plumbline.harness.scene.importers.settling import valid_name

ASSUMED_FRICTION = 0.8
"""Friction where neither the file nor its companion says one: dry rubber or wood on most floors."""


@dataclass(frozen=True, slots=True)
class Laws:
    """Terms: material: of each group, by lead; of each contact key of what is still. surfaces, apart: as a scene has them."""

    material: Mapping[str, str]
    still: Mapping[str, str]
    surfaces: tuple[Surface, ...]
    apart: tuple[tuple[str, str], ...]
    rows: tuple[Fidelity, ...]


def laws_of(robot: Robot, groups: Mapping[str, Group], companion: Companion) -> Laws:
    """The materials of all groups and the laws between them. Raises: RobotError."""
    owner = {link: lead for lead, group in groups.items() for link in group.members}
    excluded = {
        frozenset((owner[a], owner[b])) for a, b in (robot.contacts.excluded if robot.contacts else ()) if owner[a] != owner[b]
    }
    passing = "self_collision" in robot.dropped
    if passing:
        excluded = set()
    elif not robot.collide:
        # No joint of a scene is between a link and what it hangs on where several joints are: a body is between those.
        excluded |= {
            frozenset((lead, group.parent))
            for lead, group in groups.items()
            if group.parent is not None and len(group.lead.coordinates) > 1
        }
    alone = {lead for pair in excluded for lead in pair}
    keys: dict[str, frozenset[str]] = {}
    material: dict[str, str] = {}
    still: dict[str, str] = {}
    mixed = []
    for lead, group in groups.items():
        of_group = frozenset(geometry.contact for geometry in group.geometries)
        if group.still:
            for key in of_group:
                still[key] = key
                keys[key] = frozenset((key,))
            continue
        if not of_group:
            material[lead] = "robot"
            continue
        # Where links pass through each other, they are of no material that something still has.
        name = "+".join(sorted(of_group))[:120] + (":links" if passing else f":{lead}"[:79] if lead in alone else "")
        if len(of_group) > 1:
            mixed.append(lead)
        material[lead], keys[name] = name, of_group
    if companion.ground is not None:
        keys.setdefault(companion.ground.material, frozenset((companion.ground.material,)))
    valid_name((side for law in companion.surfaces for side in law.between), keys, "surface between", robot.source)
    holders = {name: lead for lead, name in material.items() if lead in alone}
    moving = frozenset(material.values()) if passing else frozenset()
    return _paired(robot, companion, keys, _Held(material, still, holders, excluded, moving), mixed)


@dataclass(frozen=True, slots=True)
class _Held:
    """Terms: holders: the group that a material of its own is of. excluded: pairs of groups that never touch.
    passing: materials none of which touches any of the others."""

    material: Mapping[str, str]
    still: Mapping[str, str]
    holders: Mapping[str, str]
    excluded: "set[frozenset[str]]"
    passing: frozenset[str]


def _paired(robot: Robot, companion: Companion, keys: Mapping[str, frozenset[str]], held: _Held, mixed: list[str]) -> Laws:
    stated = {law.pair: law for law in companion.surfaces}
    given = {law.pair: law for law in (robot.contacts.laws if robot.contacts else ())}
    surfaces, apart, assumed = [], [], []
    spread = 0.0
    ground = None if companion.ground is None else companion.ground.material
    for a, b in combinations_with_replacement(sorted(keys), 2):
        within = {a, b} <= held.passing
        if within or frozenset((held.holders.get(a, a), held.holders.get(b, b))) in held.excluded:
            apart.append((a, b))
            continue
        candidates = [law for x in keys[a] for y in keys[b] if (law := given.get(frozenset((x, y)))) is not None]
        if frozenset((a, b)) in stated:
            surfaces.append(stated[frozenset((a, b))])
        elif candidates:
            most = max(candidates, key=lambda law: law.kinetic_friction)
            spread = max(spread, most.kinetic_friction - min(law.kinetic_friction for law in candidates))
            surfaces.append(replace(most, between=(a, b)))
        elif ground in (a, b) or (robot.contacts is None and companion.self_collision):
            if a == b == ground:
                continue
            surfaces.append(Surface(between=(a, b), static_friction=ASSUMED_FRICTION, kinetic_friction=ASSUMED_FRICTION))
            assumed.append(f"{a}/{b}")
        else:
            apart.append((a, b))
    rows = _rows(robot, companion, assumed, mixed, spread)
    return Laws(held.material, held.still, tuple(surfaces), tuple(apart), tuple(rows))


def _rows(robot: Robot, companion: Companion, assumed: list[str], mixed: list[str], spread: float) -> list[Fidelity]:
    rows = []
    if assumed:
        rows += Fidelity.approximated(
            "friction",
            assumed,
            "static and kinetic friction assumed",
            consequence="neither the file nor its companion says one; [[surfaces]] says it",
            value=ASSUMED_FRICTION,
            unit="1",
        )
    if mixed:
        rows += Fidelity.approximated(
            "contact",
            mixed,
            "one material for each body, the one that touches most and rubs most",
            consequence="shapes of one body differ in what they touch or how they rub, in friction by up to",
            value=spread,
            unit="1",
        )
    if "self_collision" in robot.dropped and (robot.contacts is not None or companion.self_collision):
        rows.append(
            Fidelity(
                element="self-collision",
                name="",
                outcome="left_out",
                consequence="self collision was dropped by the user: the robot's links pass through each other",
            )
        )
    elif robot.contacts is None and not companion.self_collision and any(link.geometries for link in robot.links):
        rows.append(
            Fidelity(
                element="self-collision",
                name="",
                outcome="left_out",
                consequence="the robot's links pass through each other; self_collision = true lets them touch",
            )
        )
    return rows


def one_friction(surfaces: tuple[Surface, ...]) -> tuple[tuple[Surface, ...], list[Fidelity]]:
    """The laws with static friction at the kinetic one, and rows for those that change."""
    changed = [law for law in surfaces if law.static_friction > law.kinetic_friction]
    if not changed:
        return surfaces, []
    row = Fidelity(
        element="surface",
        name=listed(["/".join(law.between) for law in changed]),
        count=len(changed),
        outcome="approximated",
        becomes="one friction, the kinetic one",
        consequence="what stands slips at a smaller force; static friction over kinetic was up to",
        value=max(law.static_friction / law.kinetic_friction if law.kinetic_friction else float("inf") for law in changed),
        unit="1",
    )
    if row.value == float("inf"):
        row = replace(row, value=None, unit="")
    return tuple(replace(law, static_friction=law.kinetic_friction) for law in surfaces), [row]
