"""Kinematic bodies: where they are, and what hangs on them when their velocity changes."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.adapters.newton.vendor import view
from plumbline.harness.scene import axis_angle, multiply
from plumbline.harness.trajectory import Floats


@dataclass(slots=True)
class Led:
    """A kinematic body, and how it moves until told otherwise.

    Terms: number: among the scene's bodies. row: Newton's number. at, rate_at: where its free joint's numbers begin. p, q, v,
    w: in W [m, m/s, rad/s], q = (w, x, y, z).
    """

    number: int
    row: int
    at: int
    rate_at: int
    p: Floats
    q: Floats
    v: Floats
    w: Floats


def turned(w: Floats, h: float, q: Floats) -> Floats:
    """A quaternion (w, x, y, z) after h [s] at the angular velocity w [rad/s]."""
    speed = float(np.linalg.norm(w))
    if speed == 0.0:
        return q
    x, y, z = (w / speed).tolist()
    a, b, c, d = q.tolist()
    return np.array(multiply(axis_angle((x, y, z), speed * h), (a, b, c, d)))


def answer(newton: Any, model: Any, state: Any, rates: Floats, before: Floats) -> None:
    """What hangs on led bodies keeps its momenta along its own coordinates, and not its rates, where those change theirs.

    With u = (r, c) of a tree, r told and c not: M_cc c' = M_cc c - M_cr (r' - r).
    Args: rates (n,): all rates, those of led bodies new; the others are written. before: all rates as they were.
    """
    inertia = view(newton.eval_mass_matrix(model, state)).astype(np.float64)
    starts, joints = view(model.articulation_start), view(model.joint_qd_start)
    for tree in range(model.articulation_count):
        first = int(joints[starts[tree]])
        last = int(joints[starts[tree + 1]]) if starts[tree + 1] < model.joint_count else model.joint_dof_count
        change = (rates[first:last] - before[first:last]).astype(np.float64)
        led = 6
        if last - first <= led or not change[:led].any():
            continue
        M = inertia[tree, : last - first, : last - first]
        rates[first + led : last] -= np.linalg.solve(M[led:, led:], M[led:, :led] @ change[:led]).astype(np.float32)
