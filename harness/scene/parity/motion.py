"""Joint-space dynamics of a robot in canonical form: inertia, gravity and passive accelerations in W, and states to look at.

The displacement of what a joint moves is a product of exponentials of the lines at the zero configuration; accelerations are
those of Newton and Euler, limits and dry friction left out.

Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, section 3.2.
"""

from dataclasses import dataclass

import numpy as np

from plumbline.harness.scene.importers.poses import Array, Pose
from plumbline.harness.scene.importers.robot import Coordinate
from plumbline.harness.scene.parity.canonical import FIXED, SCALAR, Canonical

_SIZE = {"revolute": 1, "prismatic": 1, "ball": 3, "free": 6}


@dataclass(frozen=True, slots=True, eq=False)
class Configuration:
    """Terms: q: one value a joint [rad or m], 0 for balls and free ones. turned: their displacement, by place. rates (n,)."""

    q: Array
    turned: dict[int, Pose]
    rates: Array


@dataclass(frozen=True, slots=True, eq=False)
class Dynamics:
    """Terms: M (n, n): mass matrix without armature. bias (n,): inertial and gravity forces at zero acceleration."""

    M: Array
    bias: Array


def first_rates(robot: Canonical) -> list[int]:
    """The first rate of each joint, and the number of all."""
    return [0, *np.cumsum([_SIZE[joint.kind] for joint in robot.joints]).tolist()]


@dataclass(frozen=True, slots=True, eq=False)
class _Tree:
    """A robot's numbers in rows, one a joint (N) or a massive group (B), and which rates (n) move which of them.

    Terms: starts: first rate of each joint, and n. owns, moves (N, n): the rates of the joint itself, and with those before it.
    before (N, N): 1 for a joint and all before it. axes, anchors, unit (N, 3); hinges, slides (N,): 1 where it is one.
    bodies (B,): rows of the joints that move the groups. mass (B,), centre (B, 3), inertia (B, 3, 3).
    """

    starts: list[int]
    parents: list[int]
    owns: Array
    moves: Array
    before: Array
    axes: Array
    unit: Array
    anchors: Array
    hinges: Array
    slides: Array
    bodies: list[int]
    mass: Array
    centre: Array
    inertia: Array


def _tree(robot: Canonical) -> _Tree:
    links, joints, starts = robot.moving, robot.joints, first_rates(robot)
    rows, count = {link.name: k for k, link in enumerate(links)}, len(links)
    parents = [-1 if link.parent in (None, FIXED) else rows[link.parent] for link in links]
    before, owns = np.eye(count), np.zeros((count, starts[-1]))
    for k, parent in enumerate(parents):
        owns[k, starts[k] : starts[k + 1]] = 1.0
        if parent >= 0:
            before[k] += before[parent]
    axes = np.array([joint.axis for joint in joints]).reshape(count, 3)
    massive = {k: link.solid for k, link in enumerate(links) if link.solid is not None and link.solid.mass > 0}
    solids = massive.values()
    lengths = np.linalg.norm(axes, axis=1, keepdims=True)
    return _Tree(
        starts=starts,
        parents=parents,
        owns=owns,
        moves=before @ owns,
        before=before,
        axes=axes,
        unit=axes / np.where(lengths > 0, lengths, 1.0),
        anchors=np.array([joint.anchor for joint in joints]).reshape(count, 3),
        hinges=np.array([float(joint.kind == "revolute") for joint in joints]),
        slides=np.array([float(joint.kind == "prismatic") for joint in joints]),
        bodies=list(massive),
        mass=np.array([solid.mass for solid in solids]),
        centre=np.array([solid.centre for solid in solids]).reshape(-1, 3),
        inertia=np.array([solid.inertia for solid in solids]).reshape(-1, 3, 3),
    )


def _hat(v: Array) -> Array:
    """The matrices of cross products with the rows of v; (..., 3) -> (..., 3, 3)."""
    return np.asarray(v @ _LEVI_CIVITA.reshape(3, 9)).reshape(*v.shape[:-1], 3, 3)


_LEVI_CIVITA = np.array(
    [[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0]]],
    dtype=np.float64,
)


def _crossed(a: Array, b: Array) -> Array:
    """Cross products row by row."""
    return np.asarray((_hat(a) @ b[..., None])[..., 0])


def _lines(robot: Canonical, tree: _Tree, at: Configuration) -> tuple[Array, Array, Array]:
    """R (N, 3, 3) and p (N, 3) of each joint's displacement in W, and the twists S (6, n) of its rates about W's origin."""
    angle, K = at.q * tree.hinges, _hat(tree.unit)
    steps = np.eye(3) + np.sin(angle)[:, None, None] * K + (1 - np.cos(angle))[:, None, None] * (K @ K)
    shifts = tree.anchors - (steps @ tree.anchors[..., None])[..., 0] + (at.q * tree.slides)[:, None] * tree.unit
    R, p = np.empty((len(steps), 3, 3)), np.empty((len(steps), 3))
    S = np.zeros((6, tree.starts[-1]))
    for k, (joint, parent) in enumerate(zip(robot.joints, tree.parents, strict=True)):
        R_WP, p_WP = (R[parent], p[parent]) if parent >= 0 else (_UNTURNED, _NOWHERE)
        step, shift = steps[k], shifts[k]
        if joint.kind in ("ball", "free"):
            turned = at.turned.get(k)
            if turned is not None:
                step, shift = turned.R, turned.p
            here = tree.starts[k]
            S[:3, here : here + 3] = R_WP
            S[3:, here : here + 3] = _hat(R_WP @ (step @ tree.anchors[k] + shift) + p_WP) @ R_WP
            if joint.kind == "free":
                S[3:, here + 3 : here + 6] = R_WP
        else:
            axis = R_WP @ tree.axes[k]
            if joint.kind == "prismatic":
                S[3:, tree.starts[k]] = axis
            else:
                S[:3, tree.starts[k]] = axis
                S[3:, tree.starts[k]] = _hat(R_WP @ tree.anchors[k] + p_WP) @ axis
        R[k] = R_WP @ step
        p[k] = R_WP @ shift + p_WP
    return R, p, S


_UNTURNED, _NOWHERE = np.eye(3), np.zeros(3)


def dynamics(robot: Canonical, at: Configuration, gravity: Array) -> Dynamics:
    """Inertia and bias forces at a configuration with rates."""
    tree = _tree(robot)
    R, p, S = _lines(robot, tree, at)
    own = (tree.owns * at.rates) @ S.T
    V = tree.before @ own
    before, own_w = V - own, own[:, :3]
    c = np.hstack([_crossed(before[:, :3], own_w), _crossed(before[:, :3], own[:, 3:]) + _crossed(before[:, 3:], own_w)])
    for k, joint in enumerate(robot.joints):
        if joint.kind == "free":  # its own origin moves on, and with it the point that it turns about
            moving = S[3:, tree.starts[k] + 3 : tree.starts[k] + 6] @ at.rates[tree.starts[k] + 3 : tree.starts[k] + 6]
            c[k, 3:] += np.cross(moving, own_w[k])
    V, A, R = V[tree.bodies], (tree.before @ c)[tree.bodies], R[tree.bodies]
    w, mass = V[:, :3], tree.mass[:, None]
    centre = (R @ tree.centre[..., None])[..., 0] + p[tree.bodies]
    inertia = R @ tree.inertia @ R.transpose(0, 2, 1)
    force = mass * (A[:, 3:] + _crossed(A[:, :3], centre) + _crossed(w, V[:, 3:] + _crossed(w, centre)) - gravity)
    spin = (inertia @ w[..., None])[..., 0]
    moment = (inertia @ A[:, :3, None])[..., 0] + _crossed(w, spin) + _crossed(centre, force)
    arm, spatial = _hat(centre), np.empty((len(tree.bodies), 6, 6))
    spatial[:, :3, :3] = inertia - mass[..., None] * (arm @ arm)
    spatial[:, :3, 3:] = mass[..., None] * arm
    spatial[:, 3:, :3] = -spatial[:, :3, 3:]
    spatial[:, 3:, 3:] = mass[..., None] * np.eye(3)
    moves = tree.moves[tree.bodies]
    J = moves[:, None, :] * S
    M = (J.transpose(0, 2, 1) @ (spatial @ J)).sum(axis=0)
    bias = (S.T * (moves.T @ np.hstack([moment, force]))).sum(axis=1)
    return Dynamics(M, bias)


def passive(robot: Canonical, at: Configuration, gravity: Array) -> tuple[Array, Array]:
    """Mass matrix with armature, and the forces that decelerate: bias, dampers and springs; M qdd = -forces."""
    terms, starts = dynamics(robot, at, gravity), first_rates(robot)
    M, forces = terms.M, terms.bias.copy()
    for k, joint in enumerate(robot.joints):
        here = slice(starts[k], starts[k + 1])
        M.flat[starts[k] * (len(M) + 1) : starts[k + 1] * (len(M) + 1) : len(M) + 1] += joint.armature
        forces[here] += joint.damping * at.rates[here]
        if joint.kind in SCALAR:
            forces[here] += joint.stiffness * (at.q[k] - joint.rest)
    return M, forces


COUNT = 10
"""States at which two robots are looked at."""
_OPEN = {"revolute": np.pi, "prismatic": 0.5}
"""Half of the range of a joint without limits [rad, m]."""


def drawn(a: Canonical, b: Canonical, seed: int, count: int = COUNT) -> list[Configuration]:
    """States of the joints of A: uniform inside the limits of A and B, rates within 1 rad/s or m/s and both bounds of speed.

    Balls and free joints are drawn in their rates alone; where the two ranges do not meet, A's is taken.
    """
    rng = np.random.default_rng(seed)
    partners = {joint.name: joint for joint in b.joints}
    pairs = [(joint, partners.get(joint.name, joint)) for joint in a.joints]
    ranges = np.array([_range(*pair) for pair in pairs]).reshape(-1, 2)
    speeds = np.array([min([1.0, *(joint.speed for joint in pair if joint.speed is not None)]) for pair in pairs])
    starts = first_rates(a)
    states = []
    for _ in range(count):
        q = rng.uniform(ranges[:, 0], ranges[:, 1])
        states.append(Configuration(q, {}, rng.uniform(-1.0, 1.0, starts[-1]) * np.repeat(speeds, np.diff(starts))))
    return states


def _range(a: Coordinate, b: Coordinate) -> tuple[float, float]:
    if a.kind not in _OPEN:
        return 0.0, 0.0
    half = _OPEN[a.kind]

    def bounds(*joints: Coordinate) -> tuple[float, float]:
        lower = max((j.lower for j in joints if j.lower is not None), default=None)
        upper = min((j.upper for j in joints if j.upper is not None), default=None)
        if lower is None:
            lower = -half if upper is None else upper - 2 * half
        return max(lower, -1e3), min(lower + 2 * half if upper is None else upper, 1e3)

    low, high = bounds(a, b)
    if low > high:
        low, high = bounds(a)
    return (low, high) if low <= high else (0.0, 0.0)
