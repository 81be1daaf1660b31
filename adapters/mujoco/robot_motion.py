"""A robot in canonical form moved by torques in MuJoCo: every body's frame is W's at zero positions, and there are no shapes.

Joint limits, dry friction, bounds of effort, mimics and points that loops close at are in it; loops that hold all are not.
"""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.vendor import mujoco_module
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene.importers.robot import Closure, Coordinate, Solid
from plumbline.harness.scene.parity.canonical import FIXED, SCALAR, Canonical
from plumbline.harness.scene.parity.parting import DT, Motion
from plumbline.harness.trajectory import Floats


def moved(robot: Canonical, motion: Motion) -> Floats:
    """Positions (samples, joints, 4): the coordinate and zeros, or a ball's or free joint's quaternion. Raises: Unsupported."""
    mj = mujoco_module()
    spec = mj.MjSpec()
    spec.option.timestep, spec.option.gravity = DT, motion.gravity
    spec.option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
    bodies: dict[str, Any] = {FIXED: spec.worldbody}
    for link in robot.moving:
        joint = link.coordinate
        body = bodies[joint.name] = bodies[link.parent or FIXED].add_body(name=f"body {joint.name}")
        _add_joint(mj, body, joint)
        if link.solid is not None and link.solid.mass > 0:
            _weigh(body, link.solid)
        if joint.kind in SCALAR:
            motor = spec.add_actuator(name=joint.name, trntype=mj.mjtTrn.mjTRN_JOINT, target=joint.name)
            motor.set_to_motor()
    for joint in robot.joints:
        if joint.tie is not None and joint.tie.joint:
            kinds = {"type": mj.mjtEq.mjEQ_JOINT, "objtype": mj.mjtObj.mjOBJ_JOINT}
            tie = spec.add_equality(name1=joint.name, name2=joint.tie.joint, **kinds)
            tie.data[0], tie.data[1] = joint.tie.offset, joint.tie.ratio
    for number, closure in enumerate(robot.closures):
        if closure.kind == "ball":
            _bind(mj, spec, bodies, closure, number)
    try:
        model = spec.compile()
    except ValueError as error:
        raise Unsupported("the motion", f"MuJoCo's compiler refuses the robot of {robot.source}: {error}") from None
    return _stepped(mj, model, robot, motion)


def _add_joint(mj: Any, body: Any, joint: Coordinate) -> None:
    kinds = {"revolute": mj.mjtJoint.mjJNT_HINGE, "prismatic": mj.mjtJoint.mjJNT_SLIDE, "ball": mj.mjtJoint.mjJNT_BALL}
    if joint.kind == "free":
        body.add_freejoint(name=joint.name)
        return
    made = body.add_joint(name=joint.name, type=kinds[joint.kind], pos=joint.anchor, axis=joint.axis)
    made.damping[0], made.stiffness[0] = joint.damping, joint.stiffness
    made.springref, made.armature, made.frictionloss = joint.rest, joint.armature, joint.friction_loss
    if joint.kind != "ball" and (joint.lower is not None or joint.upper is not None):
        made.limited = mj.mjtLimited.mjLIMITED_TRUE
        made.range = (-1e6 if joint.lower is None else joint.lower, 1e6 if joint.upper is None else joint.upper)
    if joint.effort is not None:
        made.actfrclimited, made.actfrcrange = mj.mjtLimited.mjLIMITED_TRUE, (-joint.effort, joint.effort)


def _weigh(body: Any, solid: Solid) -> None:
    body.explicitinertial, body.mass, body.ipos = True, solid.mass, solid.centre
    assert solid.inertia is not None
    t = solid.inertia
    body.fullinertia = (t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2])


def _bind(mj: Any, spec: Any, bodies: dict[str, Any], closure: Closure, place: int) -> None:
    bodies[closure.link_A].add_site(name=f"loop {place} A", pos=closure.anchor_A)
    bodies[closure.link_B].add_site(name=f"loop {place} B", pos=closure.anchor_B)
    names = {"name1": f"loop {place} A", "name2": f"loop {place} B"}
    spec.add_equality(type=mj.mjtEq.mjEQ_CONNECT, objtype=mj.mjtObj.mjOBJ_SITE, **names)


def _stepped(mj: Any, model: Any, robot: Canonical, motion: Motion) -> Floats:
    scene = mj.MjData(model)
    joints = [(k, joint.kind, int(model.joint(joint.name).qposadr[0])) for k, joint in enumerate(robot.joints)]
    for k, kind, at in joints:
        if kind in SCALAR:
            scene.qpos[at] = motion.start[k]
    drives = [(model.actuator(joint.name).id, k) for k, joint in enumerate(robot.joints) if joint.kind in SCALAR]
    motors, columns = (np.array(side, dtype=np.int64) for side in (zip(*drives, strict=True) if drives else ((), ())))
    kept = np.zeros((len(motion.torques) + 1, len(robot.joints), 4))
    for sample in range(len(kept)):
        for k, kind, at in joints:
            if kind in SCALAR:
                kept[sample, k, 0] = scene.qpos[at]
            else:
                first = at + 3 if kind == "free" else at
                kept[sample, k] = scene.qpos[first : first + 4]
        if sample < len(motion.torques):
            scene.ctrl[motors] = motion.torques[sample, columns]
            mj.mj_step(model, scene)
    return kept
