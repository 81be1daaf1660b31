"""Fast rotors: hinges about which something spins so fast that explicit steps in joint coordinates let its bearings wobble.

With the coordinates' rates u, M u' + c(u) = efforts; c holds the inertial forces, of second order in u. A step h that takes c
from its start makes a wobble at the rate W, an eigenvalue i W of -M^-1 dc/du, longer by (W h)^2/2: by e^(W^2 h/2) a second.
A rotor in bearings that stand still has no wobble, whatever its speed.

Source: Goldstein, Classical Mechanics, 3rd ed., section 5.7 (nutation); the growth is |1 + i W h| of Euler's explicit method.
"""

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.harness.adapter.notice import Notice
from plumbline.harness.adapter.rotations import matrix
from plumbline.harness.adapter.spanning_forest import Branch, spanning_forest
from plumbline.harness.scene import WORLD, Ball, Body, Distance, Fixed, Joint, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import Floats

WOBBLE = 20.0
"""The rate [rad/s] from which on a wobble counts: at 1/240 s it more than doubles each second, e^(W^2 h/2) = 2.3."""
COARSE = 0.2
"""The angle [rad] a step of a wobble that a constraint may not keep: a gimbal keeps its energy to 1e-4 at 0.15, and ends with
2.4 times of it at 0.25 (DART)."""
EVEN = 0.01
"""By how much of itself a rotor's inertia may differ across its axis."""
_GROUND = "\n"
"""All that does not move, in the graph of joints: names are printable, so that no body can be called so."""


@dataclass(frozen=True, slots=True)
class FastRotors:
    """The hinges about which fast rotors spin, by name, and the fastest wobble [rad/s] of what carries them."""

    hinges: frozenset[str] = frozenset()
    wobble: float = 0.0

    def __bool__(self) -> bool:
        """Are there any?"""
        return bool(self.hinges)

    def growth(self, h: float) -> float:
        """By how many e-folds a second [1/s] explicit steps of h [s] in joint coordinates let the wobble grow."""
        return self.wobble**2 * h / 2


def fast_rotors(scene: Scene) -> FastRotors:
    """The fast rotors of a scene, by its velocities at the start and those that drives ask for."""
    hinges = {joint.name for joint in scene.joints if isinstance(joint, Revolute) and _fast(scene, joint)}
    if not hinges:
        return FastRotors()
    moving = {body.name: body for body in scene.bodies if body.movable}

    def ends(joint: Joint) -> tuple[str, str]:
        parent, child = (name if name in moving else _GROUND for name in (joint.parent, joint.child))
        return parent, child

    joints: list[Joint] = [
        joint for joint in scene.joints if not isinstance(joint, Distance) and ends(joint) != (_GROUND, _GROUND)
    ]
    forest = spanning_forest(joints, ends)
    held = {name for joint in joints for name in ends(joint)}
    found, wobble, seen = set[str](), 0.0, set[str]()
    # A tree that nothing holds hangs on what turns least, as rotors hang on their carriers.
    for root in (_GROUND, *sorted(moving, key=lambda name: math.hypot(*moving[name].w_WB))):
        if root in seen or root not in held:
            continue
        trees: list[list[Branch[str, Joint]]] = []
        for branch in forest.depth_first(root):
            if not trees or (root == _GROUND and branch.above == _GROUND):
                trees.append([])
            trees[-1].append(branch)
            seen.add(branch.node)
        for tree in trees:
            spun = hinges.intersection(branch.edge.name for branch in tree)
            rate = _RotorTree(moving.get(root), tree, moving).wobble() if spun else 0.0
            if rate > WOBBLE:
                found |= spun
                wobble = max(wobble, rate)
    return FastRotors(frozenset(found), wobble)


def rotor_notices(scene: Scene, joints: Sequence[Joint], constrained: Container[str], h: float) -> list[Notice]:
    """What to say of fast rotors in explicit steps of h [s]: on coordinates, and where a constraint does not suffice."""
    rotors, notices = fast_rotors(scene), list[Notice]()
    for joint in joints:
        if joint.name not in rotors.hinges:
            continue
        turns = f"deviation: fast rotor on joint '{joint.name}': what carries it wobbles at {rotors.wobble:.3g} rad/s, "
        if joint.name not in constrained:
            growth = f"which explicit steps of {h:.3g} s in joint coordinates let grow by e^{rotors.growth(h):.2g} a second"
            notices.append(Notice(turns + growth))
        elif rotors.wobble * h > COARSE:
            notices.append(Notice(turns + f"too fast for steps of {h:.3g} s, even on a constraint"))
        elif _uneven(scene, joint):
            notices.append(Notice(turns + "and it is uneven across its axis, which takes its energy even on a constraint"))
    return notices


def _uneven(scene: Scene, joint: Joint) -> bool:
    """Is what spins about a hinge another's inertia across the axis in one direction than in another?"""
    assert isinstance(joint, Revolute)
    axis = np.array(joint.axis_W)
    ends = [scene.body(name) for name in (joint.parent, joint.child) if name != WORLD]
    rotor = max(ends, key=lambda body: abs(float(np.array(body.w_WB) @ axis)))
    R = matrix(rotor.q_WB)
    across = np.eye(3) - np.outer(axis, axis)
    _, low, high = np.linalg.eigvalsh(across @ R @ np.asarray(rotor.inertia) @ R.T @ across)
    return bool(high > low * (1 + EVEN))


def _fast(scene: Scene, joint: Revolute) -> bool:
    """Does it turn, or is it to be driven, at half of WOBBLE? A disc, the flattest of rotors, wobbles at twice its spin."""
    w = [np.zeros(3) if name == WORLD else np.array(scene.body(name).w_WB) for name in (joint.parent, joint.child)]
    return max(abs(float((w[1] - w[0]) @ joint.axis_W)), abs(_wanted(joint))) >= WOBBLE / 2


def _wanted(joint: Joint) -> float:
    """The rate [rad/s] that a drive is to reach; 0 where none is."""
    drive = getattr(joint, "drive", None)
    return drive.target_velocity if drive is not None and drive.damping > 0 else 0.0


class _RotorTree:
    """Bodies on joints from what stands still, or from a free body, outward; all vectors in W, at the start."""

    def __init__(self, root: Body | None, branches: Sequence[Branch[str, Joint]], moving: dict[str, Body]) -> None:
        self.root, self.branches, self.moving = root, branches, moving
        self.bodies = [*([] if root is None else [root]), *(moving[branch.node] for branch in branches)]
        self.place = {body.name: k for k, body in enumerate(self.bodies)}
        turns = [matrix(body.q_WB) for body in self.bodies]
        self.inertia = np.array([R @ np.asarray(b.inertia) @ R.T for R, b in zip(turns, self.bodies, strict=True)])
        self.mass = np.array([body.mass for body in self.bodies])
        axes = [_axes(branch.edge) for branch in branches]
        first = 0 if root is None else 6
        self.columns = np.cumsum([first, *(len(each) for each in axes)])
        self.axes = axes

    def wobble(self) -> float:
        """The fastest rate [rad/s] at which its rates turn about those of the start."""
        rates = self._rates()
        units = np.eye(len(rates))
        moves = [self._motion(unit) for unit in units]
        turned, moved = (np.array([move[k] for move in moves]) for k in (0, 1))
        mass = np.einsum("ikx,kxy,jky->ij", turned, self.inertia, turned) + np.einsum("ikx,k,jkx->ij", moved, self.mass, moved)

        def bias(u: Floats) -> Floats:
            w, _, alpha, a = self._motion(u)
            torque = np.einsum("kxy,ky->kx", self.inertia, alpha) + np.cross(w, np.einsum("kxy,ky->kx", self.inertia, w))
            pull: Floats = np.einsum("ikx,kx->i", turned, torque) + np.einsum("ikx,k,kx->i", moved, self.mass, a)
            return pull

        # Of second order in u, so that the difference is the derivative.
        slope = np.array([bias(rates + unit) - bias(rates - unit) for unit in units]).T / 2
        return float(np.abs(np.linalg.eigvals(np.linalg.solve(mass, slope)).imag).max(initial=0.0))

    def _rates(self) -> Floats:
        """The coordinates' rates (d,) at the start; a hinge's is what its drive asks for, if that is faster."""
        rates = np.zeros(self.columns[-1])
        if self.root is not None:
            rates[:6] = *self.root.v_WB, *self.root.w_WB
        for branch, axes, first in zip(self.branches, self.axes, self.columns, strict=False):
            child, joint = self.moving[branch.node], branch.edge
            w_P, v_P, p_P = (np.array(each) for each in self._above(branch))
            if isinstance(joint, Prismatic):
                relative = np.array(child.v_WB) - v_P - np.cross(w_P, np.array(child.p_WB) - p_P)
            else:
                relative = np.array(child.w_WB) - w_P
            rate = axes @ relative
            if isinstance(joint, Revolute) and abs(wanted := _wanted(joint)) > abs(rate[0]):
                rate = np.array([wanted if joint.child == branch.node else -wanted])
            rates[first : first + len(axes)] = rate
        return rates

    def _above(self, branch: Branch[str, Joint]) -> tuple[Sequence[float], Sequence[float], Sequence[float]]:
        """w, v and p of what a branch leaves from."""
        body = self.moving.get(branch.above)
        return ((0.0,) * 3,) * 3 if body is None else (body.w_WB, body.v_WB, body.p_WB)

    def _motion(self, u: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """w, v and, at constant u, their derivatives, each (n, 3), of the bodies."""
        w, v, alpha, a = np.zeros((4, len(self.bodies), 3))
        if self.root is not None:
            v[0], w[0] = u[:3], u[3:6]
        for branch, axes, first in zip(self.branches, self.axes, self.columns, strict=False):
            k, joint, p_C = self.place[branch.node], branch.edge, np.array(self.moving[branch.node].p_WB)
            given = axes.T @ u[first : first + len(axes)] if len(axes) else np.zeros(3)
            turn, slide = (np.zeros(3), given) if isinstance(joint, Prismatic) else (given, np.zeros(3))
            above = self.place.get(branch.above)
            w_P, v_P, alpha_P, a_P = np.zeros((4, 3)) if above is None else (w[above], v[above], alpha[above], a[above])
            p_P = np.zeros(3) if above is None else np.array(self.bodies[above].p_WB)
            anchor = np.array(joint.anchor_W) if isinstance(joint, Ball | Revolute) else p_C
            near, far = anchor - p_P, p_C - anchor
            w[k], alpha[k] = w_P + turn, alpha_P + np.cross(w_P, turn)
            v[k] = v_P + np.cross(w_P, near) + np.cross(w[k], far) + slide
            a[k] = a_P + np.cross(alpha_P, near) + np.cross(w_P, np.cross(w_P, near)) + 2 * np.cross(w_P, slide)
            a[k] += np.cross(alpha[k], far) + np.cross(w[k], np.cross(w[k], far))
        return w, v, alpha, a


def _axes(joint: Joint) -> Floats:
    """The axes (d, 3) of a joint's coordinates."""
    if isinstance(joint, Fixed):
        return np.zeros((0, 3))
    return np.eye(3) if isinstance(joint, Ball) else np.array([joint.axis_W])  # type: ignore[union-attr]
