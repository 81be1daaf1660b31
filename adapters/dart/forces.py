"""The forces and commands of the coming sub-step; DART forgets them after each."""

from collections.abc import Iterable

import numpy as np

from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.drives import Pushes
from plumbline.harness.trajectory import Floats

Wrenches = tuple[Floats, Floats]
"""(f_B_W, tau_B_W), each (n, 3): N and N m on every body."""


def push(built: Built, wrenches: Wrenches | None, pushed: Iterable[int], pushes: Pushes) -> None:
    """Wrenches on the bodies `pushed`, dampers, velocities of kinematic bodies, springs and drives but the foreseen."""
    if wrenches is not None:
        for i in pushed:
            built.nodes[i].addExtForce(wrenches[0][i])
            built.nodes[i].addExtTorque(wrenches[1][i], False)
    if built.damped:
        damp(built)
    for joint, velocity in built.belts.values():
        joint.setCommands(velocity)
    if built.motors:
        pushes.set(built.world.getTimeStep())


def damp(built: Built) -> None:
    """Forces and torques of bodies whose damping is none of a joint's."""
    dt = built.world.getTimeStep()
    for i, c, d in built.damped:
        node, body = built.nodes[i], built.scene.bodies[i]
        node.addExtForce(-body.mass * c / (1 + c * dt) * node.getCOMLinearVelocity())
        R_WB = node.getWorldTransform().rotation()
        node.addExtTorque(-d / (1 + d * dt) * (R_WB @ np.asarray(body.inertia) @ R_WB.T @ node.getAngularVelocity()), False)
