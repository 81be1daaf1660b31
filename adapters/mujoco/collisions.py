"""What can touch what, and by which law: geoms with masks and priorities, excluded pairs of bodies, explicit pairs of geoms."""

from collections.abc import Mapping, Sequence

from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.shapes import BOTH_GROUP, COLLISION_GROUP, VISUAL_GROUP, add_geom
from plumbline.adapters.mujoco.surfaces import Law, ranked, tell_surface
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Effect, Scene


def add_shapes(plan: Plan, draft: Draft, laws: Mapping[frozenset[str], Law]) -> None:
    """Geoms with their surfaces; whose pair's law no priority gives, an explicit pair does. Raises: Unsupported."""
    bodies = plan.scene.bodies
    materials = sorted({b.material for b in bodies if b.collision})
    by_priority, left = ranked(laws, materials)
    masks = _masks(plan.scene, materials)
    for link in plan.links:
        body = bodies[link.body]
        for number, placed in enumerate(body.collision):
            geom = add_geom(plan, draft, link.body, placed, f"g{link.body}.{number}")
            geom.group = BOTH_GROUP if body.visual is None else COLLISION_GROUP
            if Effect.CONTACT in plan.effects:
                geom.contype, geom.conaffinity = masks[body.material]
                if body.material in by_priority:
                    geom.priority, law = by_priority[body.material]
                    tell_surface(geom, law)
                    geom.friction = law.friction
        for number, placed in enumerate(body.visual or ()):
            geom = add_geom(plan, draft, link.body, placed, f"v{link.body}.{number}", drawn=True)
            geom.contype, geom.conaffinity, geom.group = 0, 0, VISUAL_GROUP
    if Effect.CONTACT in plan.effects:
        _exclude(plan, draft)
        _add_pairs(plan, draft, laws, left)


def _masks(scene: Scene, materials: Sequence[str]) -> dict[str, tuple[int, int]]:
    """contype and conaffinity: a bit for each material that stands apart from some other, one bit for all others."""
    apart = [frozenset(pair) for pair in scene.apart]
    lonely = [m for m in materials if any(m in pair for pair in apart)]
    if len(lonely) > 31:
        raise Unsupported(f"{len(lonely)} materials apart from others", "MuJoCo's collision masks have 32 bits")
    bit = {m: 2 << lonely.index(m) if m in lonely else 1 for m in materials}
    met = {m: sum({bit[o] for o in materials if frozenset((m, o)) not in apart}) for m in materials}
    return {m: (_signed(bit[m]), _signed(met[m])) for m in materials}


def _signed(mask: int) -> int:
    """32 bits as the integer of 32 bits that has them, the last of which is its sign."""
    return mask - (mask >> 31 << 32)


def _exclude(plan: Plan, draft: Draft) -> None:
    """Keep bodies apart that joints hold, and those that move as they are told from those that stand still."""
    bodies = plan.scene.bodies
    node = {b.name: "world" if plan.planted(b) else f"b{k}" for k, b in enumerate(bodies) if not b.massless}
    still = [b.name for b in bodies if not b.movable and b.collision]
    moving = [b.name for b in bodies if plan.prescribed(b) and b.collision]
    pairs = {frozenset((node[a], node[b])) for a in still for b in moving if a != b}
    pairs |= {frozenset(node[name] for name in pair) for pair in plan.scene.joined() if pair <= node.keys()}
    for a, b in sorted(tuple(sorted(pair)) for pair in pairs):
        draft.spec.add_exclude(bodyname1=a, bodyname2=b)


def _add_pairs(plan: Plan, draft: Draft, laws: Mapping[frozenset[str], Law], left: Sequence[str]) -> None:
    """Each two shapes, of bodies of the materials `left`, that can touch, with a law of their own."""
    scene = plan.scene
    bodies = [(k, b) for k, b in enumerate(scene.bodies) if b.material in left and b.collision]
    for earlier, (i, a) in enumerate(bodies):
        for j, b in bodies[earlier + 1 :]:
            law = laws.get(frozenset((a.material, b.material)))
            if law is None or not scene.collides(a, b):
                continue
            for x in range(len(a.collision)):
                for y in range(len(b.collision)):
                    pair = draft.spec.add_pair(geomname1=f"g{i}.{x}", geomname2=f"g{j}.{y}")
                    tell_surface(pair, law)
                    if law.solref_friction is not None:
                        pair.solreffriction = law.solref_friction
                    slide, torsion, roll = law.friction
                    pair.friction = [slide, slide, torsion, roll, roll]
