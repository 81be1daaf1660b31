"""Which trees the joints of a world make, and whether it is solved in their coordinates, as its options choose.

Trees say who hangs on whom, from the roots on, and what closes loops; or why joints make none. Where joints close loops, joint
coordinates are taken if they are asked for by name alone. Where bodies may touch they are taken unless most bodies are loose:
those have nothing of a tree, and a sweep over both costs more than over bodies alone. Coupled joints, tendons and bodies
without mass leave no choice: a row of bodies' own coordinates is between two bodies, both with mass.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbline.engine.build.couplings import leaders_of
from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.joints import Ball, Distance, Joint, Prismatic, Revolute, Tendon
from plumbline.engine.maths.arrays import dot, eigenvalues
from plumbline.engine.options import ADAPTIVE, JOINT, MAXIMAL, Options

THINNEST = 1e-12
"""Of m l^2, the least moment of inertia of a body whose centre swings at l about a ball joint. Coordinates of a tree know the
moment about its own arm as what is left of sums of m l^2: round-off of a torque m g l turns it by 2e-4 g / l then."""


@dataclass(frozen=True, slots=True)
class Tie:
    """The link whose coordinate another one's follows, itself free, and their ratio."""

    leader: int
    ratio: float


@dataclass(frozen=True, slots=True)
class Link:
    """A body of a tree, by its number, and what it hangs on.

    Terms: parent, root: links, parent -1 for a root. joint: its number, -1 for a root that nothing holds. base: the body that a
    root is held to, the number of bodies standing for the world. against: whether the joint's own parent is this link.
    """

    body: int
    parent: int
    root: int
    joint: int
    base: int
    against: bool
    tie: Tie | None = None


@dataclass(frozen=True, slots=True)
class Forest:
    """The links of all trees, parents before children and tree by tree, and the bodies that forces or nobody moves alone.

    Terms: closing: the joints that close loops of these trees, by their numbers. tendons: each with its arms by link.
    """

    links: tuple[Link, ...]
    others: tuple[int, ...]
    closing: tuple[int, ...] = ()
    tendons: tuple[tuple[Tendon, Mapping[int, float]], ...] = ()


@dataclass(frozen=True, slots=True)
class NoForest:
    """Why joints make no trees: which part of the world, and what of it."""

    what: str
    why: str


def forest_of(bodies: Sequence[Body], joints: Sequence[Joint]) -> Forest | NoForest:
    """The trees of the joints, whose ends are bodies or the world, checked before.

    A tree hangs on what no force moves where a joint holds it there, else its root is free: the first body that is no joint's
    child, if there is one.
    """
    movable = {body.name: i for i, body in enumerate(bodies) if body.motion == "dynamic"}
    number = {body.name: i for i, body in enumerate(bodies)}
    # The distance of two anchors is no coordinate of a tree: it closes a loop, or stands for a spring.
    ends = [
        (-1, -1) if isinstance(joint, Distance) else (movable.get(joint.parent, -1), movable.get(joint.child, -1))
        for joint in joints
    ]
    on: dict[int, list[int]] = {i: [] for i in movable.values()}
    for j, i in ((j, i) for j, pair in enumerate(ends) for i in pair if i >= 0):
        on[i].append(j)
    children = {b for a, b in ends if a >= 0 and b >= 0}
    links: list[Link] = []
    where: dict[int, int] = {}
    used: set[int] = set()

    def plant(body: int, joint: int, base: int) -> None:
        """Add a tree: its root, held to a base by a joint or free, and all that hangs on it."""
        waiting = [(body, -1, joint)]
        while waiting:
            outer, parent, j = waiting.pop()
            if outer in where:
                continue
            used.add(j)
            k = where[outer] = len(links)
            against = j >= 0 and number.get(joints[j].parent) == outer
            links.append(Link(outer, parent, links[parent].root if parent >= 0 else k, j, base if parent < 0 else -1, against))
            for j in reversed(on[outer]):
                other = sum(ends[j]) - outer
                if j not in used and other >= 0:
                    waiting.append((other, k, j))

    for j, (a, b) in enumerate(ends):
        if (a < 0) != (b < 0) and max(a, b) not in where:
            plant(max(a, b), j, number.get(joints[j].parent if a < 0 else joints[j].child, len(bodies)))
    for i in sorted((i for i in on if on[i]), key=lambda i: i in children):
        if i not in where:
            plant(i, -1, -1)
    closing = tuple(j for j in range(len(joints)) if j not in used)
    if closing and not links:
        return NoForest(f"joint '{joints[closing[0]].name}'", "the distance of two anchors is no coordinate of a tree")
    for j in closing:
        law = law_of(joints[j])
        if law:
            return NoForest(
                f"joint '{joints[j].name}'", f"it closes a loop with {law}, and laws act along coordinates of trees"
            )
    for link in links:
        body, hook = bodies[link.body], joints[link.joint] if link.joint >= 0 else None
        if isinstance(hook, Ball):
            arm = np.asarray(hook.anchor_W, float) - np.asarray(body.p_WB, float)
            least, needed = eigenvalues(np.asarray(body.inertia, float))[0], THINNEST * body.mass * float(dot(arm, arm))
            if least < needed:
                return NoForest(
                    f"body '{body.name}'",
                    f"its least moment of inertia is {least:.3g} kg m2, and what ball joint '{hook.name}' leaves of it in "
                    f"coordinates of a tree is known to {needed:.3g}",
                )
    link_of = {joints[link.joint].name: k for k, link in enumerate(links) if link.joint >= 0}
    for name, (leader, ratio) in leaders_of(joints).items():
        for end in (name, leader):
            if end not in link_of:
                return NoForest(f"joint '{end}'", "it closes a loop, and couplings tie coordinates of trees")
        links[link_of[name]] = replace(links[link_of[name]], tie=Tie(link_of[leader], ratio))
    carrying = {link.parent for link in links}
    for i, body in enumerate(bodies):
        if not body.massless:
            continue
        if i not in where or links[where[i]].joint < 0 or where[i] not in carrying or _closes(body, closing, joints):
            return NoForest(f"body '{body.name}'", "it has no mass, and stands between no two joints of a tree")
    others = tuple(i for i, body in enumerate(bodies) if i not in where and body.motion != "static")
    return Forest(tuple(links), others, closing)


def with_tendons(forest: Forest, joints: Sequence[Joint], tendons: Sequence[Tendon]) -> Forest | NoForest:
    """The forest with tendons over its coordinates. Raises: ValueError for an arm on a joint without one, or of no name."""
    scalar = {joint.name for joint in joints if isinstance(joint, Revolute | Prismatic)}
    link_of = {joints[link.joint].name: k for k, link in enumerate(forest.links) if link.joint >= 0}
    for tendon in tendons:
        for name in tendon.arms:
            if name not in scalar:
                raise ValueError(f"tendon '{tendon.name}': '{name}' is no joint with one coordinate")
            if name not in link_of:
                return NoForest(f"joint '{name}'", "it closes a loop, and tendons pull at coordinates of trees")
    arms = ({link_of[name]: arm for name, arm in tendon.arms.items()} for tendon in tendons)
    return replace(forest, tendons=tuple(zip(tendons, arms, strict=True)))


def _closes(body: Body, closing: Sequence[int], joints: Sequence[Joint]) -> bool:
    """Whether a joint that closes a loop ends at a body."""
    return any(body.name in (joints[j].parent, joints[j].child) for j in closing)


def law_of(joint: Joint) -> str:
    """What acts along the coordinate of a joint; empty where nothing does."""
    for field, what in (("limits", "limits"), ("spring", "a spring"), ("drive", "a drive")):
        if getattr(joint, field, None) is not None:
            return what
    if getattr(joint, "armature", 0.0) > 0 or getattr(joint, "friction_loss", 0.0) > 0:
        return "a rotor" if getattr(joint, "armature", 0.0) > 0 else "dry friction"
    return "a limit of speed" if getattr(joint, "speed_limit", math.inf) < math.inf else ""


INTEGRATORS = ("semi_implicit_euler", "rk4", "implicit_midpoint", ADAPTIVE)
"""Those that know joint coordinates."""


def chosen_forest(
    bodies: Sequence[Body], joints: Sequence[Joint], options: Options, touching: bool, tendons: Sequence[Tendon] = ()
) -> Forest | None:
    """The trees that a world is solved as; None where its bodies keep their own coordinates, as all do without joints.

    Args: touching: whether two bodies may touch.
    Raises: NotSupported where joint coordinates are asked for, and nothing else will do.
    """
    wanted = [f"coupled joint '{joint.name}'" for joint in joints if getattr(joint, "coupling", None) is not None]
    wanted += [f"body '{body.name}' without mass" for body in bodies if body.massless]
    wanted += [f"tendon '{tendon.name}'" for tendon in tendons]
    if not wanted and (not joints or options.used_coordinates == MAXIMAL):
        return None
    if wanted and options.coordinates == MAXIMAL:
        raise NotSupported(f"{wanted[0]} with bodies' own coordinates", "a row of theirs is between two bodies, both with mass")
    forest = forest_of(bodies, joints)
    if tendons and isinstance(forest, Forest):
        forest = with_tendons(forest, joints, tendons)
    if options.coordinates != JOINT and not wanted and isinstance(forest, Forest):
        loose = sum(bodies[i].motion == "dynamic" for i in forest.others)
        if forest.closing or (touching and loose > len(forest.links)):
            return None
    if options.integrator not in INTEGRATORS:
        forest = NoForest(f"the integrator '{options.integrator}'", f"they know {', '.join(INTEGRATORS)}")
    elif tendons and options.integrator != "semi_implicit_euler":
        forest = NoForest(f"the integrator '{options.integrator}'", "semi_implicit_euler alone knows tendons")
    elif isinstance(forest, Forest) and (touching or forest.closing):
        forest = unknown(options, "contacts" if touching else f"joint '{joints[forest.closing[0]].name}'") or forest
    if isinstance(forest, Forest):
        return forest
    if wanted:
        raise NotSupported(f"{wanted[0]} with {forest.what}", forest.why)
    if options.coordinates == JOINT:
        raise NotSupported(f"joint coordinates with {forest.what}", forest.why)
    return None


def unknown(options: Options, what: str) -> NoForest | None:
    """Why contacts, or loops, have no joint coordinates under these options; None where they have."""
    if options.integrator != "semi_implicit_euler":
        return NoForest(
            f"{what} under the integrator '{options.integrator}'", "semi_implicit_euler alone knows contacts and loops"
        )
    if options.solver != "tgs_soft":
        return NoForest(f"{what} under the solver '{options.solver}'", "the solver 'tgs_soft' alone knows trees")
    if options.continuous == "swept":
        return NoForest(f"{what} and swept collision", "a step in parts is known to bodies with coordinates of their own")
    if options.sleeping:
        return NoForest(f"{what} and sleep", "islands are known to bodies with coordinates of their own")
    return None
