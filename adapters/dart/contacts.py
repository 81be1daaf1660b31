"""The contacts of a world: as DART reports them, and those of sleeping bodies as they were last seen."""

import math
from dataclasses import fields
from typing import Any

import numpy as np

from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.vendor import body_of
from plumbline.harness.scene import Plane, rotation_matrix
from plumbline.harness.scene.shape import support
from plumbline.harness.trajectory import Contacts, Floats

MOST_CONTACTS = 1000
"""CollisionOption::maxNumContacts; dartpy hands out a copy of the option, so that it cannot be raised.

Beyond it the touching pairs share the budget, each keeping its deepest contact (ConstraintSolver.cpp).
"""
SLOW = 0.1
"""Below this [rad/s and m/s] a body may be put to sleep; the vendor's thresholds are 0.05 and 0.01."""
REMEMBERED_EVERY = 0.1
"""How often [s] the contacts of slow bodies are kept; a body falls asleep after 0.5 s of rest."""
FIRST_STEPS = 4
"""What rests from the start sleeps from the second step on, so that its contacts must be caught at once."""
STILL = 1e-3
"""A body that has moved less [m] since its contacts were last seen still rests on them."""


def reported(built: Built) -> Contacts:
    """What DART reports of the last step."""
    bodies: dict[Any, int] = {}
    rows: list[tuple[int, int, Floats, Floats, float, Floats]] = []
    for contact in built.world.getLastCollisionResult().getContacts():
        # Normal and force belong to the first object, whichever body a detector puts there.
        b, a = (
            bodies[touching] if touching in bodies else bodies.setdefault(touching, body_of(touching))
            for touching in (contact.collisionObject1, contact.collisionObject2)
        )
        if built.scene.bodies[a].movable or built.scene.bodies[b].movable:
            rows.append((a, b, contact.point, contact.normal, -contact.penetrationDepth, contact.force))
    if not rows:
        return Contacts.none()
    a_, b_, _, normal, gap, force = zip(*rows, strict=True)
    ends: dict[tuple[int, int, bytes], Ends] = {}
    middle = [_half_way(built, ends, *row[:5]) for row in rows]
    return Contacts.of(a_, b_, np.array(middle), np.array(normal), np.array(gap), np.array(force))


Ends = tuple[float | None, float | None]
"""Where the first body of a pair ends along its normal, and where the second begins, from the origin of W [m]."""


def _half_way(
    built: Built, ends: dict[tuple[int, int, bytes], Ends], a: int, b: int, point: Floats, normal: Floats, gap: float
) -> Floats:
    """The point between both surfaces [m], of one that a detector may tell on either.

    ODE's detector tells the corner of a box or the lowest point of a ball on a plane, and the middle of two balls; FCL's and
    DART's own differ pair by pair. Where a body ends along the normal its surface is, if it is convex: the point is taken to be
    on the surface that it is next to, and stays as it is if it is next to none.

    Args: ends: those known of this step, by pair and normal. a, b: bodies, the normal from a to b. gap [m]: below 0 in
    penetration.
    """
    height, pair = float(normal @ point), (a, b, normal.tobytes())
    if pair not in ends:
        far = _end(built, b, -normal)
        ends[pair] = _end(built, a, normal), None if far is None else -far
    for end, inwards in zip(ends[pair], (gap / 2, -gap / 2), strict=True):
        if end is not None and min(abs(height - end), abs(height - (end + 2 * inwards))) < abs(gap) / 8:
            return np.asarray(point + (end + inwards - height) * normal)
    return point


def _end(built: Built, body: int, normal: Floats) -> float | None:
    """How far a body reaches along a direction of W, from the origin of W [m]; None where it has no end there."""
    transform = built.nodes[body].getWorldTransform()
    along_B = transform.rotation().T @ normal
    ends = []
    for placed in built.scene.bodies[body].collision:
        R_BS = rotation_matrix(placed.q_BS)
        own = np.array(R_BS).T @ along_B
        if isinstance(placed.shape, Plane):
            if own @ np.array(placed.shape.normal) < 1.0 - 1e-9:
                return None
            reach = 0.0
        else:
            reach = float(support(placed.shape, own))
        ends.append(along_B @ np.array(placed.p_BS) + reach)
    return float(normal @ transform.translation() + max(ends)) if ends else None


class LastSeen:
    """The contacts of slow bodies, kept before they fall asleep, after which DART reports them no more."""

    def __init__(self, built: Built) -> None:
        self._built = built
        self._time, self._contacts = -math.inf, Contacts.none()
        self._places = np.array([body.p_WB for body in built.scene.bodies])

    def look(self, steps: int) -> None:
        """Keep what is reported now, after so many steps, with the bodies' places; not at every look."""
        now = self._built.world.getTime()
        if steps <= FIRST_STEPS or now - self._time >= REMEMBERED_EVERY:
            contacts = reported(self._built)
            if len(contacts):
                self._time, self._contacts, self._places = now, contacts, _places(self._built)

    def beside(self, now: Contacts) -> Contacts:
        """The contacts of now, with those kept of bodies that report none and rest where they were."""
        seen = self._contacts
        if not len(seen):
            return now
        awake = set(zip(now.body_A.tolist(), now.body_B.tolist(), strict=True))
        still = np.linalg.norm(_places(self._built) - self._places, axis=1) < STILL
        keep = [still[a] and still[b] and (a, b) not in awake for a, b in zip(seen.body_A, seen.body_B, strict=True)]
        names = [f.name for f in fields(Contacts)]
        return Contacts(*(np.concatenate((getattr(now, n), getattr(seen, n)[keep])) for n in names))


def _places(built: Built) -> Floats:
    """p_WB of every body, (n, 3) m."""
    return np.array([node.getWorldTransform().translation() for node in built.nodes])
