"""Velocities of kinematic bodies, which are free ones that nothing moves, told to a running model."""

from collections.abc import Mapping

import numpy as np

from plumbline.adapters.mujoco.world import World
from plumbline.harness.adapter.rotations import matrix
from plumbline.harness.scene import Vector3


def prescribe(world: World, velocities: Mapping[str, tuple[Vector3, Vector3]]) -> None:
    """Give kinematic bodies v_WB [m/s] and w_WB [rad/s].

    What hangs on such a body keeps its own momentum and not its joint rates: it answers to the blow on the coordinates above it
    that makes the change, q' + M^-1 (armature of these coordinates) (change). The answer of these is right but for 1e-12.
    """
    m, d = world.model, world.state
    blow, aims = np.zeros(m.nv), list[tuple[int, np.ndarray]]()
    for name, (v, w) in velocities.items():
        body = world.indices.body[world.scene.index(name)]
        joint = m.body_jntadr[body]
        place, at = m.jnt_qposadr[joint], m.jnt_dofadr[joint]
        # A free joint's angular velocity is in its body's frame.
        aim = np.concatenate((v, matrix(d.qpos[place + 3 : place + 7]).T @ np.asarray(w)))
        aims.append((at, aim))
        if (m.body_parentid[1:] == body).any():
            blow[at : at + 6] = m.dof_armature[at : at + 6] * (aim - d.qvel[at : at + 6])
    if blow.any():
        mj, answer = world.mj, np.zeros(m.nv)
        mj.mj_kinematics(m, d)
        mj.mj_comPos(m, d)
        mj.mj_makeM(m, d)
        mj.mj_factorM(m, d)
        mj.mj_solveM(m, d, answer[None], blow[None])
        d.qvel += answer
    for at, aim in aims:
        d.qvel[at : at + 6] = aim
