"""The motion of a few bodies and joints, worked out from Newton's and Euler's laws alone: what pairs of nouns are judged by.

All bodies have six coordinates; joints are rows of J a = -b, their forces J^T l, and [M -J^T; J 0] [a; l] = [f; -b] is solved
at each instant by elimination (Featherstone, Rigid Body Dynamics Algorithms, section 3.2; Shabana, Dynamics of Multibody
Systems, 4th ed., section 3.4). Nothing is shared with an engine or with `harness.trajectory`: rotations are quaternions that
are integrated with the rest by the classical Runge-Kutta method, and rows follow from what is fixed to a body, a point or a
direction, by differentiating it twice. Tests compare it with Pinocchio, which works in joint coordinates.

What it does not know (contacts, limits that are reached, rods, armature, couplings, damping) it refuses.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.scene import WORLD, Ball, Distance, Effect, Fixed, Joint, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import Floats

_MOMENT = 1e-4
"""Seconds over which a prescribed law is differentiated: central differences err by its square, and round by 1e-16 over it."""


@dataclass(frozen=True, slots=True)
class EndState:
    """The state at the end, and what tells how far a method of first order may be off on the way there.

    Terms:
        p_WB (n, 3) m, q_WB (n, 4), v_WB (n, 3) m/s, w_WB (n, 3) rad/s. gained, turned: the greatest over bodies of what
        |v'| [m/s] and |w'| [rad/s] add up to. varied, swung: the greatest change of v' [m/s2] and w' [rad/s2] on the way,
        added up.
    """

    p_WB: Floats
    q_WB: Floats
    v_WB: Floats
    w_WB: Floats
    gained: float
    turned: float
    varied: float
    swung: float


@dataclass(frozen=True, slots=True)
class _Fixture:
    """A point or a direction that is fixed to a body, at an instant: its value, rate, lever and centripetal term."""

    body: int
    value: Floats
    rate: Floats
    lever: Floats
    bias: Floats
    point: bool


def _product(q: Floats, r: Floats) -> Floats:
    w, x, y, z = q
    a, b, c, d = r
    return np.array(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ]
    )


def matrix(q: Floats) -> Floats:
    """R (3, 3) of a quaternion (w, x, y, z) of any length."""
    w, x, y, z = q / np.sqrt(q @ q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _cross(a: Floats, b: Floats) -> Floats:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


class Multibody:
    """A scene as equations of motion; the last body is the world.

    Args: wrenches: forces [N] at centres of mass and torques [N m] in W that stay as they are, by the names of bodies.
    Raises: NotImplementedError: for what it does not know.
    """

    def __init__(self, scene: Scene, wrenches: dict[str, tuple[Any, Any]] | None = None) -> None:
        self.scene, n = scene, len(scene.bodies) + 1
        self._index = {body.name: k for k, body in enumerate(scene.bodies)} | {WORLD: n - 1}
        self._free = np.array([k for k, body in enumerate(scene.bodies) if body.movable], dtype=np.int64)
        self._mass = np.array([body.mass for body in scene.bodies] + [1.0])
        self._inertia = np.array([body.inertia for body in scene.bodies] + [np.eye(3)])
        self._push, self._twist = np.zeros((n, 3)), np.zeros((n, 3))
        for name, (force, torque) in (wrenches or {}).items():
            self._push[self._index[name]], self._twist[self._index[name]] = force, torque
        for body in scene.bodies:
            if body.linear_damping or body.angular_damping:
                raise NotImplementedError(f"body '{body.name}': damping")
        self._gravity = np.array(scene.gravity) * (Effect.GRAVITY in scene.effects)
        self._gyroscopic = Effect.GYROSCOPIC in scene.effects
        self._p = np.array([body.p_WB for body in scene.bodies] + [(0.0, 0.0, 0.0)])
        self._q = np.array([body.q_WB for body in scene.bodies] + [(1.0, 0.0, 0.0, 0.0)])
        self._joints = [self._local(joint) for joint in scene.joints]

    def _local(self, joint: Joint) -> tuple[Joint, int, int, dict[str, Floats]]:
        """A joint with what is fixed to its bodies, in their frames."""
        if isinstance(joint, Fixed):
            raise NotImplementedError(f"joint '{joint.name}': fixed")
        if isinstance(joint, Distance) and (joint.spring is None or joint.limits is not None):
            raise NotImplementedError(f"joint '{joint.name}': a rod, or a rope")
        if isinstance(joint, Revolute | Prismatic) and (joint.armature or joint.speed_limit or joint.coupling):
            raise NotImplementedError(f"joint '{joint.name}': armature, speed limit or coupling")
        parent, child = self._index[joint.parent], self._index[joint.child]
        R_P, R_C = matrix(self._q[parent]), matrix(self._q[child])
        end = joint.child_anchor_W if isinstance(joint, Distance) else joint.anchor_W
        local = {"parent": R_P.T @ (joint.anchor_W - self._p[parent]), "child": R_C.T @ (end - self._p[child])}
        if isinstance(joint, Revolute | Prismatic):
            axis = np.array(joint.axis_W) / np.linalg.norm(joint.axis_W)
            aside = _cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
            aside /= np.linalg.norm(aside)
            for name, direction in (("x", axis), ("y", aside), ("z", _cross(axis, aside))):
                local[f"parent {name}"], local[f"child {name}"] = R_P.T @ direction, R_C.T @ direction
        return joint, parent, child, local

    def start(self) -> Floats:
        """The state (n, 13) at time 0: p_WB, q_WB, v_WB, w_WB."""
        velocities = np.array([np.concatenate(body.velocity_at_start) for body in self.scene.bodies] + [np.zeros(6)])
        return np.hstack((self._p, self._q, velocities))

    def _led(self, state: Floats, time: float) -> Floats:
        """Put bodies whose motion is prescribed where they are, and give the accelerations (n, 6) of all that is led."""
        acceleration = np.zeros((len(state), 6))
        for k, body in enumerate(self.scene.bodies):
            if body.prescribed is None:
                if body.motion == "kinematic":
                    state[k, 7:] = np.concatenate((body.v_WB, body.w_WB))
                continue
            poses = [body.prescribed.pose(body.p_WB, body.q_WB, body.v_WB, time + shift) for shift in (-_MOMENT, 0.0, _MOMENT)]
            p = np.array([pose[0] for pose in poses])
            angle = np.array([body.prescribed.angle(time + shift) for shift in (-_MOMENT, 0.0, _MOMENT)])
            axis = np.zeros(3) if body.prescribed.turn is None else np.array(body.prescribed.turn.axis_W)
            state[k, :3], state[k, 3:7] = p[1], poses[1][1]
            state[k, 7:10], state[k, 10:] = (p[2] - p[0]) / (2 * _MOMENT), axis * (angle[2] - angle[0]) / (2 * _MOMENT)
            acceleration[k, :3] = (p[2] - 2 * p[1] + p[0]) / _MOMENT**2
            acceleration[k, 3:] = axis * (angle[2] - 2 * angle[1] + angle[0]) / _MOMENT**2
        return acceleration

    def accelerations(self, state: Floats, time: float = 0.0) -> Floats:
        """v' [m/s2] and w' [rad/s2] in W of all bodies, (n, 6), at a state (n, 13) whose led bodies are put in their places."""
        led, n = self._led(state, time), len(state)
        turns = [matrix(q) for q in state[:, 3:7]]
        force, blocks = np.zeros((n, 6)), np.zeros((6 * n, 6 * n))
        for k in self._free:
            w, inertia = state[k, 10:], turns[k] @ self._inertia[k] @ turns[k].T
            force[k, :3] = self._mass[k] * self._gravity + self._push[k]
            force[k, 3:] = self._twist[k] - self._gyroscopic * _cross(w, inertia @ w)
            blocks[6 * k : 6 * k + 3, 6 * k : 6 * k + 3] = self._mass[k] * np.eye(3)
            blocks[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6] = inertia
        rows, biases = list[Floats](), list[float]()

        def fixture(body: int, local: Floats, point: bool) -> _Fixture:
            lever, w = turns[body] @ local, state[body, 10:]
            swinging = _cross(w, lever)
            value, rate = (lever + state[body, :3], swinging + state[body, 7:10]) if point else (lever, swinging)
            return _Fixture(body, value, rate, lever, _cross(w, swinging), point)

        def row(terms: tuple[tuple[_Fixture, Floats], ...]) -> Floats:
            """d/dt of a sum of value . weight, the weights held: in velocities (6 n,)."""
            gradient = np.zeros((n, 6))
            for held, weight in terms:
                gradient[held.body, 3:] += _cross(held.lever, weight)
                if held.point:
                    gradient[held.body, :3] += weight
            return gradient.ravel()

        def along(direction: _Fixture, tail: _Fixture, head: _Fixture) -> tuple[Floats, float]:
            """Of direction . (head - tail), its row and what its second derivative has beside it."""
            apart, parting = head.value - tail.value, head.rate - tail.rate
            u = direction.value
            bias = direction.bias @ apart + 2 * direction.rate @ parting + u @ (head.bias - tail.bias)
            return row(((direction, apart), (head, u), (tail, -u))), float(bias)

        def upright(a: _Fixture, b: _Fixture) -> tuple[Floats, float]:
            """Of a . b, both directions."""
            return row(((a, b.value), (b, a.value))), float(a.bias @ b.value + 2 * a.rate @ b.rate + a.value @ b.bias)

        def hold(equation: tuple[Floats, float]) -> None:
            rows.append(equation[0])
            biases.append(equation[1])

        for joint, parent, child, local in self._joints:
            tail, head = fixture(parent, local["parent"], point=True), fixture(child, local["child"], point=True)
            if isinstance(joint, Distance):
                assert joint.spring is not None
                apart = head.value - tail.value
                length = float(np.sqrt(apart @ apart))
                pull = joint.spring.stiffness * (length - joint.spring.rest)
                pull += joint.spring.damping * float((head.rate - tail.rate) @ apart) / length
                force -= pull * row(((head, apart / length), (tail, -apart / length))).reshape(n, 6)
                continue
            if isinstance(joint, Ball | Revolute):
                for axis in np.eye(3):
                    rows.append(row(((head, axis), (tail, -axis))))
                    biases.append(float(axis @ (head.bias - tail.bias)))
            if not isinstance(joint, Revolute | Prismatic):
                continue
            on_parent = {name: fixture(parent, local[f"parent {name}"], point=False) for name in "xyz"}
            on_child = {name: fixture(child, local[f"child {name}"], point=False) for name in "xyz"}
            if isinstance(joint, Revolute):
                for name in "yz":
                    hold(upright(on_parent[name], on_child["x"]))
                x = on_parent["x"].value
                sine, cosine = (float(on_parent[name].value @ on_child["y"].value) for name in "zy")
                coordinate, rate = np.arctan2(sine, cosine), float(x @ (state[child, 10:] - state[parent, 10:]))
                slope = np.zeros((n, 6))
                slope[child, 3:], slope[parent, 3:] = x, -x
            else:
                for a, b in ("xy", "yz", "zx"):
                    hold(upright(on_parent[a], on_child[b]))
                for name in "yz":
                    hold(along(on_parent[name], tail, head))
                slope = along(on_parent["x"], tail, head)[0].reshape(n, 6)
                coordinate = float(on_parent["x"].value @ (head.value - tail.value))
                rate = float(np.sum(slope * state[:, 7:]))
            force += self._along(joint, coordinate + joint.position, rate) * slope
        equations, driven = np.array(rows).reshape(-1, 6 * n), np.ones(n, dtype=bool)
        driven[self._free] = False
        columns = np.repeat(~driven, 6)
        held = equations[:, columns]
        size = held.shape[1]
        system = np.zeros((size + len(held), size + len(held)))
        system[:size, :size] = blocks[np.ix_(columns, columns)]
        system[:size, size:], system[size:, :size] = -held.T, held
        right = np.concatenate((force.ravel()[columns], -np.array(biases) - equations[:, ~columns] @ led.ravel()[~columns]))
        led[self._free] = np.linalg.solve(system, right)[:size].reshape(-1, 6)
        return led

    def _along(self, joint: Revolute | Prismatic, coordinate: float, rate: float) -> float:
        """What acts along a coordinate [N or N m]. Raises: NotImplementedError: a limit is reached."""
        limits = joint.limits
        if limits is not None and not (
            (limits.lower is None or coordinate > limits.lower) and (limits.upper is None or coordinate < limits.upper)
        ):
            raise NotImplementedError(f"joint '{joint.name}': at {coordinate} a limit is reached")
        total = 0.0
        if joint.spring is not None:
            total -= joint.spring.stiffness * (coordinate - joint.spring.rest) + joint.spring.damping * rate
        if joint.drive is not None:
            drive = joint.drive
            wanted = drive.stiffness * (drive.target - coordinate) + drive.damping * (drive.target_velocity - rate)
            wanted += drive.feedforward or 0.0
            total += wanted if drive.limit is None else max(-drive.limit, min(drive.limit, wanted))
        return total - (joint.friction_loss or 0.0) * float(np.sign(rate))

    def motion(self, duration: float, steps: int) -> EndState:
        """Where all is after `duration` [s], in so many steps of the classical Runge-Kutta method."""
        state, h, last = self.start(), duration / steps, np.zeros(0)
        grown, changed = np.zeros((2, len(state))), np.zeros((2, len(state)))

        def slope(y: Floats, time: float) -> tuple[Floats, Floats]:
            placed = y.copy()
            a = self.accelerations(placed, time)
            turning = np.array(
                [_product(np.array([0.0, *w]), q) / 2 for q, w in zip(placed[:, 3:7], placed[:, 10:], strict=True)]
            )
            return np.hstack((placed[:, 7:10], turning, a)), a

        for k in range(steps):
            time = k * h
            k1, a = slope(state, time)
            k2, _ = slope(state + h / 2 * k1, time + h / 2)
            k3, _ = slope(state + h / 2 * k2, time + h / 2)
            k4, _ = slope(state + h * k3, time + h)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            state[:, 3:7] /= np.linalg.norm(state[:, 3:7], axis=1, keepdims=True)
            for kind, columns in enumerate((slice(0, 3), slice(3, 6))):
                grown[kind] += h * np.linalg.norm(a[:, columns], axis=1)
                if last.size:
                    changed[kind] += np.linalg.norm(a[:, columns] - last[:, columns], axis=1)
            last = a
        self._led(state, duration)
        gained, turned, varied, swung = (float(row.max()) for row in (*grown, *changed))
        bodies = state[:-1]
        return EndState(bodies[:, :3], bodies[:, 3:7], bodies[:, 7:10], bodies[:, 10:], gained, turned, varied, swung)
