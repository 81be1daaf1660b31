"""What only a compiled model takes: damping of coordinates, the scale of the tolerance, what the scene chooses."""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.damping import dampen
from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.rates import fastest, stiffest
from plumbline.adapters.mujoco.sparse_factor import may_err
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.adapters.mujoco.vendor import flag
from plumbline.harness.scene import Effect

RESOLVED_RATE = 0.1
"""Largest rate times step of a spring or damper that Euler is given in a scene with contacts: about 60 steps a period."""
RK4_RATE = 2.0
"""Largest rate |lambda| h of springs, dampers and drives that RK4 is given.

For a damper, z = -lambda h: RK4 multiplies by R(-z) = 1 - z + z^2/2 - z^3/6 + z^4/24, the implicit rule by 1/(1 + z), the
truth by e^-z; RK4 is the nearer one up to z = 2, where both say 1/3. For a spring it is so wherever both are stable.
The half disc |z| <= 2.6 of decaying motion lies in RK4's region of stability (2.785 on the real axis, 2.828 on the imaginary
one), so that at 2 rates may be off by a factor of 1.3.
"""
SPRING_RATE = 1.5
"""Largest rate w h of undamped springs and drives that the velocity-implicit rule is given: it takes positions explicitly.

Source: MuJoCo, "Computation", numerical integration: stable up to w h = 2; the discrete integrator alone is implicit in
position, stable at any step, and more damped below the limit. Over a step of w h = z the velocity-implicit rule (cos a =
1 - z^2/2) errs by 2 sin((a - z)/2), the discrete one by |1/(1 + i z) - e^(-i z)|: .20 against .59 at 1.5, equal at 1.96. At 1.5
rates may be off by a factor of 1.3, as for RK4.
"""
DENSE_LIMIT = 1200
"""Coordinates up to which a dense factor stands in for a faulty one: its cost grows with their cube, its memory with their
square."""


def settle(plan: Plan, draft: Draft, model: Any) -> float:
    """Give a compiled model its damping, the scale of its tolerance, and what the scene chooses.

    Returns: what the tolerance was multiplied by [1]. Raises: Unsupported.
    """
    mj, option, scale = draft.mj, model.opt, 1.0
    dampen(plan, model)
    if draft.inertial:
        # Asked between the steps, they would cost in every one.
        option.disableflags |= flag(mj, "mjtDisableBit", "mjDSBL_SENSOR")
    driven = [model.joint(f"f{k}").dofadr[0] for k, b in enumerate(plan.scene.bodies) if plan.prescribed(b)]
    if driven:
        # The tolerance is relative to the mean inertia of the model, which the armature of kinematic bodies must not raise.
        kept = np.setdiff1d(np.arange(model.nv), [adr + i for adr in driven for i in range(6)])
        own = float(model.dof_M0[kept].mean()) if len(kept) else 1.0
        scale = own / float(model.dof_M0.mean())
        option.tolerance *= scale
    if not plan.options.by_scene:
        return scale
    if plan.settings.integrator is None:
        if not any(body.movable for body in plan.scene.bodies):
            name = "EULER"  # four stages of what no force moves are one
        elif Effect.CONTACT not in plan.effects:
            rate, frequency = stiffest(mj, model, draft.drives.values(), plan.h)
            name = "RK4" if rate <= RK4_RATE else "IMPLICITFAST" if frequency <= SPRING_RATE else "DISCRETE"
        elif fastest(model, draft.drives.values(), plan.h) > RESOLVED_RATE:
            # The discrete map damps a rebound away; the implicit one jitters in contact, but bears both.
            name = "IMPLICITFAST" if draft.rebounds else "DISCRETE"
        else:
            name = "EULER"
        option.integrator = flag(mj, "mjtIntegrator", f"mjINT_{name}")
    if plan.options.jacobian is None and model.nv <= DENSE_LIMIT and may_err(plan, mj, model):
        option.jacobian = flag(mj, "mjtJacobian", "mjJAC_DENSE")
    return scale
