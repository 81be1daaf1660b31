"""A tree of five links that branches, and the dense equations of all its bodies: what joints hold, and what bodies weigh."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from plumbline import engine

__all__ = ["branches", "joint_rows", "mass_matrix"]


def branches(held: bool, seed: int = 3) -> tuple[list[engine.Body], list[engine.Joint]]:
    """Five links on hinges, a slide and a ball, branching at the first one, turned and moving as their joints let them."""
    rng = np.random.default_rng(seed)
    above = (-1, 0, 1, 0, 3)
    axes, anchors = rng.normal(size=(5, 3)), np.zeros((5, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    v, w, p = np.zeros((5, 3)), np.zeros((5, 3)), np.zeros((5, 3))
    bodies: list[engine.Body] = []
    joints: list[engine.Joint] = []
    for k, parent in enumerate(above):
        start = p[parent] if parent >= 0 else np.zeros(3)
        anchors[k] = start + rng.normal(0, 0.2, 3)
        p[k] = anchors[k] + rng.normal(0, 0.2, 3)
        turning, sliding = rng.normal(size=3), 0.0
        kind = "free" if parent < 0 and not held else ("hinge", "hinge", "ball", "slide", "hinge")[k]
        if kind in ("hinge", "slide"):
            sliding = turning[0] if kind == "slide" else 0.0
            turning = axes[k] * turning[0] * (kind == "hinge")
        w_A, v_A, p_A = (w[parent], v[parent], p[parent]) if parent >= 0 else (np.zeros(3), np.zeros(3), np.zeros(3))
        w[k] = w_A + turning
        v[k] = v_A + np.cross(w_A, anchors[k] - p_A) + sliding * axes[k] + np.cross(w[k], p[k] - anchors[k])
        turn = Rotation.random(random_state=rng)
        bodies.append(
            engine.Body(
                name=f"link{k}", mass=rng.uniform(0.3, 2.0), inertia=np.diag(rng.uniform(0.02, 0.03, 3)), p_WB=tuple(p[k]),
                q_WB=tuple(turn.as_quat(scalar_first=True)), v_WB=tuple(v[k]), w_WB=tuple(w[k]),
            )
        )  # fmt: skip
        ends: dict[str, Any] = {
            "name": f"joint{k}",
            "parent": f"link{parent}" if parent >= 0 else engine.WORLD,
            "child": f"link{k}",
        }
        line: dict[str, Any] = {"anchor_W": tuple(anchors[k]), "axis_W": tuple(axes[k])}
        if kind == "ball":
            joints.append(engine.Ball(**ends, anchor_W=tuple(anchors[k])))
        elif kind != "free":
            joints.append((engine.Prismatic if kind == "slide" else engine.Revolute)(**ends, **line))
    return bodies, joints


def joint_rows(bodies: list[engine.Body], joints: list[engine.Joint]) -> np.ndarray:
    """What the joints hold, J (rows, 6 n) on (v, w) of all bodies, at their start."""
    number = {body.name: k for k, body in enumerate(bodies)}
    rows = []
    for joint in joints:
        for direction in np.eye(3):
            moves, turns = np.zeros(6 * len(bodies)), np.zeros(6 * len(bodies))
            for sign, name in ((-1.0, joint.parent), (1.0, joint.child)):
                if name in number:
                    k = number[name]
                    arm = np.array(joint.anchor_W if not isinstance(joint, engine.Fixed) else bodies[k].p_WB) - bodies[k].p_WB
                    moves[6 * k : 6 * k + 6] = sign * np.concatenate((direction, np.cross(arm, direction)))
                    turns[6 * k + 3 : 6 * k + 6] = sign * direction
            rows.append((joint, direction, moves, turns))
    kept = []
    for joint, direction, moves, turns in rows:
        axis = np.array(getattr(joint, "axis_W", (0.0, 0.0, 0.0)))
        # Along the axis a slide gives way; across it a hinge does not turn: both are projected out of the three directions.
        across = direction - axis * (axis @ direction)
        slides, hinges = isinstance(joint, engine.Prismatic), isinstance(joint, engine.Revolute)
        three = [row for other, _, *row in rows if other is joint]
        moves_across, turns_across = (sum(across[c] * three[c][n] for c in range(3)) for n in (0, 1))
        kept.append(moves_across if slides else moves)
        if slides or hinges:
            kept.append(turns if slides else turns_across)
    return np.array(kept)


def mass_matrix(bodies: list[engine.Body]) -> np.ndarray:
    """Of all bodies apart, (6 n, 6 n) on (v, w)."""
    total = np.zeros((6 * len(bodies), 6 * len(bodies)))
    for k, body in enumerate(bodies):
        turn = Rotation.from_quat(body.q_WB, scalar_first=True).as_matrix()
        total[6 * k : 6 * k + 3, 6 * k : 6 * k + 3] = body.mass * np.eye(3)
        total[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6] = turn @ np.array(body.inertia) @ turn.T
    return total
