"""Stable PD control: springs and drives as torques of the velocity that is foreseen for the end of the step."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from adapters.dart.built import Built
from adapters.dart.drives import AT_REST, Motor
from adapters.dart.surfaces import SMALLEST_COEFFICIENT
from adapters.dart.vectors import tangents
from adapters.dart.vendor import body_of
from harness.trajectory import Floats, Integers

__all__ = ["Foresight"]

SLIDING = 0.999
"""From this share of its greatest friction on a contact slides rather than sticks."""
SHARED = 1e-10
"""Of the mean mobility: what makes redundant contacts share a load, too little to give way."""


@dataclass(slots=True)
class Hold:
    """What holds skeletons: for each of them, by its place, the rows (r, n) of its Jacobian; J v = 0 while it holds.

    Terms:
        one_sided: does the first row push only? pull: what else it is known to exert, impulses (n,) on each skeleton.
    """

    rows: dict[int, Floats]
    one_sided: bool = False
    pull: dict[int, Floats] = field(default_factory=dict)


class Foresight:
    """Whose drives are to be foreseen, and by what they can be held."""

    def __init__(self, built: Built) -> None:
        self._built = built
        self._driven: dict[int, dict[str, Motor]] = {}
        self._limits: list[tuple[int, Any]] = []
        self._dry: list[tuple[int, Any, float]] = []
        self._loose: list[Integers] = []
        numbers = {skeleton.getName(): k for k, skeleton in enumerate(built.skeletons)}
        self._skeleton_of: list[int | None] = [numbers.get(node.getSkeleton().getName()) for node in built.nodes]
        for name, motor in built.motors.items():
            self._driven.setdefault(numbers[motor.skeleton.getName()], {})[name] = motor
        for k, skeleton in enumerate(built.skeletons):
            joints = [skeleton.getJoint(i) for i in range(skeleton.getNumJoints())]
            held = built.dart.dynamics.ActuatorType.VELOCITY
            loose = [j.getIndexInSkeleton(i) for j in joints if j.getActuatorType() != held for i in range(j.getNumDofs())]
            self._loose.append(np.array(loose, dtype=np.int64))
            single = [j for j in joints if j.getNumDofs() == 1]
            self._dry += [(k, j, float(j.getCoulombFriction(0))) for j in single if j.getCoulombFriction(0) > 0]
            self._limits += [(k, j) for j in joints if j.getNumDofs() == 1 and j.areLimitsEnforced()]

    def foresee(self, begun: bool) -> None:
        """Springs and drives as torques of the velocity v' that is foreseen for the end of the step (stable PD control).

        M (v' - u) = dt f(v') + J^T p and J v' = 0: u is what the step brings without springs and drives, f are their forces
        where v' leads, J the contacts, limits and loops that bore in the last step. DART finds p itself, under these torques.

        Args:
            begun: is the first batch of steps over? In it whatever touches bears.

        Source: J. Tan, K. Liu, G. Turk, Stable Proportional-Derivative Controllers, IEEE CG&A 31(4), 2011.
        """
        built = self._built
        dt = built.world.getTimeStep()
        holds = self._holds(dt, begun)
        reached, waiting = set[int](), list(self._driven)
        while waiting:
            if (number := waiting.pop()) not in reached:
                reached.add(number)
                waiting += [other for hold in holds if number in hold.rows for other in hold.rows]
        first, size, u = {}, 0, list[Floats]()
        for number in sorted(reached):
            skeleton = built.skeletons[number]
            skeleton.computeForwardDynamics()
            first[number] = size
            u.append(np.asarray(skeleton.getVelocities()) + dt * np.asarray(skeleton.getAccelerations()))
            size += len(u[-1])
        ahead = np.concatenate(u)
        bearing = [hold for hold in holds if reached.issuperset(hold.rows)]
        masses = {number: np.array(built.skeletons[number].getMassMatrix()) for number in reached}
        saturated: dict[str, float] = {}
        while True:
            mobility, push = np.zeros((size, size)), np.zeros(size)
            for number, mass in masses.items():
                gain = np.zeros(len(mass))
                for name, motor in self._driven.get(number, {}).items():
                    k = motor.joint.getIndexInSkeleton(0)
                    gain[k] = motor.inertia(dt, name in saturated)
                    spring, drive = motor.forces(ahead[first[number] + k], dt)
                    push[first[number] + k] = dt * (spring + saturated.get(name, drive))
                loose = self._loose[number]
                mobility[np.ix_(first[number] + loose, first[number] + loose)] = np.linalg.inv(
                    (mass + np.diag(gain))[np.ix_(loose, loose)]
                )
            end = _held(ahead, mobility, push, bearing, first)
            exceeded = False
            for number, motors in self._driven.items():
                for name, motor in motors.items():
                    spring, drive = motor.forces(end[first[number] + motor.joint.getIndexInSkeleton(0)], dt)
                    cut = saturated.get(name, motor.cut(drive))
                    motor.joint.setCommand(0, spring + cut)
                    if name not in saturated and cut != drive:
                        saturated[name], exceeded = cut, True
            if not exceeded:
                return

    def _holds(self, dt: float, begun: bool) -> list[Hold]:
        """The contacts, limits and loops that bore in the last step; before the first one, whatever touches."""
        built = self._built
        result = built.world.getLastCollisionResult()
        if not begun:
            solver = built.world.getConstraintSolver()
            result = built.dart.collision.CollisionResult()
            solver.getCollisionGroup().collide(solver.getCollisionOption(), result)
        jacobians: dict[int, Floats] = {}
        places: dict[int, Floats] = {}

        def of_point(place: int, point: Floats, along: Floats) -> tuple[int, Floats] | None:
            """Skeleton and rows of the velocities [m/s] of a point along directions (r, 3)."""
            number = self._skeleton_of[place]
            if number is None:
                return None
            node = built.nodes[place]
            if place not in jacobians:
                jacobians[place] = np.asarray(built.skeletons[number].getWorldJacobian(node))
                places[place] = np.asarray(node.getWorldTransform().translation())
            turn, way = jacobians[place][:3], jacobians[place][3:]
            return number, along @ way + np.cross(point - places[place], along) @ turn

        holds = []
        for contact in result.getContacts():
            force, normal = np.asarray(contact.force), np.asarray(contact.normal)
            load = float(force @ normal)
            if begun and load <= 0:
                continue
            objects = contact.collisionObject1, contact.collisionObject2
            grip = min(o.getShapeFrame().getDynamicsAspect().getFrictionCoeff() for o in objects)
            across = force - load * normal
            slides = grip <= SMALLEST_COEFFICIENT or (begun and math.hypot(*across) >= SLIDING * grip * load)
            along = normal[None] if slides else np.vstack((normal, tangents(normal)))
            hold = Hold({}, one_sided=True)
            for sign, object_ in zip((1.0, -1.0), objects, strict=True):
                motion = of_point(body_of(object_), np.asarray(contact.point), np.vstack((along, across)))
                if motion is not None:
                    number, rows = motion
                    hold.rows[number] = hold.rows.get(number, 0.0) + sign * rows[:-1]
                    hold.pull[number] = hold.pull.get(number, 0.0) + sign * dt * rows[-1] * bool(slides)
            holds.append(hold)
        for number, joint in self._limits:
            impulse = joint.getConstraintImpulse(0)
            if impulse != 0:
                row = np.zeros((1, built.skeletons[number].getNumDofs()))
                row[0, joint.getIndexInSkeleton(0)] = math.copysign(1.0, impulse)
                holds.append(Hold({number: row}, one_sided=True))
        for number, joint, loss in self._dry:
            row = np.zeros((1, built.skeletons[number].getNumDofs()))
            row[0, joint.getIndexInSkeleton(0)] = 1.0
            speed = float(joint.getVelocity(0))
            if abs(speed) < AT_REST:
                holds.append(Hold({number: row}))
            else:
                holds.append(Hold({number: row[:0]}, pull={number: -math.copysign(dt * loss, speed) * row[0]}))
        for loop in built.loops:
            hold = Hold({})
            for sign, (place, point) in zip((1.0, -1.0), loop, strict=False):
                X_WB = built.nodes[place].getWorldTransform()
                motion = of_point(place, X_WB.translation() + X_WB.rotation() @ point, np.eye(3))
                if motion is not None:
                    number, rows = motion
                    hold.rows[number] = hold.rows.get(number, 0.0) + sign * rows
            holds.append(hold)
        return [hold for hold in holds if hold.rows]


def _held(ahead: Floats, mobility: Floats, push: Floats, holds: list[Hold], first: Mapping[int, int]) -> Floats:
    """Velocities (n,) after the impulses `push` and those by which holds bear; a one-sided hold that would pull lets go.

    Terms:
        ahead: velocities (n,) without impulses. mobility (n, n). first: the place of each skeleton's first coordinate.
    """
    push = push.copy()
    for hold in holds:
        for number, impulse in hold.pull.items():
            push[first[number] : first[number] + len(impulse)] += impulse
    free: Floats = ahead + mobility @ push
    while holds:
        starts = np.cumsum([0, *(len(next(iter(hold.rows.values()))) for hold in holds)])
        jacobian = np.zeros((starts[-1], len(ahead)))
        for hold, start in zip(holds, starts, strict=False):
            for number, rows in hold.rows.items():
                jacobian[start : start + len(rows), first[number] : first[number] + rows.shape[1]] = rows
        given = jacobian @ mobility @ jacobian.T
        given[np.diag_indices_from(given)] += SHARED * np.trace(given) / len(given) + np.finfo(np.float64).tiny
        p = np.linalg.solve(given, -jacobian @ free)
        kept = [hold for hold, start in zip(holds, starts, strict=False) if not (hold.one_sided and p[start] < 0)]
        if len(kept) == len(holds):
            return free + mobility @ jacobian.T @ p
        holds = kept
    return free
