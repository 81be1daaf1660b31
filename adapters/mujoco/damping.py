"""Damping of bodies as damping of coordinates."""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.plan import Plan
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Effect, Fixed, Prismatic, Revolute


def dampen(plan: Plan, model: Any) -> None:
    """Q = -c J^T (m v, I w) as damping of coordinates, where a diagonal of coefficients can say it. Raises: Unsupported."""
    for link in plan.links:
        body, k, joint = plan.scene.bodies[link.body], link.body, link.joint
        linear = body.linear_damping if Effect.LINEAR_DAMPING in plan.effects else 0.0
        angular = body.angular_damping if Effect.ANGULAR_DAMPING in plan.effects else 0.0
        if not body.movable or (linear == 0 and angular == 0):
            continue
        if joint is None:
            adr = model.joint(f"f{k}").dofadr[0]
            model.dof_damping[adr : adr + 3] += linear * body.mass
            model.dof_damping[adr + 3 : adr + 6] += angular * np.array(plan.moments[k])
            continue
        grounded = link.above < 0 or (not (above := plan.scene.bodies[link.above]).movable and not plan.prescribed(above))
        if grounded and isinstance(joint, Fixed):
            continue
        if not grounded or not isinstance(joint, Revolute | Prismatic):
            raise Unsupported(
                f"body '{body.name}': damping of a body held by {joint.type} joint '{joint.name}'",
                "MuJoCo damps coordinates, not bodies",
            )
        adr, axis = model.joint(f"f{k}").dofadr[0], np.array(joint.axis_W)
        if isinstance(joint, Prismatic):
            model.dof_damping[adr] += linear * body.mass
        else:
            arm = np.cross(axis, plan.p[k] - np.array(joint.anchor_W))
            turn = plan.R_WM[k].T @ axis
            model.dof_damping[adr] += linear * body.mass * float(arm @ arm) + angular * float(turn**2 @ plan.moments[k])
