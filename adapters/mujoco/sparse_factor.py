"""Where the sparse factor of MuJoCo 4.0.0 can be wrong, so that a dense one, or a word of warning, stands in for it."""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.vendor import flag
from plumbline.harness.adapter.touching_kinds import touching_kinds
from plumbline.harness.scene import Effect

FAULTY = "4.0.0"
"""The version whose sparse factor of the Newton solver its makers call wrong (release notes of 4.0.1, issue 3767)."""
LEAST_SPARSE = 60
"""Coordinates from which on the engine's choice, `auto`, is sparse. Source: MuJoCo, XML reference, option/jacobian."""


def sparse(mj: Any, model: Any) -> bool:
    """Does the model, as it is told, take sparse matrices?"""
    asked = model.opt.jacobian
    by_size = asked == flag(mj, "mjtJacobian", "mjJAC_AUTO") and model.nv >= LEAST_SPARSE
    return bool(by_size or asked == flag(mj, "mjtJacobian", "mjJAC_SPARSE"))


def may_err(plan: Plan, mj: Any, model: Any) -> bool:
    """Can constraints couple coordinates in a way that the faulty factor gets wrong?

    It works on rows in threes, and takes rows of one three to have the same descendants. The three or six coordinates of balls
    and free bodies have; single ones, of hinges and sliders, need not where something couples two branches: a loop, a tendon,
    or bodies that touch each other. `tests/vendor/test_mujoco_sparse_factor.py` draws such models: without a coupling, or in
    threes, none errs.
    """
    if mj.__version__ != FAULTY or model.opt.solver != flag(mj, "mjtSolver", "mjSOL_NEWTON"):
        return False
    single = np.isin(model.jnt_type, [flag(mj, "mjtJoint", f"mjJNT_{kind}") for kind in ("HINGE", "SLIDE")])
    return bool(single.any()) and (model.neq > 0 or model.ntendon > 0 or _touch_each_other(plan))


def _touch_each_other(plan: Plan) -> bool:
    """Can two bodies touch that both have coordinates?"""
    if Effect.CONTACT not in plan.effects:
        return False
    meet = any(a[1] and b[1] for a, b in touching_kinds(plan.scene))
    return meet or any(plan.prescribed(body) and body.collision for body in plan.scene.bodies)
