"""Joint-space dynamics of a scene's tree, from its bodies and joints alone: products of exponentials, in W at time 0.

X_WB(q) = exp(S_1 (q_1 - q_1(0))) ... exp(S_n (q_n - q_n(0))) X_WB(0), S_i the line of joint i at time 0. Source: Murray, Li,
Sastry, A Mathematical Introduction to Robotic Manipulation, section 3.2; accelerations by Newton and Euler in W.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from plumbline.harness.scene import WORLD, Prismatic, Revolute, Scene


@dataclass
class JointSpace:
    """A tree of hinges and slides. With `floating` the first movable body has six coordinates more, first, in its own axes."""

    scene: Scene
    floating: str | None = None
    frame: tuple[np.ndarray, np.ndarray] = (np.eye(3), np.zeros(3))

    def __post_init__(self) -> None:
        self.joints = [j for j in self.scene.joints if isinstance(j, Revolute | Prismatic)]
        assert len(self.joints) == len(self.scene.joints)
        self.by_child = {j.child: j for j in self.joints}
        self.movable = [b for b in self.scene.bodies if b.movable]
        self.first = 6 if self.floating else 0
        self.size = self.first + len(self.joints)

    def chain(self, body: str) -> list:
        """The joints between the world and a body, from the world on."""
        found = []
        while body in self.by_child:
            found.append(self.by_child[body])
            body = self.by_child[body].parent
        static = {b.name for b in self.scene.bodies if not b.movable}
        assert body in ({WORLD, *static} if not self.floating else {self.floating})
        return found[::-1]

    def at(self, q: np.ndarray, qd: np.ndarray, base: tuple[np.ndarray, np.ndarray] | None = None) -> Any:
        """Mass matrix (n, n), bias forces (n,) with gravity, and of each movable body its Jacobian (6, n) at its centre.

        Args: q, qd: the joints' coordinates, and rates of all; base: where the floating body's frame went, (R, p).
        """
        M, h, jacobians = np.zeros((self.size, self.size)), np.zeros(self.size), {}
        for body in self.movable:
            R, p = (np.eye(3), np.zeros(3)) if base is None else base
            w, v0, dw, dv0 = (np.zeros(3) for _ in range(4))
            columns = np.zeros((6, self.size))
            if self.floating:
                R0, p0 = self.frame
                Rb, pb = R @ R0, R @ p0 + p
                for i in range(3):
                    columns[3:, i] = Rb[:, i]
                    columns[:3, 3 + i] = Rb[:, i]
                    columns[3:, 3 + i] = np.cross(pb, Rb[:, i])
                w, v0 = columns[:3, :6] @ qd[:6], columns[3:, :6] @ qd[:6]
            for joint in self.chain(body.name):
                k = self.joints.index(joint)
                way, rate = q[k] - joint.position, qd[self.first + k]
                a0, c0 = np.array(joint.axis_W), np.array(joint.anchor_W)
                axis, anchor = R @ a0, R @ c0 + p
                slides = isinstance(joint, Prismatic)
                S_w, S_v = (np.zeros(3), axis) if slides else (axis, np.cross(anchor, axis))
                dw = dw + np.cross(w, S_w) * rate
                dv0 = dv0 + (np.cross(w, S_v) + np.cross(v0, S_w)) * rate
                w, v0 = w + S_w * rate, v0 + S_v * rate
                columns[:3, self.first + k], columns[3:, self.first + k] = S_w, S_v
                turn = np.eye(3) if slides else Rotation.from_rotvec(a0 * way).as_matrix()
                shift = a0 * way if slides else c0 - turn @ c0
                R, p = R @ turn, R @ shift + p
            R_WB = R @ Rotation.from_quat(body.q_WB, scalar_first=True).as_matrix()
            centre = R @ np.array(body.p_WB) + p
            J = columns.copy()
            J[3:] += np.cross(columns[:3].T, centre).T
            inertia = R_WB @ np.array(body.inertia) @ R_WB.T
            M += body.mass * J[3:].T @ J[3:] + J[:3].T @ inertia @ J[:3]
            v_c = v0 + np.cross(w, centre)
            a_c = dv0 + np.cross(dw, centre) + np.cross(w, v_c)
            h += body.mass * J[3:].T @ (a_c - np.array(self.scene.gravity))
            h += J[:3].T @ (inertia @ dw + np.cross(w, inertia @ w))
            jacobians[body.name] = (J, centre, R_WB, a_c, dw)
        for k, joint in enumerate(self.joints, self.first):
            M[k, k] += joint.armature or 0.0
        return M, h, jacobians
