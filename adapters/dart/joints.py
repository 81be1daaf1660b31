"""Joints: as coordinates of a skeleton, or as constraints between bodies."""

from typing import Any

import numpy as np

from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.drives import SERVO_NOTICE, Motor
from plumbline.adapters.dart.trees import WORLD_FRAME, Edge, ends
from plumbline.adapters.dart.vendor import pose
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Ball, Distance, Drive, Effect, Fixed, Joint, Prismatic, Revolute, Spring


def add_joint(built: Built, owner: Any, edge: Edge) -> tuple[Any, Any]:
    """The joint of an edge and its body, placed so that DART's coordinate is the scene's."""
    dart, scene = built.dart, built.scene
    joint, body = edge.joint, scene.bodies[edge.body]
    X_WC = pose(dart, body.p_WB, body.q_WB)
    if joint is None:
        free, node = owner.createFreeJointAndBodyNodePair()
        v_WB, w_WB = body.velocity_at_start
        velocity = np.array([*w_WB, *v_WB])
        if not body.movable:
            free.setActuatorType(dart.dynamics.ActuatorType.VELOCITY)
            if velocity.any() or body.prescribed is not None:
                built.belts[body.name] = free, velocity
        free.setTransform(X_WC)
        free.setVelocities(velocity)
        return free, node
    parent = None if edge.parent == WORLD_FRAME else scene.bodies[edge.parent]
    X_PW = pose(dart, (0.0, 0.0, 0.0)) if parent is None else pose(dart, parent.p_WB, parent.q_WB).inverse()
    if isinstance(joint, Fixed):
        made, node = owner.createWeldJointAndBodyNodePair()
        made.setTransformFromParentBodyNode(X_PW.multiply(X_WC))
        return made, node
    assert not isinstance(joint, Distance)
    X_WA = pose(dart, joint.anchor_W)
    X_PA = X_PW.multiply(X_WA)
    X_CA = X_WC.inverse().multiply(X_WA)
    if isinstance(joint, Ball):
        made, node = owner.createBallJointAndBodyNodePair()
    else:
        axis = edge.sign * np.array(joint.axis_W)
        # At coordinate `position` the bodies stand as the scene has them; so zero lies that far back.
        back = dart.math.Isometry3()
        if isinstance(joint, Revolute):
            made, node = owner.createRevoluteJointAndBodyNodePair()
            back.set_rotation(np.asarray(dart.math.expMapRot(-joint.position * axis)))
        else:
            made, node = owner.createPrismaticJointAndBodyNodePair()
            back.set_translation(-joint.position * axis)
        X_PA = X_PA.multiply(back)
        made.setAxis(axis)
        _set_coordinate(built, made, node, joint)
    made.setTransformFromParentBodyNode(X_PA)
    made.setTransformFromChildBodyNode(X_CA)
    return made, node


def _set_coordinate(built: Built, made: Any, node: Any, joint: Revolute | Prismatic) -> None:
    """Position, limits, spring and drive of a joint of one coordinate."""
    if joint.coupling is not None:
        raise Unsupported(
            f"joint '{joint.name}': coupling to '{joint.coupling.joint}'",
            "DART's mimics follow a step late, and take nothing of their leader or blow up towards a slower one",
        )
    built.coordinates[joint.name] = made
    made.setPosition(0, joint.position)
    if joint.armature:
        built.rotors[joint.name] = joint.armature / built.world.getTimeStep()
        made.setDampingCoefficient(0, built.rotors[joint.name])
    if joint.friction_loss:
        made.setCoulombFriction(0, joint.friction_loss)
    if joint.speed_limit is not None:
        made.setLimitEnforcement(True)
        made.setVelocityLowerLimit(0, -joint.speed_limit)
        made.setVelocityUpperLimit(0, joint.speed_limit)
    if joint.limits is not None:
        made.setLimitEnforcement(True)
        if joint.limits.lower is not None:
            made.setPositionLowerLimit(0, joint.limits.lower)
        if joint.limits.upper is not None:
            made.setPositionUpperLimit(0, joint.limits.upper)
    drives = built.resolved.options["drives"]
    drive = joint.drive if Effect.DRIVES in built.scene.effects else None
    if joint.spring is not None or drive is not None:
        motor = Motor(
            made,
            node.getSkeleton(),
            joint.spring or Spring(),
            drive or Drive(),
            (drive or Drive()).target,
            stable=drives == "stable",
            servo=drives == "servo" and drive is not None and drive.stiffness + drive.damping > 0,
            rotor=built.rotors.get(joint.name, 0.0),
        )
        motor.rest()
        if motor.servo:
            _set_servo(built, motor, joint.name)
        built.motors[joint.name] = motor


def _set_servo(built: Built, motor: Motor, name: str) -> None:
    """Let DART's own motor drive a joint. Raises: Unsupported."""
    if motor.push != 0.0:
        raise Unsupported(f"joint '{name}'", "a servo of DART takes no force beside, as a spring that rests beyond a limit is")
    if motor.drive.feedforward:
        raise Unsupported(f"joint '{name}': feedforward", "a servo of DART holds a velocity and takes no torque beside")
    motor.joint.setActuatorType(built.dart.dynamics.ActuatorType.SERVO)
    if motor.drive.limit is not None:
        motor.joint.setForceLowerLimit(0, -motor.drive.limit)
        motor.joint.setForceUpperLimit(0, motor.drive.limit)
    if SERVO_NOTICE not in built.notices:
        built.notices.append(SERVO_NOTICE)


def add_constraints(built: Built, cut: list[Joint]) -> None:
    """Hold the joints that no tree holds by DART's own constraints."""
    constraint = built.dart.constraint
    solver = built.world.getConstraintSolver()
    for joint in cut:
        places = [i for i in ends(built.scene, joint) if i != WORLD_FRAME]
        nodes = [built.nodes[i] for i in places]
        assert not isinstance(joint, Distance)
        anchor = np.array(built.scene.bodies[places[0]].p_WB if isinstance(joint, Fixed) else joint.anchor_W)
        lever = max(float(np.linalg.norm(np.asarray(node.getCOM()) - anchor)) for node in nodes) or 1.0
        match joint:
            case Fixed():
                solver.addConstraint(constraint.WeldJointConstraint(*nodes))
                common = anchor + lever * np.eye(3)
            case Ball():
                common = anchor[None]
            case Revolute(axis_W=axis):
                common = anchor + np.outer((0.0, lever), axis)
            case _:
                raise AssertionError(f"joint '{joint.name}' cannot be cut")
        for point in common:
            if not isinstance(joint, Fixed):
                solver.addConstraint(constraint.BallJointConstraint(*nodes, point))
            back = [node.getWorldTransform().inverse() for node in nodes]
            built.loops.append(tuple((i, X.rotation() @ point + X.translation()) for i, X in zip(places, back, strict=True)))
