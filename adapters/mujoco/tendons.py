"""Fixed tendons, which are MuJoCo's own."""

from plumbline.adapters.mujoco.limits import bounds_of
from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.softness import stop
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.adapters.mujoco.vendor import linear_law
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Effect, Tendon


def add_tendon(plan: Plan, draft: Draft, tendon: Tendon) -> None:
    """A tendon with its spring, limits and drive. Raises: Unsupported."""
    mj = draft.mj
    native = {link.joint.name: f"f{link.body}" for link in plan.links if link.joint is not None}
    name = f"l.{tendon.name}"
    made = draft.spec.add_tendon(name=name)
    for arm in tendon.arms:
        if arm.joint not in native:
            raise Unsupported(
                f"tendon '{tendon.name}' of joint '{arm.joint}', which closes a loop", "a loop of MuJoCo has no coordinate"
            )
        made.wrap_joint(native[arm.joint], arm.arm)
    if tendon.spring is not None:
        made.stiffness = linear_law(made.stiffness, tendon.spring.stiffness)
        made.damping = linear_law(made.damping, tendon.spring.damping)
        made.springlength = [tendon.spring.rest, tendon.spring.rest]
    bounds = bounds_of(tendon)
    if bounds is not None:
        made.limited, made.range = mj.mjtLimited.mjLIMITED_TRUE, bounds
        stop(made, plan.options, plan.h)
    drive = tendon.drive if Effect.DRIVES in plan.effects else None
    if drive is None:
        return
    pull = draft.spec.add_actuator(name=f"d.{name}", target=name, trntype=mj.mjtTrn.mjTRN_TENDON)
    pull.gaintype, pull.gainprm = mj.mjtGain.mjGAIN_FIXED, [0.0] * 10
    constant = drive.stiffness * drive.target + drive.damping * drive.target_velocity + (drive.feedforward or 0.0)
    pull.biastype = mj.mjtBias.mjBIAS_AFFINE
    pull.biasprm = [constant, -drive.stiffness, -drive.damping, *([0.0] * 7)]
    if drive.limit is not None:
        pull.forcelimited, pull.forcerange = mj.mjtLimited.mjLIMITED_TRUE, [-drive.limit, drive.limit]
