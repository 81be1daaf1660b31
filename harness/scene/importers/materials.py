"""Contact laws per pair of materials, from what a file says of links and what its companion says of materials."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

from plumbline.harness.scene import Surface
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.merging import Group
from plumbline.harness.scene.importers.robot import ContactRules, Robot
from plumbline.harness.scene.importers.settling import valid_name

ASSUMED_FRICTION = 0.8
"""Friction where neither the file nor its companion says one: dry rubber or wood on most floors."""


@dataclass(frozen=True, slots=True)
class Laws:
    """Terms: material: of each group, by lead; of each contact key of what is still, by lead and key. surfaces, apart: as a
    scene has them."""

    material: Mapping[str, str]
    still: Mapping[tuple[str, str], str]
    surfaces: tuple[Surface, ...]
    apart: tuple[tuple[str, str], ...]
    rows: tuple[Fidelity, ...]


@dataclass(frozen=True, slots=True)
class _Materials:
    """Terms: keys: of each material, the contact keys of its shapes. lead: the group that a material of its own is of. passing:
    materials none of which touches any of the others."""

    keys: Mapping[str, frozenset[str]]
    lead: Mapping[str, str]
    passing: frozenset[str]


def laws_of(robot: Robot, groups: Mapping[str, Group], companion: Companion) -> Laws:
    """The materials of all groups and the laws between them. Raises: RobotError."""
    passing = robot.dropped.takes("self_collision")
    neighbours = set[frozenset[str]]()
    if not robot.collide and not passing:
        # No joint of a scene is between a link and what it hangs on where several joints are: a body is between those.
        neighbours = {
            frozenset((lead, group.parent))
            for lead, group in groups.items()
            if group.parent is not None and len(group.lead.coordinates) > 1
        }
    alone = {lead for pair in neighbours for lead in pair}
    named = {link for pair in (robot.contacts.excluded if robot.contacts else ()) for link in pair}
    keys: dict[str, frozenset[str]] = {}
    material: dict[str, str] = {}
    still: dict[tuple[str, str], str] = {}
    own: dict[str, str] = {}
    mixed = []
    for lead, group in groups.items():
        of_group = frozenset(geometry.contact for geometry in group.geometries)
        parted = lead in alone and lead not in named and (robot.filter_world or not group.still)
        suffix = ":links" if passing and not group.still else f":{lead}"[:79] if parted else ""
        if group.still:
            for key in of_group:
                name = still[lead, key] = key + suffix
                keys[name] = frozenset((key,))
                if robot.filter_world and lead in alone:
                    own[name] = lead
            continue
        if not of_group:
            material[lead] = "robot"
            continue
        # Where links pass through each other, they are of no material that something still has.
        name = "+".join(sorted(of_group))[:120] + suffix
        if len(of_group) > 1:
            mixed.append(lead)
        material[lead], keys[name] = name, of_group
        if lead in alone:
            own[name] = lead
    if companion.ground is not None:
        keys.setdefault(companion.ground.material, frozenset((companion.ground.material,)))
    valid_name((side for law in companion.surfaces for side in law.between), keys, "surface between", robot.source)
    moving = frozenset(material.values()) if passing else frozenset()
    surfaces, apart, rows = _paired(robot, companion, _Materials(keys, own, moving), neighbours, mixed)
    rows += _disabled(robot, groups, frozenset(law.pair for law in surfaces), material, still)
    return Laws(material, still, surfaces, apart, tuple(rows))


def _paired(
    robot: Robot, companion: Companion, materials: _Materials, neighbours: "set[frozenset[str]]", mixed: list[str]
) -> tuple[tuple[Surface, ...], tuple[tuple[str, str], ...], list[Fidelity]]:
    contacts = robot.contacts or ContactRules()
    stated = {law.pair: law for law in companion.surfaces}
    given = {law.pair: law for law in contacts.laws}
    base, excluded = _bases(robot, contacts)
    surfaces, apart, assumed = [], [], []
    spread = 0.0
    ground = None if companion.ground is None else companion.ground.material

    def parted(x: str, y: str) -> bool:
        pair = frozenset((base.get(x, x), base.get(y, y)))
        return frozenset((x, y)) in excluded and pair not in contacts.paired

    keys, lead = materials.keys, materials.lead
    for a, b in combinations_with_replacement(sorted(keys), 2):
        met = [(x, y) for x in keys[a] for y in keys[b] if not parted(x, y)]
        if {a, b} <= materials.passing or not met or frozenset((lead.get(a, a), lead.get(b, b))) in neighbours:
            apart.append((a, b))
            continue
        pairs = (frozenset((base.get(x, x), base.get(y, y))) for x, y in met)
        candidates = [law for pair in pairs if (law := given.get(pair)) is not None]
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
    return tuple(surfaces), tuple(apart), _rows(robot, companion, assumed, mixed, spread)


def _bases(robot: Robot, contacts: ContactRules) -> tuple[dict[str, str], "set[frozenset[str]]"]:
    """The file's key of each key that a link has of its own, and the pairs of keys of links that never touch."""
    base: dict[str, str] = {}
    of_link: dict[str, set[str]] = {}
    for link in robot.links:
        for geometry in link.geometries:
            key = contacts.key(link.name, geometry.contact)
            if key != geometry.contact:
                base[key] = geometry.contact
                of_link.setdefault(link.name, set()).add(key)
    excluded = {
        frozenset((x, y)) for a, b in contacts.excluded for x in of_link.get(a, ()) for y in of_link.get(b, ()) if a != b
    }
    return base, excluded


def _disabled(
    robot: Robot,
    groups: Mapping[str, Group],
    touching: frozenset[frozenset[str]],
    material: Mapping[str, str],
    still: Mapping[tuple[str, str], str],
) -> list[Fidelity]:
    """Rows for pairs that the file keeps apart, or lets touch, by name."""
    contacts, rows = robot.contacts or ContactRules(), list[Fidelity]()
    owner = {link: lead for lead, group in groups.items() for link in group.members}
    shapes = {link.name: link.geometries for link in robot.links}

    def sides(link: str) -> set[str]:
        lead = owner[link]
        if not groups[lead].still:
            return {material[lead]} if shapes[link] else set()
        return {still[lead, contacts.key(link, geometry.contact)] for geometry in shapes[link]}

    def meet(a: str, b: str) -> bool:
        return any(frozenset((x, y)) in touching for x in sides(a) for y in sides(b))

    pairs = [(a, b) for a, b in contacts.excluded if shapes[a] and shapes[b]]
    lost = [f"{a}/{b}" for a, b in pairs if owner[a] != owner[b] and meet(a, b)]
    rows += Fidelity.exact("exclude", [f"{a}/{b}" for a, b in pairs if f"{a}/{b}" not in lost], "a pair that never touches")
    rows += Fidelity.told("exclude", lost)
    if robot.collide:
        return rows
    joined = [
        f"{group.parent}/{lead}"
        for lead, group in groups.items()
        if group.parent is not None
        and group.geometries
        and groups[group.parent].geometries
        and (robot.filter_world or not groups[group.parent].still)
    ]
    rows += Fidelity.exact("neighbours", joined, "pairs that a joint keeps from touching")
    by_key = {geometry.contact: owner[link.name] for link in robot.links for geometry in link.geometries}
    ends = [sorted(by_key[key] for key in pair if key in by_key) for pair in contacts.paired]
    unmet = ["/".join(pair) for pair in ends if len(pair) == 2 and {"/".join(pair), "/".join(pair[::-1])} & set(joined)]
    rows += Fidelity.left_out("pair", unmet, "the file lets these neighbours touch by name; a scene's joint keeps them apart")
    return rows


def _rows(robot: Robot, companion: Companion, assumed: list[str], mixed: list[str], spread: float) -> list[Fidelity]:
    rows = []
    if assumed:
        rows += Fidelity.told("friction assumed", assumed, ASSUMED_FRICTION)
    if mixed:
        rows += Fidelity.told("contact of several materials", mixed, spread)
    if robot.dropped.takes("self_collision") and (robot.contacts is not None or companion.self_collision):
        rows += Fidelity.told("self-collision dropped", "")
    elif robot.contacts is None and not companion.self_collision and any(link.geometries for link in robot.links):
        rows += Fidelity.told("self-collision off", "")
    return rows


def one_friction(surfaces: tuple[Surface, ...]) -> tuple[tuple[Surface, ...], list[Fidelity]]:
    """The laws with static friction at the kinetic one, and rows for those that change."""
    changed = [law for law in surfaces if law.static_friction > law.kinetic_friction]
    if not changed:
        return surfaces, []
    slips = all(law.kinetic_friction for law in changed)
    rows = Fidelity.told(
        "static friction",
        ["/".join(law.between) for law in changed],
        max(law.static_friction / law.kinetic_friction for law in changed) if slips else None,
        unit="1" if slips else "",
    )
    return tuple(replace(law, static_friction=law.kinetic_friction) for law in surfaces), rows
