"""Joint-space motion of a robot of facts: inertia, gravity and passive accelerations in W, and a second of it.

The displacement of what a joint moves is a product of exponentials of the lines at the zero configuration; accelerations are
those of Newton and Euler, limits and dry friction left out.

Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, section 3.2; the integration by SciPy's DOP853
(Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.5).
"""

from dataclasses import dataclass

import numpy as np

from harness.scene.importers.poses import Array, Pose, screw
from harness.scene.parity.facts import FIXED, RobotFacts

__all__ = ["Configuration", "Dynamics", "RTOL", "after", "dynamics", "motion_size", "passive"]

_SIZE = {"revolute": 1, "prismatic": 1, "ball": 3, "free": 6}
RTOL = 1e-9
"""Relative tolerance of the integration, ten thousand times below the tolerance that differences are judged by."""
MOST = 6000
"""Evaluations in a second beyond which a motion is too stiff or too fast to be followed here."""


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


def first_rates(robot: RobotFacts) -> list[int]:
    """The first rate of each joint, and the number of all."""
    return [0, *np.cumsum([_SIZE[joint.kind] for joint in robot.joints]).tolist()]


def dynamics(robot: RobotFacts, at: Configuration, gravity: Array) -> Dynamics:
    """Inertia and bias forces at a configuration with rates."""
    starts = first_rates(robot)
    n = starts[-1]
    M, bias = np.zeros((n, n)), np.zeros(n)
    still = (Pose(np.eye(3), np.zeros(3)), np.zeros((6, n)), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3))
    states = {FIXED: still}
    for k, joint in enumerate(robot.joints):
        X, J, w, v, dw, dv = states[joint.parent]
        here, J = slice(starts[k], starts[k + 1]), J.copy()
        rate = at.rates[here]
        if joint.kind in ("revolute", "prismatic"):
            slides = joint.kind == "prismatic"
            axis = X.R @ joint.axis
            S_w, S_v = (
                (np.zeros((3, 1)), axis[:, None]) if slides else (axis[:, None], np.cross(X.of(joint.anchor), axis)[:, None])
            )
            step = screw(
                joint.axis / np.linalg.norm(joint.axis), joint.anchor, 0.0 if slides else at.q[k], at.q[k] if slides else 0.0
            )
        else:
            turned = at.turned.get(k)
            step = Pose(np.eye(3), np.zeros(3)) if turned is None else turned
            origin = X.of(step.of(joint.anchor))
            S_w, S_v = X.R, np.cross(origin, X.R.T).T
            if joint.kind == "free":
                S_w, S_v = np.hstack([S_w, np.zeros((3, 3))]), np.hstack([S_v, X.R])
        own_w, own_v = S_w @ rate, S_v @ rate
        dw, dv = dw + np.cross(w, own_w), dv + np.cross(w, own_v) + np.cross(v, own_w)
        if joint.kind == "free":
            dv = dv + np.cross(X.R @ rate[3:], own_w)  # its own origin moves on, and with it the point that it turns about
        w, v, X = w + own_w, v + own_v, X @ step
        J[:3, here], J[3:, here] = S_w, S_v
        states[joint.name] = (X, J, w, v, dw, dv)
        solid = robot.masses.get(joint.name)
        if solid is None or solid.mass <= 0:
            continue
        centre, inertia = X.of(solid.centre), X.R @ solid.inertia @ X.R.T
        J_v = J[3:] + np.cross(J[:3].T, centre).T
        acceleration = dv + np.cross(dw, centre) + np.cross(w, v + np.cross(w, centre)) - gravity
        M += solid.mass * J_v.T @ J_v + J[:3].T @ inertia @ J[:3]
        bias += solid.mass * J_v.T @ acceleration + J[:3].T @ (inertia @ dw + np.cross(w, inertia @ w))
    return Dynamics(M, bias)


def passive(robot: RobotFacts, at: Configuration, gravity: Array) -> tuple[Array, Array]:
    """Mass matrix with armature, and the forces that decelerate: bias, dampers and springs; M qdd = -forces."""
    terms, starts = dynamics(robot, at, gravity), first_rates(robot)
    M, forces = terms.M, terms.bias.copy()
    for k, joint in enumerate(robot.joints):
        here = np.arange(starts[k], starts[k + 1])
        M[here, here] += joint.armature
        forces[here] += joint.damping * at.rates[here]
        if joint.kind in ("revolute", "prismatic"):
            forces[here] += joint.stiffness * (at.q[k] - joint.rest)
    return M, forces


class _Stiff(Exception):
    """The motion takes more evaluations than are allowed."""


def after(robot: RobotFacts, start: Configuration, gravity: Array, duration: float = 1.0) -> Configuration | None:
    """The passive motion's end; None where it is too stiff to be followed or a coordinate has no inertia."""
    from scipy.integrate import solve_ivp

    turning = [k for k, joint in enumerate(robot.joints) if joint.kind in ("ball", "free")]
    count, calls = len(robot.joints), 0

    def unpacked(y: Array) -> Configuration:
        turned = {}
        for number, k in enumerate(turning):
            raw = y[count + 12 * number : count + 12 * number + 12]
            R, o = raw[:9].reshape(3, 3), raw[9:]
            turned[k] = Pose(R, o - R @ robot.joints[k].anchor)
        return Configuration(y[:count], turned, y[count + 12 * len(turning) :])

    def slope(_time: float, y: Array) -> Array:
        nonlocal calls
        calls += 1
        if calls > MOST or not np.isfinite(y).all():
            raise _Stiff
        at = unpacked(y)
        M, forces = passive(robot, at, gravity)
        starts, dq, more = first_rates(robot), np.zeros(count), []
        for k, joint in enumerate(robot.joints):
            rate = at.rates[starts[k] : starts[k + 1]]
            if k in at.turned:
                w, v = rate[:3], rate[3:] if joint.kind == "free" else np.zeros(3)
                more += [np.cross(w, at.turned[k].R.T).T.ravel(), v]
            else:
                dq[k] = rate[0]
        return np.concatenate([dq, *more, np.linalg.solve(M, -forces)])

    poses = [start.turned.get(k, Pose(np.eye(3), np.zeros(3))) for k in turning]
    y0 = [start.q]
    for k, X in zip(turning, poses, strict=True):
        y0 += [X.R.ravel(), X.of(robot.joints[k].anchor)]
    try:
        end = solve_ivp(
            slope, (0.0, duration), np.concatenate([*y0, start.rates]), method="DOP853", rtol=RTOL, atol=RTOL, t_eval=[duration]
        )
    except (_Stiff, np.linalg.LinAlgError):
        return None
    return unpacked(end.y[:, -1]) if end.success else None


def motion_size(robot: RobotFacts, a: Configuration, b: Configuration) -> list[float]:
    """How far two configurations are apart, a number a joint: rad, m for slides, the angle of the turn for the others."""
    sizes = []
    for k, joint in enumerate(robot.joints):
        if joint.kind in ("revolute", "prismatic"):
            sizes.append(abs(float(a.q[k] - b.q[k])))
        else:
            sine = np.linalg.norm(a.turned[k].R - b.turned[k].R) / np.sqrt(8)
            sizes.append(2 * float(np.arcsin(min(1.0, sine))))
    return sizes
