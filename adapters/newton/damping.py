"""Damping of bodies as damping of coordinates, which is what MuJoCo-Warp has."""

import numpy as np

from plumbline.adapters.newton.bodies import WORLD_BODY, Bodies
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import WORLD, Body, Effect, Fixed, Joint, Prismatic, Revolute, rotation_matrix


def rates_of(bodies: Bodies, body: Body) -> tuple[float, float]:
    """Of v and of w [1/s], as far as the scene calls for them."""
    effects = bodies.scene.effects
    linear = body.linear_damping if Effect.LINEAR_DAMPING in effects else 0.0
    angular = body.angular_damping if Effect.ANGULAR_DAMPING in effects else 0.0
    return (linear, angular) if body.movable else (0.0, 0.0)


def check_solver(bodies: Bodies, solver: str) -> None:
    """Raises: Unsupported, of a damped body that XPBD would step."""
    for body in bodies.scene.bodies:
        if solver == "xpbd" and any(rates_of(bodies, body)):
            raise Unsupported(f"body '{body.name}': damping", "XPBD has one damping of spin for all bodies")


def dampen_free(bodies: Bodies, body: Body, joint: int) -> None:
    """Q = -c (m v, I w) of a body on a free joint. Raises: Unsupported."""
    linear, angular = rates_of(bodies, body)
    if not (linear or angular):
        return
    tensor = np.asarray(body.inertia)
    if angular and (tensor - np.diag(np.diag(tensor))).any():
        raise Unsupported(
            f"body '{body.name}': damping of spin beside products of inertia", "MuJoCo-Warp damps each coordinate by itself"
        )
    at, damping = bodies.builder.joint_qd_start[joint], bodies.builder.joint_damping
    for axis in range(3):
        damping[at + axis] += linear * body.mass
        damping[at + 3 + axis] += angular * float(tensor[axis, axis])


def damping_along(bodies: Bodies, joint: Joint, node: str) -> float:
    """What the damping of the body `node` is along the coordinate of the joint that it hangs on. Raises: Unsupported."""
    body, scene = bodies.scene.body(node), bodies.scene
    linear, angular = rates_of(bodies, body)
    above = joint.parent if node == joint.child else joint.child
    grounded = above == WORLD or bodies.links[above] == WORLD_BODY
    if not (linear or angular) or (grounded and isinstance(joint, Fixed)):
        return 0.0
    if not grounded or not isinstance(joint, Revolute | Prismatic) or scene.body(node).motion != "dynamic":
        raise Unsupported(
            f"body '{node}': damping of a body held by {joint.type} joint '{joint.name}'",
            "MuJoCo-Warp damps coordinates, not bodies",
        )
    axis = np.array(joint.axis_W)
    if isinstance(joint, Prismatic):
        return linear * body.mass
    arm = np.cross(axis, np.array(body.p_WB) - np.array(joint.anchor_W))
    turn = np.array(rotation_matrix(body.q_WB)).T @ axis
    return linear * body.mass * float(arm @ arm) + angular * float(turn @ np.asarray(body.inertia) @ turn)
