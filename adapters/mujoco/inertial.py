"""MuJoCo's own accelerometer and gyroscope: how they are put into the model, and how they are asked."""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.adapters.mujoco.vendor import flag
from plumbline.adapters.mujoco.world import World
from plumbline.harness.adapter.rotations import IDENTITY, conjugate, matrix
from plumbline.harness.scene import WORLD, Effect, Imu, multiply
from plumbline.harness.trajectory import Floats


def add_inertial(plan: Plan, draft: Draft) -> None:
    """Sites with MuJoCo's accelerometer and gyroscope for the inertial sensors that ask for them."""
    kinds, site = draft.mj.mjtSensor, draft.mj.mjtObj.mjOBJ_SITE
    for sensor in plan.scene.sensors:
        if not isinstance(sensor, Imu) or sensor.reading != "native":
            continue
        node, q_MB = draft.spec.worldbody, IDENTITY
        if sensor.body != WORLD:
            k = plan.index[sensor.body]
            node, q_MB = draft.bodies[k], conjugate(plan.q_BM[k])
        pose = {"pos": matrix(q_MB) @ sensor.p_BS, "quat": multiply(q_MB, sensor.q_BS)}
        node.add_site(name=f"s:{sensor.name}", **pose)
        for word, kind in (("force", kinds.mjSENS_ACCELEROMETER), ("rate", kinds.mjSENS_GYRO)):
            draft.spec.add_sensor(name=f"{word}:{sensor.name}", type=kind, objtype=site, objname=f"s:{sensor.name}")
        draft.inertial.append(sensor.name)


class Inertial:
    """The sensors of one world, asked on a copy of its data.

    `mj_step` leaves what sensors said before the step; a forward pass there would move the warm start of the next one. So the
    pass is made on a copy, under the forces, the wrench included, that the present state has been told.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._copy: Any = None

    def read(self, name: str) -> tuple[Floats, Floats]:
        """Specific force [m/s2] and angular velocity [rad/s] in S, each (3,), at this instant. Raises: ValueError."""
        mj, m, indices = self._world.mj, self._world.model, self._world.indices
        if name not in indices.inertial:
            raise ValueError(f"inertial: '{name}', expected one of {', '.join(indices.inertial) or 'none'}")
        if self._copy is None:
            self._copy = mj.MjData(m)
        kind = flag(mj, "mjtState", "mjSTATE_INTEGRATION")
        state = np.empty(mj.mj_stateSize(m, kind))
        mj.mj_getState(m, self._world.state, state, kind)
        mj.mj_setState(m, self._copy, state, kind)
        without = m.opt.disableflags
        needed = flag(mj, "mjtDisableBit", "mjDSBL_SENSOR")
        if Effect.GRAVITY not in self._world.scene.narrow:
            # Where nothing can fall the effect is left out of the steps, but what stands still feels its support.
            needed |= flag(mj, "mjtDisableBit", "mjDSBL_GRAVITY")
        m.opt.disableflags = without & ~needed
        try:
            mj.mj_forward(m, self._copy)
        finally:
            m.opt.disableflags = without
        force, rate = indices.inertial[name]
        readings = self._copy.sensordata
        return readings[force : force + 3].copy(), readings[rate : rate + 3].copy()
