"""What MuJoCo holds of joints: coordinates and rates as they stand, reactions by its recursive Newton-Euler sweep."""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.vendor import flag
from plumbline.adapters.mujoco.world import World
from plumbline.harness.scene import Prismatic, Revolute
from plumbline.harness.trajectory.joint_states import JointStates


class JointReader:
    """Reads the joints of a world; reactions are worked out on a copy of its state, which the world does not notice."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._scratch: Any = None

    def read(self) -> JointStates:
        """Coordinates, rates and reactions of native joints at this instant; those that close loops are left open."""
        world, m = self._world, self._world.model
        d = self._settled()
        states = JointStates.unknown(world.scene)
        for k, joint in enumerate(world.scene.joints):
            if joint.name not in world.indices.hung:
                continue
            hung = world.indices.hung[joint.name]
            body = world.indices.body[hung.body]
            native = hung.native
            if isinstance(joint, Revolute | Prismatic):
                states.coordinate[k] = d.qpos[m.jnt_qposadr[native]]
                states.rate[k] = d.qvel[m.jnt_dofadr[native]]
            # cfrc_int: torque and force by the body above, about the centre of mass of the whole tree.
            torque, force = d.cfrc_int[body, :3], d.cfrc_int[body, 3:]
            child = world.indices.body[world.scene.index(joint.child)]
            if hung.anchor_M is not None:
                anchor = d.xpos[child] + d.xmat[child].reshape(3, 3) @ hung.anchor_M
            else:
                # Where a joint stands MuJoCo tells before it moves: what slides takes the child's anchor along.
                slid = states.coordinate[k] - m.qpos0[m.jnt_qposadr[native]] if isinstance(joint, Prismatic) else 0.0
                anchor = d.xanchor[native] + (0.0 if hung.turned else slid) * d.xaxis[native]
            torque = torque + np.cross(d.subtree_com[m.body_rootid[body]] - anchor, force)
            states.reaction[k] = np.concatenate((force, torque)) * (-1.0 if hung.turned else 1.0)
        return states

    def _settled(self) -> Any:
        """A copy of the state with all that follows from it worked out."""
        mj, m = self._world.mj, self._world.model
        if self._scratch is None:
            self._scratch = mj.MjData(m)
        kind = flag(mj, "mjtState", "mjSTATE_INTEGRATION")
        held = np.empty(mj.mj_stateSize(m, kind))
        mj.mj_getState(m, self._world.state, held, kind)
        mj.mj_setState(m, self._scratch, held, kind)
        mj.mj_forward(m, self._scratch)
        mj.mj_rnePostConstraint(m, self._scratch)
        return self._scratch
