"""How the joints of a multibody answer to efforts, at its present pose and on the points that it stands on."""

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.adapters.bullet.frames import matrices
from plumbline.adapters.bullet.trees import Tree, joint_axis
from plumbline.adapters.bullet.vendor import Port
from plumbline.harness.adapter.rotations import conjugate
from plumbline.harness.scene import Ball, Fixed, Prismatic, Quaternion, Scene, Vector3, multiply, rotate
from plumbline.harness.trajectory import Floats

TOUCHING = 1e-6
"""The gap [m] within which a foot stands at the start: scenes are built touching to rounding."""
SINGULAR = 1e-4
"""The share of the greatest below which a direction of contacts counts as held by the others already.

Standing machines have shares of 1e-3 and above, and what points say twice has 1e-16; four wheels of which one says what the
other three do have some 1e-5 as the machine turns, which is a lever of a tenth of a millimetre and holds nothing.
"""


@dataclass(frozen=True, slots=True)
class Held:
    """A point of a multibody that what stands still holds. Terms: link: -1 for the base; rows (k, 3): directions, in W."""

    link: int
    point_W: Vector3
    rows: Floats


@dataclass(frozen=True, slots=True)
class Footing:
    """What a multibody may stand on. Terms: friction: (link, Bullet's number of what stands still) to their coefficient."""

    friction: Mapping[tuple[int, int], float]

    def held(self, port: Port, number: int, start: bool) -> list[Held]:
        """The points that bore a force in the last step, or that touch at the start; one that slips is held across alone."""
        if not self.friction:
            return []
        if start:
            port.call("performCollisionDetection")
        holds: list[Held] = []
        for c in port.call("getContactPoints", bodyA=number):
            link, point, other = (c[3], c[5], c[2]) if c[1] == number else (c[4], c[6], c[1])
            friction = self.friction.get((link, other))
            if friction is None or (c[8] > TOUCHING if start else c[9] <= 0.0):
                continue
            sticks = friction > 0.0 and (start or math.hypot(c[10], c[12]) < 0.999 * friction * c[9])
            holds.append(Held(link, point, np.eye(3) if sticks else np.array([c[7]])))
        return holds


@dataclass(frozen=True, slots=True)
class Skeleton:
    """The masses and joints of one multibody, from which the mobility of its joints follows at any pose.

    Terms:
        free: has it a dynamic base, which then is body 0? mass (b,) kg, moments (b, 3) kg m2 about the principal axes, of its b
        bodies. moved (d,), axis (d, 3), turns (d,): of each of its d joint coordinates the body that it moves against its
        parent, the axis in that body's link frame, and whether it turns about it. carries (b, d): does the coordinate move the
        body? acted (a,): which coordinates springs and drives act on.
    """

    free: bool
    mass: Floats
    moments: Floats
    moved: np.ndarray[Any, np.dtype[np.int64]]
    axis: Floats
    turns: np.ndarray[Any, np.dtype[np.bool_]]
    carries: np.ndarray[Any, np.dtype[np.bool_]]
    acted: np.ndarray[Any, np.dtype[np.int64]]

    @classmethod
    def of(cls, tree: Tree, scene: Scene, principal: Sequence[tuple[Vector3, Quaternion]], acted: Container[int]) -> "Skeleton":
        """The skeleton of a tree of which springs and drives act on some links."""
        free = tree.base is not None and scene.bodies[tree.base].movable
        first = int(free)
        places = [tree.base] * first + [link.place for link in tree.links]
        coordinates: list[tuple[int, Vector3, bool, bool]] = []
        above: list[set[int]] = [set()] * first
        for k, link in enumerate(tree.links):
            carried = set() if link.parent < 0 else set(above[link.parent + first])
            back = conjugate(multiply(scene.bodies[link.place].q_WB, principal[link.place][1]))
            axes: Sequence[Vector3] = (rotate(back, joint_axis(link.joint, scene.bodies[link.place].name)),)
            if isinstance(link.joint, Ball):
                axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
            for axis in () if isinstance(link.joint, Fixed) else axes:
                carried.add(len(coordinates))
                coordinates.append((k + first, axis, not isinstance(link.joint, Prismatic), k in acted))
            above.append(carried)
        return cls(
            free,
            np.array([scene.bodies[place].mass for place in places if place is not None]),
            np.array([principal[place][0] for place in places if place is not None]),
            np.array([c[0] for c in coordinates]),
            np.array([c[1] for c in coordinates]),
            np.array([c[2] for c in coordinates]),
            np.array([[j in carried for j in range(len(coordinates))] for carried in above]),
            np.flatnonzero([c[3] for c in coordinates]),
        )

    def response(
        self, port: Port, number: int, gravity: Vector3, held: Sequence[Held] = (), age: float = 0.0
    ) -> tuple[Floats, Floats, Floats]:
        """How the coordinates acted on answer at the present pose, all others free and the points `held` kept where they are.

        Each of these has the lever that it had when it was found, `age` [s] ago: at a wheel that rolls on, the place where it
        was lies behind the axle, and would hold the wheel's turning by the weight.

        With the mass matrix M = sum of m J^T J + K^T I K over the bodies, the coordinates of a free base among them, and C the
        velocities of what is held, by coordinates: P = M^-1 - M^-1 C^T (C M^-1 C^T)^+ C M^-1. pybullet's calculateMassMatrix
        refuses a tree whose inertia rounding leaves unsymmetric.

        Returns: mobility (a, a), the accelerations by unit efforts on each, a block of P; fall (a,), those by gravity [m/s2];
        loose (a, a), the mobility if nothing were held.
        Source: Udwadia, Kalaba, Analytical Dynamics, 1996, chapter 3 (the equations of motion under constraints).
        """
        links = port.bullet.getLinkStates(
            number,
            range(len(self.mass) - self.free),
            computeLinkVelocity=1,
            computeForwardKinematics=1,
            physicsClientId=port.client,
        )
        rows = [link[0] + link[4] + link[1] + link[6] for link in links]
        if self.free:
            p, q = port.bullet.getBasePositionAndOrientation(number, physicsClientId=port.client)
            v, _ = port.bullet.getBaseVelocity(number, physicsClientId=port.client)
            rows.insert(0, p + p + q + v)
        table = np.array(rows)
        centre, origin, turn = table[:, :3], table[:, 3:6], matrices(table[:, 6:10])
        axis = np.einsum("dij,dj->di", turn[self.moved], self.axis)
        arm = np.cross(axis, centre[:, None] - origin[self.moved])
        J = np.where(self.turns[:, None], arm, axis) * self.carries[..., None]
        K = np.where(self.turns[:, None], axis, 0.0) * self.carries[..., None]
        if self.free:
            each = np.broadcast_to(np.eye(3), (len(centre), 3, 3))
            J = np.concatenate((each, np.cross(np.eye(3), (centre - centre[0])[:, None]), J), axis=1)
            K = np.concatenate((np.zeros_like(each), each, K), axis=1)
        weighed, turned = J * np.sqrt(self.mass)[:, None, None], (K @ turn) * np.sqrt(self.moments)[:, None]
        root = np.concatenate((weighed, turned), axis=2).transpose(0, 2, 1).reshape(6 * len(centre), -1)
        acted = self.acted + 6 * self.free
        wanted = np.eye(root.shape[1])[:, acted]
        pulled = np.einsum("bdi,b,i->d", J, self.mass, np.asarray(gravity))
        answers: Floats = np.linalg.solve(root.T @ root, np.column_stack((wanted, pulled)))
        loose = answers[acted, :-1]
        if held:
            bodies = np.array([hold.link for hold in held]) + self.free
            lever = np.array([hold.point_W for hold in held]) - (centre - age * table[:, 10:])[bodies]
            moves = J[bodies] + np.cross(K[bodies], lever[:, None])
            C = np.concatenate([hold.rows @ move.T for hold, move in zip(held, moves, strict=True)])
            push = np.linalg.solve(root.T @ root, C.T)
            answers = answers - push @ (np.linalg.pinv(C @ push, rcond=SINGULAR, hermitian=True) @ (C @ answers))
        return answers[acted, :-1], answers[acted, -1], loose
