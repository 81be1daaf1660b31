"""Whether the damping of drives is an actuator's or a joint's: Euler takes the first explicitly and the second implicitly."""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.rates import resisted
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.adapters.mujoco.vendor import flag
from plumbline.adapters.mujoco.world import World
from plumbline.harness.adapter import Unsupported
from plumbline.harness.trajectory import Floats


def damp_joints(draft: Draft, world: World, h: float) -> bool:
    """Give the joints the damping of their drives where Euler, by steps of h [s], would be unstable with it in the actuators.

    A coordinate of inertia m on k and c steps v' = v - h (k x + c v)/m, x' = x + h v', which is stable for z + y/2 < 2 with
    z = c h/m and y = k h^2/m (Jury's criterion). The inertia is what contacts and loops of the start leave: M + J' D J over
    their rows. The other form errs more where both are stable: contact forces are found without it. A drive with a limit
    keeps its own, since the limit is for all of its force. Source: MuJoCo, "Computation", numerical integration (implicit
    damping of joints alone in Euler), constraint model (J, D).
    """
    mj, m, d = world.mj, world.model, world.state
    if not draft.drives or m.opt.integrator != flag(mj, "mjtIntegrator", "mjINT_EULER"):
        return False
    stiffness, damping, dof = resisted(m, draft.drives.values())
    inertia = _held(mj, m, d)
    if _largest(inertia, damping) * h + _largest(inertia, stiffness) * h**2 / 2 < 2:
        return False
    free = [a for a in draft.drives.values() if not m.actuator_forcelimited[a]]
    for actuator in free:
        m.dof_damping[dof[m.actuator_trnid[actuator, 0]]] -= m.actuator_biasprm[actuator, 2]
        m.actuator_biasprm[actuator, 2] = 0.0
    mj.mj_forward(m, d)
    return bool(free)


def _held(mj: Any, m: Any, d: Any) -> Floats:
    """The inertia (nv, nv) of the coordinates with that of the rows of contacts and equalities, at the present state."""
    inertia = np.zeros((m.nv, m.nv))
    mj.mj_fullM(m, d, inertia)
    if d.nefc == 0:
        return inertia
    rows = np.zeros((d.nefc, m.nv))
    if mj.mj_isSparse(m):
        mj.mju_sparse2dense(rows, d.efc_J, d.efc_J_rownnz, d.efc_J_rowadr, d.efc_J_colind)
    else:
        rows[:] = d.efc_J.reshape(rows.shape)
    first = flag(mj, "mjtConstraint", "mjCNSTR_CONTACT_FRICTIONLESS")
    held = (d.efc_type == flag(mj, "mjtConstraint", "mjCNSTR_EQUALITY")) | (d.efc_type >= first)
    total: Floats = inertia + rows[held].T @ (d.efc_D[held, None] * rows[held])
    return total


def _largest(inertia: Floats, own: Floats) -> float:
    """The largest eigenvalue of the inverse of an inertia times a diagonal."""
    at = np.flatnonzero(own)
    if not len(at):
        return 0.0
    root = np.zeros((len(own), len(at)))
    root[at, np.arange(len(at))] = np.sqrt(own[at])
    try:
        return float(np.linalg.eigvalsh(root.T @ np.linalg.solve(inertia, root))[-1])
    except np.linalg.LinAlgError as error:
        why = f"the inertias of the coordinates lie too far apart for double precision ({error})"
        raise Unsupported("drives", why) from None
