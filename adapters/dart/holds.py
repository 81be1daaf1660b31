"""What holds skeletons: the contacts, limits, dry joints and loops that bore in the last step, as rows of J v = 0."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from plumbline.adapters.dart.built import Built, Loop
from plumbline.adapters.dart.drives import AT_REST
from plumbline.adapters.dart.surfaces import SMALLEST_COEFFICIENT
from plumbline.adapters.dart.vendor import body_of
from plumbline.harness.trajectory import Floats

SLIDING = 0.999
"""From this share of its greatest friction on a contact slides rather than sticks."""
Spans = Mapping[int, slice]
"""Where the coordinates of each skeleton, by its number, stand among those of an island."""
NOBODY = -1
"""The number of the skeleton of what is static."""
_TURNED = np.cross(np.eye(3)[:, None], np.eye(3)[None]).transpose(1, 2, 0).reshape(3, 9)
"""Takes a lever r (3,) to the matrix (3, 3) of w x r, its rows one after the other."""


class Touch(NamedTuple):
    """Two shapes that touch: numbers of their skeletons, places of their bodies, the lesser friction, DART's contact."""

    numbers: tuple[int, int]
    bodies: tuple[int, int]
    grip: float
    contact: Any


class Bearing(NamedTuple):
    """What holds some skeletons, whose coordinates n stand one after the other.

    Terms:
        rows: of h holds three each (h, 3, n), J v = 0 while they hold, zero where a hold has fewer. pull: impulses (n,) beside.
        outward: (h, 3), the direction along which the impulse of a hold can only push, zero where it pulls too.
    """

    rows: Floats
    pull: Floats
    outward: Floats


class Holds:
    """All that can hold the skeletons of a world."""

    def __init__(self, built: Built) -> None:
        self._built = built
        numbers = {skeleton.getName(): k for k, skeleton in enumerate(built.skeletons)}
        self._number_of = [numbers.get(node.getSkeleton().getName(), NOBODY) for node in built.nodes]
        self._shapes: dict[Any, tuple[int, int, float]] = {}
        self._limits: list[tuple[int, Any]] = []
        self._dry: list[tuple[int, Any, float]] = []
        for k, skeleton in enumerate(built.skeletons):
            joints = [skeleton.getJoint(i) for i in range(skeleton.getNumJoints())]
            single = [j for j in joints if j.getNumDofs() == 1]
            self._limits += [(k, j) for j in single if j.areLimitsEnforced()]
            self._dry += [(k, j, float(j.getCoulombFriction(0))) for j in single if j.getCoulombFriction(0) > 0]

    def touches(self, begun: bool) -> list[Touch]:
        """What touched in the last step and is not static; before the first one, what touches now."""
        built = self._built
        result = built.world.getLastCollisionResult()
        if not begun:
            solver = built.world.getConstraintSolver()
            result = built.dart.collision.CollisionResult()
            solver.getCollisionGroup().collide(solver.getCollisionOption(), result)
        found = []
        for contact in result.getContacts():
            a, p, f = self._shape(contact.collisionObject1)
            b, q, g = self._shape(contact.collisionObject2)
            if a != NOBODY or b != NOBODY:
                found.append(Touch((a, b), (p, q), min(f, g), contact))
        return found

    def _shape(self, collision_object: Any) -> tuple[int, int, float]:
        """Skeleton, body and friction of a shape."""
        frame = collision_object.getShapeFrame()
        known = self._shapes.get(frame)
        if known is None:
            place, grip = body_of(collision_object), float(frame.getDynamicsAspect().getFrictionCoeff())
            known = self._shapes[frame] = self._number_of[place], place, grip
        return known

    def links(self, touches: Iterable[Touch]) -> set[tuple[int, int]]:
        """The pairs of skeletons that contacts or loops hold together."""
        pairs = {touch.numbers for touch in touches}
        pairs |= {(self._number_of[loop[0][0]], self._number_of[loop[-1][0]]) for loop in self._built.loops}
        return {(a, b) for a, b in pairs if a != b and NOBODY not in (a, b)}

    def bearing(self, spans: Spans, touches: Sequence[Touch], begun: bool) -> Bearing:
        """What held skeletons in the last step; before the first one, whatever touches them does."""
        near = [t for t in touches if t.numbers[0] in spans or t.numbers[1] in spans]
        loops = [loop for loop in self._built.loops if any(self._number_of[place] in spans for place, _ in loop)]
        pull = np.zeros(max(span.stop for span in spans.values()))
        bearing = self._contacts(near, spans, pull, begun)
        others = [self._loops(loops, spans, pull)] if loops else []
        if self._limits or self._dry:
            others.append(self._joints(spans, pull))
        for more in others:
            rows, outward = (np.concatenate(two) for two in zip(bearing[::2], more[::2], strict=True))
            bearing = Bearing(rows, pull, outward)
        return bearing

    def _contacts(self, near: Sequence[Touch], spans: Spans, pull: Floats, begun: bool) -> Bearing:
        """Contacts: of those that stick the point's velocities in W, of others that along the normal; these rub by `pull`."""
        told = np.array([(t.contact.force, t.contact.normal, t.contact.point) for t in near]).reshape(-1, 3, 3)
        squares = told[:, :2] @ told[:, :2].transpose(0, 2, 1)
        load, grip = squares[:, 0, 1], np.array([t.grip for t in near])
        slides = grip <= SMALLEST_COEFFICIENT
        if begun:
            slides |= squares[:, 0, 0] >= (1 + (SLIDING * grip) ** 2) * load**2
            if (load <= 0).any():
                bears = load > 0
                near = [t for t, bear in zip(near, bears, strict=True) if bear]
                told, load, slides = told[bears], load[bears], slides[bears]
        normal, point = told[:, 1], told[:, 2]
        rows = self._points([t.bodies for t in near], (point, point), spans, pull)
        if not slides.any():
            return Bearing(rows, pull, normal)
        rubs = self._built.world.getTimeStep() * (told[:, 0] - load[:, None] * normal) * slides[:, None]
        pull += np.einsum("ci,cin->n", rubs, rows)
        rows[slides, :1] = normal[slides, None] @ rows[slides]
        rows[slides, 1:] = 0.0
        return Bearing(rows, pull, np.where(slides[:, None], (1.0, 0.0, 0.0), normal))

    def _loops(self, loops: Sequence[Loop], spans: Spans, pull: Floats) -> Bearing:
        """The points that loops hold together."""
        points = np.zeros((2, len(loops), 3))
        for k, loop in enumerate(loops):
            for side, (place, point) in enumerate(loop):
                X_WB = self._built.nodes[place].getWorldTransform()
                points[side, k] = X_WB.translation() + X_WB.rotation() @ point
        bodies = [(loop[0][0], loop[1][0] if len(loop) > 1 else NOBODY) for loop in loops]
        return Bearing(self._points(bodies, (points[0], points[1]), spans, pull), pull, np.zeros((len(loops), 3)))

    def _points(self, bodies: Sequence[tuple[int, int]], points: tuple[Floats, Floats], spans: Spans, like: Floats) -> Floats:
        """The rows (h, 3, n) of the velocities in W of points [m] of first bodies against those of second ones."""
        rows = np.zeros((len(bodies), 3, len(like)))
        jacobians: dict[int, tuple[Floats, Floats]] = {}
        for side, sign in ((0, 1.0), (1, -1.0)):
            sides: dict[int, list[int]] = {}
            for k, pair in enumerate(bodies):
                if pair[side] != NOBODY and (number := self._number_of[pair[side]]) != NOBODY:
                    sides.setdefault(number, []).append(k)
            for number, holds in sides.items():
                places = [bodies[k][side] for k in holds]
                for place in places:
                    if place not in jacobians:
                        # A body's origin is its centre of mass.
                        node = self._built.nodes[place]
                        jacobians[place] = self._built.skeletons[number].getWorldJacobian(node), node.getCOM()
                motion, origin = (np.array([jacobians[place][part] for place in places]) for part in (0, 1))
                turned = ((points[side][holds] - origin) @ _TURNED).reshape(-1, 3, 3) @ motion[:, :3]
                rows[holds, :, spans[number]] += sign * (turned + motion[:, 3:])
        return rows

    def _joints(self, spans: Spans, pull: Floats) -> Bearing:
        """Limits, and joints that dry friction holds; where a joint moves it goes to `pull`."""
        held: list[tuple[int, float, float]] = []
        for number, joint in self._limits:
            if number in spans and (impulse := joint.getConstraintImpulse(0)) != 0:
                held.append((spans[number].start + joint.getIndexInSkeleton(0), math.copysign(1.0, impulse), 1.0))
        for number, joint, loss in self._dry:
            if number in spans:
                place, speed = spans[number].start + joint.getIndexInSkeleton(0), joint.getVelocity(0)
                if abs(speed) < AT_REST:
                    held.append((place, 1.0, 0.0))
                else:
                    pull[place] -= math.copysign(self._built.world.getTimeStep() * loss, speed)
        rows, outward = np.zeros((len(held), 3, len(pull))), np.zeros((len(held), 3))
        for k, (place, sign, one_way) in enumerate(held):
            rows[k, 0, place], outward[k, 0] = sign, one_way
        return Bearing(rows, pull, outward)


def islands(starts: Iterable[int], links: Collection[tuple[int, int]]) -> list[tuple[int, ...]]:
    """The groups of skeletons that links hold together, each with one of `starts`, in the order of numbers."""
    near: dict[int, set[int]] = {}
    for a, b in links:
        near.setdefault(a, set()).add(b)
        near.setdefault(b, set()).add(a)
    seen: set[int] = set()
    groups = []
    for start in starts:
        if start not in seen:
            group, waiting = {start}, [start]
            while waiting:
                fresh = near.get(waiting.pop(), set()) - group
                group |= fresh
                waiting += fresh
            seen |= group
            groups.append(tuple(sorted(group)))
    return groups
