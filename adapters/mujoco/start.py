"""The initial state: velocities of the coordinates from those of the bodies, proven by reading them back."""

import numpy as np

from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.adapters.mujoco.vendor import fatal, flag
from plumbline.adapters.mujoco.world import World
from plumbline.harness.adapter import Simulation, Unsupported
from plumbline.harness.scene import Ball, Distance, Fixed, Revolute
from plumbline.harness.trajectory import State


def start(plan: Plan, draft: Draft, world: World) -> None:
    """Give the coordinates the velocities that those of the bodies mean, and the drives their targets. Raises: Unsupported."""
    model, d, bodies = world.model, world.state, plan.scene.bodies
    for name, actuator in draft.drives.items():
        d.ctrl[actuator] = next(
            j.drive.target for j in plan.joints if j.name == name and not isinstance(j, Fixed | Ball | Distance) and j.drive
        )
    for link in plan.links:
        body, k, joint = bodies[link.body], link.body, link.joint
        if isinstance(joint, Fixed) or (joint is None and not body.movable and not plan.prescribed(body)):
            continue
        adr = model.joint(f"f{k}").dofadr[0]
        v, w = map(np.array, body.velocity_at_start)
        if joint is None:
            d.qvel[adr : adr + 3], d.qvel[adr + 3 : adr + 6] = v, plan.R_WM[k].T @ w
            continue
        assert not isinstance(joint, Distance)
        above_v, above_w = np.zeros(3), np.zeros(3)
        if link.above >= 0:
            above = bodies[link.above]
            above_v, above_w = map(np.array, above.velocity_at_start)
            above_v = above_v + np.cross(above_w, np.array(joint.anchor_W) - plan.p[link.above])
        if isinstance(joint, Ball):
            d.qvel[adr : adr + 3] = plan.R_WM[k].T @ (w - above_w)
            continue
        axis = np.array(joint.axis_W) * (-1.0 if link.turned else 1.0)
        at_anchor = v + np.cross(w, np.array(joint.anchor_W) - plan.p[k])
        d.qvel[adr] = axis @ (w - above_w) if isinstance(joint, Revolute) else axis @ (at_anchor - above_v)
    world.mj.mj_forward(model, d)
    if d.warning.number[fatal(world.mj)].any():
        raise Unsupported("initial state", "a coordinate or velocity lies above MuJoCo's bound of 1e10")


def check_start(plan: Plan, world: World, simulation: Simulation) -> None:
    """Read the state back: the joints must let the bodies move as the scene says. Raises: Unsupported."""
    asked, got = State.initial(plan.scene), State.empty(len(plan.scene.bodies))
    simulation.state(got)
    speed = 1e-9 + 1e-7 * max(float(np.abs(asked.v_WB).max()), float(np.abs(asked.w_WB).max()))
    why = "generalised coordinates hold no velocity that a joint forbids"
    for k, body in enumerate(plan.scene.bodies):
        gap = max(float(np.abs(asked.v_WB[k] - got.v_WB[k]).max()), float(np.abs(asked.w_WB[k] - got.w_WB[k]).max()))
        if gap > speed:
            motion = f"v_WB {body.v_WB}, w_WB {body.w_WB} against its joints, which allow {got.v_WB[k]}, {got.w_WB[k]}"
            raise Unsupported(f"body '{body.name}': {motion}", why)
    d = world.state
    held = d.efc_type == flag(world.mj, "mjtConstraint", "mjCNSTR_EQUALITY")
    if held.any() and float(np.abs(d.efc_vel[held]).max()) > speed:
        raise Unsupported(
            f"velocities that open a loop or stretch a rod by {float(np.abs(d.efc_vel[held]).max()):.3g} m/s", why
        )
