"""A tree of joints as one multibody in reduced coordinates, and what its joints are told."""

from typing import Any, assert_never

import numpy as np

from plumbline.adapters.bullet.actuated import actuated
from plumbline.adapters.bullet.bodies import check_joined, put_base, tell_body, tell_multibody
from plumbline.adapters.bullet.bodies_made import Assembly
from plumbline.adapters.bullet.frames import minus, xyzw
from plumbline.adapters.bullet.plan import Plan
from plumbline.adapters.bullet.shapes import collision_shape
from plumbline.adapters.bullet.trees import Link, Tree, joint_axis
from plumbline.adapters.bullet.vendor import LIFTED
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.carried_laws import refuse_speed_limit
from plumbline.harness.adapter.rotations import IDENTITY, conjugate
from plumbline.harness.scene import Ball, Distance, Fixed, Prismatic, Quaternion, Revolute, Vector3, multiply, rotate

MOST_COORDINATES = 128
"""Of one multibody, base included (MAX_DEGREE_OF_FREEDOM of SharedMemoryCommands.h); beyond, states are cut in silence."""
_KINDS = {"fixed": "JOINT_FIXED", "ball": "JOINT_SPHERICAL", "revolute": "JOINT_REVOLUTE", "prismatic": "JOINT_PRISMATIC"}
"""Types of joints to the names that pybullet has for them."""


def put_multibody(plan: Plan, made: Assembly, tree: Tree) -> None:
    """A tree of joints as one multibody: link frames lie at the anchors, turned like the child's I."""
    scene, bullet = plan.scene, made.port.bullet
    for place in (tree.base, *(link.place for link in tree.links)):
        if place is not None:
            check_joined(plan, made, place)
    coordinates = 7 + sum({"fixed": 0, "ball": 4}.get(link.joint.type, 1) for link in tree.links)
    if coordinates > MOST_COORDINATES:
        raise Unsupported(
            f"a tree of {len(tree.links)} joints", f"pybullet keeps {MOST_COORDINATES} coordinates of a multibody"
        )
    base = ((0.0, 0.0, 0.0), IDENTITY) if tree.base is None else (scene.bodies[tree.base].p_WB, plan.q_WI(tree.base))
    frames = [_frame(plan, link) for link in tree.links]
    above = [base if link.parent < 0 else frames[link.parent] for link in tree.links]
    rows = [_row(plan, made, *each) for each in zip(tree.links, frames, above, strict=True)]
    shapes = [] if tree.base is None else plan.placed(tree.base, (0.0, 0.0, 0.0))
    number = made.port.call(
        "createMultiBody",
        baseMass=0.0 if tree.base is None else plan.mass(tree.base),
        baseCollisionShapeIndex=collision_shape(made.port, shapes),
        baseVisualShapeIndex=made.unseen,
        basePosition=base[0],
        baseOrientation=xyzw(base[1]),
        flags=bullet.URDF_USE_SELF_COLLISION | bullet.URDF_USE_SELF_COLLISION_INCLUDE_PARENT,
        **{name: [row[name] for row in rows] for name in rows[0]},
    )
    if number < 0:
        raise Unsupported(f"a tree of {len(tree.links)} joints", "pybullet could not make a multibody of it")
    if tree.base is not None:
        put_base(plan, made, number, tree.base, maximal=False)
    else:
        tell_multibody(plan, made, number, None, maximal=False)
    made.linked[number] = tuple(link.place for link in tree.links)
    for k, link in enumerate(tree.links):
        made.address[number, k] = link.place
        made.hung[link.joint.name] = number, k
        tell_body(plan, made, number, k, link.place, maximal=False)
        _tell_joint(plan, made, number, k, link, tree)
    actuation = actuated(plan, made, tree)
    if actuation is not None:
        made.actuators[number] = actuation


def _frame(plan: Plan, link: Link) -> tuple[Vector3, Quaternion]:
    """p_WL and q_WL of a link's frame L, which lies at the anchor and is turned like the body's I."""
    return getattr(link.joint, "anchor_W", plan.scene.bodies[link.place].p_WB), plan.q_WI(link.place)


def _row(
    plan: Plan, made: Assembly, link: Link, frame: tuple[Vector3, Quaternion], above: tuple[Vector3, Quaternion]
) -> dict[str, Any]:
    """The arguments of createMultiBody for a link, from its frame and its parent's."""
    body, (p_WL, q_WI), (p_WP, q_WP) = plan.scene.bodies[link.place], frame, above
    p_LI = rotate(conjugate(q_WI), minus(body.p_WB, p_WL))
    return {
        "linkMasses": body.mass,
        "linkCollisionShapeIndices": collision_shape(made.port, plan.placed(link.place, p_LI)),
        "linkVisualShapeIndices": made.unseen,
        "linkPositions": rotate(conjugate(q_WP), minus(p_WL, p_WP)),
        "linkOrientations": xyzw(multiply(conjugate(q_WP), q_WI)),
        "linkInertialFramePositions": p_LI,
        "linkInertialFrameOrientations": xyzw(IDENTITY),
        "linkParentIndices": link.parent + 1,
        "linkJointTypes": getattr(made.port.bullet, _KINDS[link.joint.type]),
        "linkJointAxis": rotate(conjugate(q_WI), joint_axis(link.joint, body.name)),
    }


def _tell_joint(plan: Plan, made: Assembly, number: int, k: int, link: Link, tree: Tree) -> None:
    """Motor off, limits on, and the rate that the bodies' velocities mean."""
    bullet, joint = made.port.bullet, link.joint
    child = plan.scene.bodies[link.place]
    above = tree.base if link.parent < 0 else tree.links[link.parent].place
    parent = None if above is None else plan.scene.bodies[above]
    v_P, w_P, p_P = ((0.0,) * 3, (0.0,) * 3, child.p_WB) if parent is None else (*parent.velocity_at_start, parent.p_WB)
    w_rel = np.subtract(child.w_WB, w_P)
    axis = np.asarray(joint_axis(joint, child.name))
    match joint:
        case Revolute() | Prismatic():
            rate = float(axis @ w_rel)
            if isinstance(joint, Prismatic):
                carried = np.asarray(v_P) + np.cross(w_P, np.subtract(child.p_WB, p_P))
                rate = float(axis @ (np.asarray(child.v_WB) - carried))
            refuse_speed_limit(
                joint, "pybullet's maxJointVelocity cuts every coordinate of a multibody after the step, without a reaction"
            )
            # A motor that asks for no velocity, with a bounded force, is Coulomb's law: it holds, or brakes by all of it.
            made.port.call("setJointMotorControl2", number, k, bullet.VELOCITY_CONTROL, force=joint.friction_loss or 0.0)
            made.port.call("resetJointState", number, k, 0.0, rate)
            made.coordinates[joint.name] = number, k, joint.position
            if joint.limits is not None:
                lower = -1e12 if joint.limits.lower is None else joint.limits.lower - joint.position
                upper = 1e12 if joint.limits.upper is None else joint.limits.upper - joint.position
                made.port.call(
                    "changeDynamics", number, k, jointLowerLimit=lower, jointUpperLimit=upper, jointLimitForce=LIFTED
                )
        case Ball():
            still = {"targetPosition": [0.0, 0.0, 0.0, 1.0], "targetVelocity": [0.0] * 3, "force": [0.0] * 3}
            made.port.call(
                "setJointMotorControlMultiDof",
                number,
                k,
                bullet.POSITION_CONTROL,
                positionGain=0.0,
                velocityGain=0.0,
                **still,
            )
            rate_L = rotate(conjugate(plan.q_WI(link.place)), tuple(w_rel.tolist()))
            made.port.call("resetJointStateMultiDof", number, k, [0.0, 0.0, 0.0, 1.0], rate_L)
        case Fixed() | Distance():
            pass
        case _:
            assert_never(joint)
