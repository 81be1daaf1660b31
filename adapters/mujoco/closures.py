"""Joints that are no native ones: equality constraints that close loops, and tendons that keep or bound a distance."""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.limits import bounds_of
from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.softness import hold, stop
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.adapters.mujoco.vendor import linear_law, set_equality
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.carried_laws import carried, followed
from plumbline.harness.scene import WORLD, Coupling, Distance, Fixed, Joint, Prismatic, Revolute


def close_loop(plan: Plan, draft: Draft, joint: Joint) -> None:
    """An equality constraint for a joint that closes a loop. Raises: Unsupported."""
    assert not isinstance(joint, Distance)
    extra = next(iter(carried(joint)), "another joint coupled to it" if joint.name in followed(plan.scene) else None)
    if isinstance(joint, Prismatic) or extra is not None:
        what = f"joint '{joint.name}': a {joint.type} joint{f' with {extra}' if extra else ''} that closes a loop"
        raise Unsupported(
            what, "MuJoCo closes loops by points and welds; every other joint of this loop has a coordinate of its own too"
        )
    kinds, k = draft.mj.mjtEq, plan.index[joint.child]
    if isinstance(joint, Fixed):
        made = _add_equality(plan, draft, joint, kinds.mjEQ_WELD)
        # Anchor, then a relative pose of zeros (read off the initial one), then the weight of rotation [m].
        set_equality(made, [*([0.0] * 10), 1.0])
        return
    points = [np.array(joint.anchor_W)]
    if isinstance(joint, Revolute):
        arm = max(float(np.linalg.norm(points[0] - plan.p[k])), 1e-3)
        points = [points[0] + side * arm * np.array(joint.axis_W) for side in (-1.0, 1.0)]
    for point in points:
        made = _add_equality(plan, draft, joint, kinds.mjEQ_CONNECT)
        set_equality(made, plan.R_WM[k].T @ (point - plan.p[k]))


def _add_equality(plan: Plan, draft: Draft, joint: Joint, kind: Any) -> Any:
    """The constraint between the child and the parent; the child is never the world."""
    parent = "world" if joint.parent == WORLD else f"b{plan.index[joint.parent]}"
    made = draft.spec.add_equality(
        type=kind, objtype=draft.mj.mjtObj.mjOBJ_BODY, name1=f"b{plan.index[joint.child]}", name2=parent
    )
    hold(made, plan.options, plan.h)
    return made


def couple(plan: Plan, draft: Draft, joint: str, coupling: Coupling) -> None:
    """An equality of two coordinates; MuJoCo counts both from where they start, so that the offset is in neither."""
    native = {link.joint.name: f"f{link.body}" for link in plan.links if link.joint is not None}
    made = draft.spec.add_equality(
        type=draft.mj.mjtEq.mjEQ_JOINT, objtype=draft.mj.mjtObj.mjOBJ_JOINT, name1=native[joint], name2=native[coupling.joint]
    )
    set_equality(made, [0.0, coupling.ratio])
    hold(made, plan.options, plan.h)


def keep_distance(plan: Plan, draft: Draft, joint: Distance) -> None:
    """A tendon between two sites: limited, sprung, or held at its length. Raises: Unsupported."""
    mj = draft.mj
    ends = ((joint.parent, joint.anchor_W, "a"), (joint.child, joint.child_anchor_W, "b"))
    tendon = draft.spec.add_tendon(name=f"t.{joint.name}")
    for name, anchor, end in ends:
        point, node = np.array(anchor), draft.spec.worldbody
        if name != WORLD:
            k = plan.index[name]
            point, node = plan.R_WM[k].T @ (point - plan.p[k]), draft.bodies[k]
        node.add_site(name=f"s.{joint.name}.{end}", pos=point)
        tendon.wrap_site(f"s.{joint.name}.{end}")
    if joint.spring is not None:
        tendon.stiffness = linear_law(tendon.stiffness, joint.spring.stiffness)
        tendon.damping = linear_law(tendon.damping, joint.spring.damping)
        tendon.springlength = [joint.spring.rest, joint.spring.rest]
    bounds = bounds_of(joint)
    if bounds is not None:
        tendon.limited, tendon.range = mj.mjtLimited.mjLIMITED_TRUE, bounds
        stop(tendon, plan.options, plan.h)
    elif joint.spring is None:
        held = draft.spec.add_equality(type=mj.mjtEq.mjEQ_TENDON, name1=f"t.{joint.name}")
        held.objtype = mj.mjtObj.mjOBJ_TENDON
        set_equality(held, [])
        hold(held, plan.options, plan.h)
