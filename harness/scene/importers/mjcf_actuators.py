"""MJCF's actuators: servos of one joint as drives, motors with a command as their constant force; others."""

from typing import TypeAlias

import numpy as np

from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.robot import Need, Servo

Servos: TypeAlias = dict[int, Servo]
"""By the place of a joint in the compiled model."""


def read(model: Model, ctrl: Array) -> tuple[Servos, list[Fidelity], list[Need]]:
    """The servos of joints at the commands `ctrl`, what became of the actuators, and those that a scene has no word for."""
    servos: Servos = {}
    idle, driven, strange = [], [], []
    if model.flag("actuation"):
        count = len(model.actuator_trntype)
        row = Fidelity(element="actuator", name="", count=count, outcome="exact", consequence="the file switches actuators off")
        return {}, [row] if count else [], []
    for k in range(len(model.actuator_trntype)):
        name = model.name("actuator", k)
        servo = _servo(model, k, ctrl)
        joint = int(model.actuator_trnid[k][0])
        if servo is None or joint in servos:
            strange.append(name)
        elif servo == Servo():
            idle.append(name)
        else:
            driven.append(name)
            servos[joint] = servo
    rows = []
    rows += Fidelity.exact("actuator", driven, "drive of its joint")
    rows += Fidelity.left_out(
        "actuator",
        idle,
        "a motor without a command has no force; a keyframe's ctrl is one, and so is a joint's feedforward "
        "in the companion file",
    )
    return servos, rows, [Need(kind="actuator", element="actuator", names=tuple(strange))] if strange else []


def _servo(model: Model, k: int, ctrl: Array) -> Servo | None:
    """The drive that an actuator is; an empty one for a motor without a command; None for what is no drive of one joint.

    Its force is gain u + b_0 + b_1 l + b_2 l', with l = gear q: a torque of gear times that.
    """
    plain = (
        model.word("Trn", int(model.actuator_trntype[k])) in ("joint", "jointinparent")
        and model.word("Gain", int(model.actuator_gaintype[k])) == "fixed"
        and model.word("Dyn", int(model.actuator_dyntype[k])) == "none"
        and not np.any(model.actuator_armature[k])
        and not np.any(model.actuator_damping[k])
        and not model.actuator_gear[k][1:].any()
    )
    bias = model.word("Bias", int(model.actuator_biastype[k]))
    if not plain or bias not in ("none", "affine"):
        return None
    joint, gear, gain = int(model.actuator_trnid[k][0]), float(model.actuator_gear[k][0]), float(model.actuator_gainprm[k][0])
    if model.word("Joint", int(model.jnt_type[joint])) not in ("hinge", "slide") or gear == 0:
        return None
    b0, b1, b2 = (float(b) for b in model.actuator_biasprm[k][:3]) if bias == "affine" else (0.0, 0.0, 0.0)
    command = _command(model, k, ctrl)
    limit = _limit(model, k, joint, gear)
    if limit == 0:
        return None
    constant = b0 * gear
    if b1 == b2 == 0:
        constant += gain * command * gear
        return Servo(limit=limit, feedforward=constant) if constant else Servo()
    if b1 > 0 or b2 > 0:
        return None
    stiffness, damping = -b1 * gear * gear, -b2 * gear * gear
    if b1 == 0:
        return Servo(damping=damping, target_velocity=gain * command / (-b2 * gear), limit=limit, feedforward=constant)
    target = gain * command / (-b1 * gear)
    return Servo(stiffness=stiffness, damping=damping, target=target, limit=limit, feedforward=constant)


def _command(model: Model, k: int, ctrl: Array) -> float:
    index = int(model.actuator_ctrladr[k])
    command = float(ctrl[index]) if 0 <= index < len(ctrl) else 0.0
    if model.actuator_ctrllimited[k]:
        low, high = (float(x) for x in np.ravel(model.actuator_ctrlrange[k])[:2])
        command = min(max(command, low), high)
    return command


def _limit(model: Model, k: int, joint: int, gear: float) -> float | None:
    """The greatest force on the coordinate; None for no bound, 0 for bounds that are not alike both ways."""
    bounds = []
    if model.actuator_forcelimited[k]:
        bounds.append(np.ravel(model.actuator_forcerange[k])[:2] * abs(gear))
    if model.jnt_actfrclimited[joint]:
        bounds.append(model.jnt_actfrcrange[joint])
    if any(abs(low + high) > 1e-12 * abs(high) or high <= 0 for low, high in bounds):
        return 0.0
    return min((float(high) for _, high in bounds), default=None)
