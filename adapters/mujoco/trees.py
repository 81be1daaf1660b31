"""The forest of joints: below which body each one hangs by a native joint, and which joints close loops."""

from collections.abc import Container, Sequence
from dataclasses import dataclass

from plumbline.harness.adapter.carried_laws import carried, followed
from plumbline.harness.adapter.spanning_forest import spanning_forest
from plumbline.harness.scene import WORLD, Distance, Fixed, Joint, Prismatic, Revolute, Scene


@dataclass(frozen=True, slots=True)
class Link:
    """How a body hangs in the forest: below body `above` (-1: the world) by `joint`, `turned` if the scene's child is above."""

    body: int
    above: int
    joint: Joint | None
    turned: bool = False


def _keenness(joint: Joint, others: Container[str]) -> int:
    """The lower, the sooner a joint becomes native: what has no equality constraint first, the exact ones last."""
    if isinstance(joint, Prismatic):
        return 0
    if isinstance(joint, Revolute):
        return 1 if carried(joint) or joint.name in others else 2
    return 3 if isinstance(joint, Fixed) else 4


def forest(scene: Scene, joints: Sequence[Joint]) -> tuple[list[Link], list[Joint]]:
    """Links from the roots down, and the joints that close loops."""
    index = {body.name: k for k, body in enumerate(scene.bodies)} | {WORLD: -1}
    still = [k for k, body in enumerate(scene.bodies) if not body.movable]
    others = followed(scene)
    trees = spanning_forest(
        sorted((j for j in joints if not isinstance(j, Distance)), key=lambda joint: _keenness(joint, others)),
        lambda joint: (index[joint.parent], index[joint.child]),
        ground=(-1, *still),
    )
    links = [Link(k, -1, None) for k in still]
    reached = set(still)

    def grow(root: int) -> None:
        reached.add(root)
        for branch in trees.breadth_first(root):
            reached.add(branch.node)
            links.append(Link(branch.node, branch.above, branch.edge, index[branch.edge.child] == branch.above))

    for root in (-1, *still):
        grow(root)
    # A body without mass stands in no tree of its own; what hangs on it reaches it.
    for k in sorted(range(len(scene.bodies)), key=lambda place: scene.bodies[place].massless):
        if k not in reached:
            links.append(Link(k, -1, None))
            grow(k)
    return links, list(trees.closing)


def in_one_body(scene: Scene, links: Sequence[Link]) -> dict[int, tuple[Link, ...]]:
    """By each body with mass the links whose native joints are its own, in their order: all behind the last body with mass."""
    by_body = {link.body: link for link in links}
    found = {}
    for link in links:
        if scene.bodies[link.body].massless:
            continue
        chain = [link]
        while chain[0].above >= 0 and scene.bodies[chain[0].above].massless:
            chain.insert(0, by_body[chain[0].above])
        found[link.body] = tuple(chain)
    return found
