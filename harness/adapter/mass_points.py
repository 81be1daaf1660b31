"""Mass points: bodies without inertia, told to engines that take none as bodies whose motion is the same.

Where nothing turns a point, no inertia has anything to do: it is given that of a ball. Where fixed joints weld it to a body,
only the sum of both inertias counts, sum I_k + m_k (r_k^2 - r_k r_k^T): the point is given k 1, which looks the same from all
sides, and the body loses as much. Both are identities, no approximations.
Source: Goldstein, Classical Mechanics, 3rd ed., section 5.3 (the inertia of a rigid body is the sum of those of its parts).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from plumbline.harness.adapter.contract import Unsupported
from plumbline.harness.adapter.simulation import Simulation
from plumbline.harness.adapter.spanning_forest import DisjointSets
from plumbline.harness.adapter.what_goes_in import check_wrench
from plumbline.harness.scene import WORLD, Ball, Body, Distance, Fixed, Joint, Prismatic, Revolute, Scene, principal_inertia
from plumbline.harness.trajectory import Floats

POINTS_AS_BODIES = (
    "the engine has no word for a body without inertia; a point that nothing turns is told as a ball, one that is fixed to a "
    "body as a ball with a part of that body's inertia"
)
"""How adapters have mass points."""
SHARE = 0.1
"""Of what a body's largest principal moment lies below the sum of the others: what points welded to it take together."""
FLAT = 1e-6
"""Of the largest moment: below it a body is as good as flat, and has nothing to give."""
NEAR = 1e-9
"""Distance [m], per metre from the origin, within which an anchor lies at a point."""
RADIUS = 0.1
"""Of the ball whose inertia a point is given that nothing turns [m]."""


def built_with_points(build: Callable[[Scene], Simulation], scene: Scene) -> Simulation:
    """What an adapter builds of a scene, its mass points told as bodies. Raises: Unsupported."""
    told = with_inertia(scene)
    simulation = build(told)
    if told is scene:
        return simulation
    places = [place for place, body in enumerate(scene.bodies) if body.mass_point]
    return cast(Simulation, _Untwisted(simulation, len(scene.bodies), places))


def with_inertia(scene: Scene) -> Scene:
    """A scene that moves alike, without mass points; the same where there are none. Raises: Unsupported, of what no body is."""
    points = {body.name: body for body in scene.bodies if body.mass_point}
    if not points:
        return scene
    bodies = {body.name: body for body in scene.bodies}
    still = {body.name for body in scene.bodies if not body.movable} | {WORLD}
    welds = [joint for joint in scene.joints if isinstance(joint, Fixed)]
    sets = DisjointSets[str]()
    held: set[str] = set()
    for weld in welds:
        if weld.parent in still or weld.child in still:
            held.add(weld.child if weld.parent in still else weld.parent)
        else:
            sets.unite(weld.parent, weld.child)
    groups: dict[str, list[Body]] = {}
    for body in scene.bodies:
        if body.movable:
            groups.setdefault(sets.root(body.name), []).append(body)
    for group in groups.values():
        lone = [body for body in group if body.name in points]
        solid = [body for body in group if body.name not in points]
        if not lone:
            continue
        if solid:
            bodies |= {body.name: body for body in _shared(lone, solid)}
            continue
        if spun := next((body for body in lone if any(body.w_WB)), None):
            raise Unsupported(
                f"mass point '{spun.name}' with w_WB {spun.w_WB}", "it has nothing that could turn; expected zero"
            )
        if not any(body.name in held for body in group):
            if len(lone) > 1:
                named = ", ".join(f"'{body.name}'" for body in lone)
                raise Unsupported(f"mass points {named} fixed together", "about their own line nothing says how they turn")
            for joint in scene.joints:
                _check_untwisted(lone[0], joint, bodies)
        bodies |= {body.name: _ball(body) for body in lone}
    return replace(scene, bodies=tuple(bodies[body.name] for body in scene.bodies))


def _ball(point: Body) -> Body:
    moment = 0.4 * point.mass * RADIUS**2
    return replace(point, inertia=principal_inertia(moment, moment, moment))


def _shared(lone: Sequence[Body], solid: Sequence[Body]) -> list[Body]:
    """The points and the roundest of the bodies that they are fixed to, which gives them a share of its inertia."""
    room = {body.name: _room(body) for body in solid}
    giver = max(solid, key=lambda body: room[body.name])
    if room[giver.name] <= FLAT * float(np.linalg.eigvalsh(np.array(giver.inertia))[-1]):
        raise Unsupported(
            f"mass point '{lone[0].name}' fixed to '{giver.name}'",
            "that is flat, so that no part of its inertia can stand for the point's; state both as one body",
        )
    share = SHARE * room[giver.name] / len(lone)
    left = np.array(giver.inertia) - SHARE * room[giver.name] * np.eye(3)
    return [replace(giver, inertia=left.tolist()), *(replace(p, inertia=principal_inertia(share, share, share)) for p in lone)]


def _room(body: Body) -> float:
    """By how much the largest principal moment lies below the sum of the other two [kg m2]."""
    a, b, c = np.linalg.eigvalsh(np.array(body.inertia))
    return float(a + b - c)


def _check_untwisted(point: Body, joint: Joint, bodies: dict[str, Body]) -> None:
    """Raises: Unsupported, where a joint could turn a point that is fixed to nothing."""
    if point.name not in (joint.parent, joint.child):
        return
    what = f"joint '{joint.name}' on mass point '{point.name}'"
    mend = "a small ball's inertia, 2/5 m r^2, says it"
    match joint:
        case Ball(anchor_W=anchor):
            apart = _apart(anchor, point)
        case Distance():
            apart = _apart(joint.anchor_W if joint.parent == point.name else joint.child_anchor_W, point)
        case Prismatic():
            other = bodies.get(joint.parent if joint.child == point.name else joint.child)
            if other is not None and (other.movable or any(other.w_WB)):
                raise Unsupported(
                    what, f"the slide turns with '{other.name}', and no engine turns a body without inertia; {mend}"
                )
            apart = False
        case Revolute():
            offset = np.cross(joint.axis_W, np.subtract(point.p_WB, joint.anchor_W))
            through = float(np.linalg.norm(offset)) <= NEAR * (1.0 + float(np.linalg.norm(point.p_WB)))
            if through:
                raise Unsupported(
                    what, f"its axis goes through the point, whose angle has no inertia: no law says how it turns; {mend}"
                )
            raise Unsupported(what, f"no engine turns a body without inertia on a hinge; {mend}")
        case _:
            apart = False
    if apart:
        raise Unsupported(what, f"its anchor is not at the point, and no engine turns a body without inertia; {mend}")


def _apart(anchor: Sequence[float], point: Body) -> bool:
    return float(np.linalg.norm(np.subtract(anchor, point.p_WB))) > NEAR * (1.0 + float(np.linalg.norm(point.p_WB)))


class _Untwisted:
    """A simulation in which some bodies are mass points: a torque has nothing to turn there."""

    def __init__(self, inner: Simulation, bodies: int, places: list[int]) -> None:
        self._inner, self._bodies, self._places = inner, bodies, places

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside. Raises: ValueError, of a torque on a mass point."""
        check_wrench(self._bodies, f_B_W, tau_B_W)
        if np.any(tau_B_W[self._places]):
            place = next(place for place in self._places if np.any(tau_B_W[place]))
            raise ValueError(f"wrench: tau_B_W: got {tau_B_W[place].tolist()} N m on body {place}, a mass point; expected none")
        self._inner.wrench(f_B_W, tau_B_W)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)
