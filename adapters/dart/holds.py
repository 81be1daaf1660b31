"""What holds skeletons: the contacts, limits, dry joints and loops that bore in the last step, as rows of J v = 0."""

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adapters.dart.built import Built
from adapters.dart.drives import AT_REST
from adapters.dart.surfaces import SMALLEST_COEFFICIENT
from adapters.dart.vendor import body_of
from harness.trajectory import Floats
from harness.trajectory.kinematics import cross

__all__ = ["Bearing", "Flags", "Holds", "Touch", "islands"]

Flags = NDArray[np.bool_]
SLIDING = 0.999
"""From this share of its greatest friction on a contact slides rather than sticks."""
NOBODY = -1
"""The number of the skeleton of what is static."""
_X_AND_Y = np.eye(2, 3)
_EVERY_WAY = np.eye(4, 3)


@dataclass(frozen=True, slots=True)
class Touch:
    """Two shapes that touch: the numbers of their skeletons, the places of their bodies, the lesser friction, DART's contact."""

    numbers: tuple[int, int]
    bodies: tuple[int, int]
    grip: float
    contact: Any


@dataclass(frozen=True, slots=True)
class Bearing:
    """What holds some skeletons, by their numbers: of h holds three rows each (3 h, n) of a Jacobian, J v = 0 while they hold,
    zero where a hold has fewer; and what else they exert, impulses (n,).

    Terms: both_ways: (h,), does a hold pull as well as push? Else its first row pushes.
    """

    rows: dict[int, Floats]
    pull: dict[int, Floats]
    both_ways: Flags


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
        if frame not in self._shapes:
            place, grip = body_of(collision_object), float(frame.getDynamicsAspect().getFrictionCoeff())
            self._shapes[frame] = self._number_of[place], place, grip
        return self._shapes[frame]

    def links(self, touches: Iterable[Touch]) -> set[tuple[int, int]]:
        """The pairs of skeletons that contacts or loops hold together."""
        pairs = {touch.numbers for touch in touches}
        pairs |= {(self._number_of[loop[0][0]], self._number_of[loop[-1][0]]) for loop in self._built.loops}
        return {(a, b) for a, b in pairs if a != b and NOBODY not in (a, b)}

    def bearing(self, skeletons: Collection[int], touches: Sequence[Touch], begun: bool) -> Bearing:
        """What held these skeletons in the last step; before the first one, whatever touches them does."""
        near = [t for t in touches if t.numbers[0] in skeletons or t.numbers[1] in skeletons]
        loops = [loop for loop in self._built.loops if any(self._number_of[place] in skeletons for place, _ in loop)]
        along, places, points = self._contacts(near, begun)
        contacts = len(along)
        if loops:
            along = np.concatenate((along, np.tile(_EVERY_WAY, (len(loops), 1, 1))))
            places += [(loop[0][0], loop[1][0] if len(loop) > 1 else NOBODY) for loop in loops]
            points = np.concatenate((points, self._held_points(loops)))
        moved = self._moved(skeletons, along, places, points)
        rows = {number: some[:, :3].reshape(3 * len(along), some.shape[2]) for number, some in moved.items()}
        pull = {number: some[:, 3].sum(axis=0) for number, some in moved.items()}
        return self._with_joints(Bearing(rows, pull, np.arange(len(along)) >= contacts))

    def _contacts(self, near: Sequence[Touch], begun: bool) -> tuple[Floats, list[tuple[int, int]], Floats]:
        """Of the contacts that bear: directions (c, 4, 3), bodies, and where these are held (c, 2, 3) [m].

        The directions are the normal and two across it, of zero length where the contact slides; the fourth is the impulse by
        which it rubs then.
        """
        told = np.array([(t.contact.force, t.contact.normal, t.contact.point) for t in near]).reshape(-1, 3, 3)
        force, normal = told[:, 0], told[:, 1]
        load, grip = (force * normal).sum(axis=1), np.array([t.grip for t in near])
        if begun and not (bears := load > 0).all():
            near = [t for t, bear in zip(near, bears, strict=True) if bear]
            told, force, normal, load, grip = (some[bears] for some in (told, force, normal, load, grip))
        along = np.empty((len(near), 4, 3))
        along[:, 0] = normal
        # Householder's reflection that takes the normal to +-z takes x and y across it.
        side = np.copysign(1.0, normal[:, 2])
        mirror = normal.copy()
        mirror[:, 2] += side
        along[:, 1:3] = _X_AND_Y - mirror[:, :2, None] * (mirror / (side * mirror[:, 2])[:, None])[:, None]
        across = force - load[:, None] * normal
        slides = grip <= SMALLEST_COEFFICIENT
        if begun:
            slides = slides | ((across * across).sum(axis=1) >= (SLIDING * grip * load) ** 2)
        along[:, 3] = self._built.world.getTimeStep() * slides[:, None] * across
        along[slides, 1:3] = 0.0
        return along, [t.bodies for t in near], told[:, [2, 2]]

    def _held_points(self, loops: Sequence[tuple[tuple[int, Floats], ...]]) -> Floats:
        """Where the points that loops hold together are now (l, 2, 3) [m]; of the world's any place."""
        points = np.zeros((len(loops), 2, 3))
        for k, loop in enumerate(loops):
            for side, (place, point) in enumerate(loop):
                X_WB = self._built.nodes[place].getWorldTransform()
                points[k, side] = X_WB.translation() + X_WB.rotation() @ point
        return points

    def _moved(
        self, skeletons: Collection[int], along: Floats, places: Sequence[tuple[int, int]], points: Floats
    ) -> dict[int, Floats]:
        """For each skeleton the rows (h, 4, n) that give the velocities of holds along their directions, of the first body
        against the second."""
        built = self._built
        moved = {k: np.zeros((len(along), 4, built.skeletons[k].getNumDofs())) for k in skeletons}
        jacobians: dict[int, tuple[Floats, Floats]] = {}
        for side, sign in ((0, 1.0), (1, -1.0)):
            of_skeleton: dict[int, list[int]] = {}
            for k, pair in enumerate(places):
                if pair[side] != NOBODY and (number := self._number_of[pair[side]]) != NOBODY:
                    of_skeleton.setdefault(number, []).append(k)
            for number, held in of_skeleton.items():
                skeleton, bodies = built.skeletons[number], [places[k][side] for k in held]
                for place in bodies:
                    if place not in jacobians:
                        node = built.nodes[place]
                        # A body's origin is its centre of mass.
                        jacobians[place] = skeleton.getWorldJacobian(node), node.getCOM()
                lever = points[held, side] - np.array([jacobians[place][1] for place in bodies])
                turned = np.empty((len(held), 4, 6))
                turned[..., 3:] = sign * along[held]
                turned[..., :3] = cross(lever[:, None], turned[..., 3:])
                moved[number][held] += turned @ np.array([jacobians[place][0] for place in bodies])
        return moved

    def _with_joints(self, bearing: Bearing) -> Bearing:
        """The same with the limits and the dry friction of joints."""
        held: list[tuple[int, int, float]] = []
        for number, joint in self._limits:
            if number in bearing.rows and (impulse := joint.getConstraintImpulse(0)) != 0:
                held.append((number, joint.getIndexInSkeleton(0), math.copysign(1.0, impulse)))
        stops = len(held)
        for number, joint, loss in self._dry:
            if number in bearing.rows:
                place, speed = joint.getIndexInSkeleton(0), joint.getVelocity(0)
                if abs(speed) < AT_REST:
                    held.append((number, place, 1.0))
                else:
                    bearing.pull[number][place] -= math.copysign(self._built.world.getTimeStep() * loss, speed)
        if not held:
            return bearing
        extra = {number: np.zeros((3 * len(held), rows.shape[1])) for number, rows in bearing.rows.items()}
        for k, (number, place, sign) in enumerate(held):
            extra[number][3 * k, place] = sign
        rows = {number: np.concatenate((some, extra[number])) for number, some in bearing.rows.items()}
        return Bearing(rows, bearing.pull, np.append(bearing.both_ways, np.arange(len(held)) >= stops))


def islands(starts: Iterable[int], links: Collection[tuple[int, int]]) -> list[list[int]]:
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
            groups.append(sorted(group))
    return groups
