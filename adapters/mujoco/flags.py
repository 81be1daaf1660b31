"""Settings and effects as options and flags of the model."""

from plumbline.adapters.mujoco.arena import arena_for
from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.adapters.mujoco.vendor import flag
from plumbline.harness.scene import Effect


def set_options(plan: Plan, draft: Draft) -> None:
    """Give the model its step, gravity, memory, solver, integrator, cone and Jacobian, and switch effects on and off."""
    mj, option, settings, choice = draft.mj, draft.spec.option, plan.settings, plan.options
    draft.spec.compiler.degree = False
    option.timestep, option.gravity = plan.h, plan.scene.gravity
    draft.spec.memory = arena_for(plan.scene)
    if settings.iterations is not None:
        option.iterations = settings.iterations
    if settings.tolerance is not None:
        option.tolerance = settings.tolerance
    if settings.solver is not None:
        option.solver = flag(mj, "mjtSolver", f"mjSOL_{settings.solver.upper()}")
    if settings.integrator is not None:
        option.integrator = flag(mj, "mjtIntegrator", f"mjINT_{settings.integrator.upper()}")
    if choice.cone is not None:
        option.cone = flag(mj, "mjtCone", f"mjCONE_{choice.cone.upper()}")
    if choice.jacobian is not None:
        option.jacobian = flag(mj, "mjtJacobian", f"mjJAC_{choice.jacobian.upper()}")
    for name in ("impratio", "noslip_iterations", "ls_iterations"):
        if getattr(choice, name) is not None:
            setattr(option, name, getattr(choice, name))
    # A reset on NaN would hide it; the filter between parent and child knows nothing of `collide`: excludes stand for it.
    off = {"AUTORESET": True, "FILTERPARENT": True}
    off |= {"CONTACT": Effect.CONTACT not in plan.effects, "GRAVITY": Effect.GRAVITY not in plan.effects}
    for name in ("multiccd", "nativeccd", "island", "warmstart", "refsafe"):
        off[name.upper()] = getattr(choice, name) is False
    on = {"SPECULATIVE": plan.speculative, "DIAGEXACT": choice.diagexact is True}
    option.disableflags |= sum(flag(mj, "mjtDisableBit", f"mjDSBL_{name}") for name, set_ in off.items() if set_)
    option.enableflags |= sum(flag(mj, "mjtEnableBit", f"mjENBL_{name}") for name, set_ in on.items() if set_)
