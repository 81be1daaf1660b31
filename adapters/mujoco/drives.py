"""Drives as actuators of native joints."""

from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.uncompiled_model import Draft


def add_drives(plan: Plan, draft: Draft) -> None:
    """PD drives: stiffness ctrl + damping target_velocity - stiffness x - damping x' + feedforward, cut off at the limit."""
    mj = draft.mj
    native = {link.joint.name: link.body for link in plan.links if link.joint is not None}
    for joint in plan.joints:
        drive = getattr(joint, "drive", None)
        if drive is None:
            continue
        made = draft.spec.add_actuator(name=f"d.{joint.name}", target=f"f{native[joint.name]}", trntype=mj.mjtTrn.mjTRN_JOINT)
        made.gaintype, made.gainprm = mj.mjtGain.mjGAIN_FIXED, [drive.stiffness, *([0.0] * 9)]
        constant = drive.damping * drive.target_velocity + (drive.feedforward or 0.0)
        bias = [constant, -drive.stiffness, -drive.damping]
        made.biastype, made.biasprm = mj.mjtBias.mjBIAS_AFFINE, [*bias, *([0.0] * 7)]
        if drive.limit is not None:
            made.forcelimited, made.forcerange = mj.mjtLimited.mjLIMITED_TRUE, [-drive.limit, drive.limit]
        draft.drives[joint.name] = len(draft.drives)
