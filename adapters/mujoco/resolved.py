"""The settings that are used, read back from a compiled model."""

from typing import Any

from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.softness import LEAST_STEPS, friction_constant, time_constant
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.harness.adapter import Settings


def resolved_settings(plan: Plan, draft: Draft, model: Any, tolerance_scale: float) -> Settings:
    """The settings that a compiled model has. Args: tolerance_scale: what its tolerance was multiplied by [1]."""
    mj, option = draft.mj, model.opt
    substeps, choice, own = plan.settings.substeps or 1, plan.options, plan.options.friction_steps
    free = mj.mjtIntegrator(option.integrator).name == "mjINT_DISCRETE" or choice.refsafe is False
    least = 0.0 if free else LEAST_STEPS * plan.h
    contact = time_constant(choice.contact_steps, plan.h, choice.slowest)
    fast = time_constant(choice.fast_steps, plan.h, choice.slowest)
    flags = {
        "disabled": ("mjtDisableBit", "mjDSBL_", option.disableflags),
        "enabled": ("mjtEnableBit", "mjENBL_", option.enableflags),
    }
    used: dict[str, Any] = {
        "cone": mj.mjtCone(option.cone).name.removeprefix("mjCONE_").lower(),
        "jacobian": mj.mjtJacobian(option.jacobian).name.removeprefix("mjJAC_").lower(),
        "impratio": float(option.impratio),
        "noslip_iterations": int(option.noslip_iterations),
        "ls_iterations": int(option.ls_iterations),
        "rebound_steps": choice.rebound_steps if draft.rebounds else None,
        "rebound_friction_steps": (choice.rebound_steps if own is None else own) if draft.rebounds else None,
        "contact_time_constant": max(least, contact),
        "fast_time_constant": max(least, fast) if draft.pressed else None,
        "friction_time_constant": max(least, friction_constant(choice, plan.h) or contact),
        "contact_damping_ratio": choice.contact_damping_ratio or 1.0,
        "contact_impedance": choice.contact_impedance or "0.9..0.95",
        "limit_time_constant": max(least, time_constant(choice.limit_steps, plan.h, choice.slowest)),
        "limit_damping_ratio": choice.limit_damping_ratio or 1.0,
        "limit_impedance": choice.limit_impedance or "0.9..0.95",
        "loop_time_constant": max(least, time_constant(choice.loop_steps, plan.h, choice.slowest)),
        "loop_impedance": choice.loop_impedance or "0.9..0.95",
        "drive_damping": None if not draft.drives else "joint" if draft.damped_joints else "actuator",
        "arena_bytes": int(model.narena),
        "by_scene": choice.by_scene,
    }
    for word, (kind, prefix, bits) in flags.items():
        members = getattr(mj, kind).__members__.items()
        used[word] = [n.removeprefix(prefix).lower() for n, bit in members if n.startswith(prefix) and int(bit) & int(bits)]
    return Settings(
        dt=float(option.timestep) * substeps,
        substeps=substeps,
        iterations=int(option.iterations),
        integrator=mj.mjtIntegrator(option.integrator).name.removeprefix("mjINT_").lower(),
        solver=mj.mjtSolver(option.solver).name.removeprefix("mjSOL_").lower(),
        tolerance=float(option.tolerance) / tolerance_scale,
        options=used,
        source=plan.settings.source,
    )
