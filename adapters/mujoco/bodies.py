"""Bodies in their trees, each with its native joint."""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.limits import bounds_of
from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.softness import hold_dry, stop
from plumbline.adapters.mujoco.trees import Link
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.adapters.mujoco.vendor import linear_law
from plumbline.harness.adapter.carried_laws import refuse_speed_limit
from plumbline.harness.adapter.rotations import conjugate
from plumbline.harness.scene import Ball, Distance, Fixed, Joint, Revolute, multiply

KINEMATIC_ARMATURE = 1e12
"""Inertia of a kinematic body over that of all movable ones: a force then changes its velocity by rounding."""


def add_body(plan: Plan, draft: Draft, link: Link) -> None:
    """One body with its native joints, its frame M against that of the body above; one without mass is its joint alone, in
    the body behind it."""
    body, k = plan.scene.bodies[link.body], link.body
    if body.massless:
        return
    p_PM, q_PM = plan.p[k], plan.q_WM[k]
    above, upper = draft.spec.worldbody, plan.chains[k][0].above
    if upper >= 0:
        R_WP, q_WP = plan.R_WM[upper], plan.q_WM[upper]
        above = draft.bodies[upper]
        p_PM = R_WP.T @ (p_PM - plan.p[upper])
        q_PM = np.array(multiply(conjugate(tuple(q_WP)), tuple(q_PM)))
    node = above.add_body(name=f"b{k}", pos=p_PM, quat=q_PM)
    node.explicitinertial, node.mass, node.inertia = True, body.mass, plan.moments[k]
    # Left open, the inertial frame is not M: 4.0.0 takes the body's place in its parent for it.
    node.ipos, node.iquat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    draft.bodies[k] = node
    if plan.prescribed(body):
        movable = sum(b.mass for b in plan.scene.bodies if b.movable) or 1.0
        reach = max([1.0, *(float(np.linalg.norm(p - plan.p[k])) for p in plan.p)])
        node.inertia, node.mass, node.gravcomp = [1.0, 1.0, 1.0], 1.0, 1.0
        node.add_joint(
            name=f"f{k}", type=draft.mj.mjtJoint.mjJNT_FREE, armature=KINEMATIC_ARMATURE * max(1.0, movable) * reach**2
        )
    elif body.movable and link.joint is None:
        node.add_freejoint(name=f"f{k}")
    else:
        for each in plan.chains[k]:
            if each.joint is not None:
                _add_joint(plan, draft, node, k, each, each.joint)


def _add_joint(plan: Plan, draft: Draft, node: Any, k: int, link: Link, joint: Joint) -> None:
    """A native joint by which body k hangs below another, with its limits and its spring; a fixed one is none."""
    kinds = draft.mj.mjtJoint
    if isinstance(joint, Fixed):
        return
    assert not isinstance(joint, Distance)
    anchor = plan.R_WM[k].T @ (np.array(joint.anchor_W) - plan.p[k])
    if isinstance(joint, Ball):
        node.add_joint(name=f"f{link.body}", type=kinds.mjJNT_BALL, pos=anchor)
        return
    refuse_speed_limit(joint, "MuJoCo bounds positions and forces of joints, not their rates")
    kind = kinds.mjJNT_HINGE if isinstance(joint, Revolute) else kinds.mjJNT_SLIDE
    axis = plan.R_WM[k].T @ np.array(joint.axis_W) * (-1.0 if link.turned else 1.0)
    made = node.add_joint(name=f"f{link.body}", type=kind, pos=anchor, axis=axis, ref=joint.position)
    bounds = bounds_of(joint)
    if bounds is not None:
        made.limited, made.range = draft.mj.mjtLimited.mjLIMITED_TRUE, bounds
        stop(made, plan.options, plan.h)
    if joint.spring is not None:
        made.stiffness = linear_law(made.stiffness, joint.spring.stiffness)
        made.damping = linear_law(made.damping, joint.spring.damping)
        made.springref = joint.spring.rest
    if joint.armature:
        made.armature = joint.armature
    if joint.friction_loss:
        made.frictionloss = joint.friction_loss
        hold_dry(made, plan.options, plan.h)
