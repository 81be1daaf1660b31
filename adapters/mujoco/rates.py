"""How fast the springs, dampers and drives of a model swing and decay against a step."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from plumbline.adapters.mujoco.vendor import flag, refuse
from plumbline.harness.trajectory import Floats, Integers

EXACT_ROWS = 200
"""Springs and dampers up to which their fastest mode is found exactly rather than bounded."""
RATE_SAMPLES = 16
"""Configurations at which the rates are read off besides the first one: joint-space inertia changes with the configuration."""


def fastest(model: Any, drives: Iterable[int], h: float) -> float:
    """The largest rate times step h [s] of springs, dampers and drives: sqrt(k/m) h or c/m h.

    Args: drives: the actuators of those drives.
    """
    rate = 0.0
    stiffness, damping, dof = resisted(model, drives)
    groups = (
        (stiffness[dof], damping[dof], model.dof_invweight0[dof]),
        (*_along_tendons(model, drives), model.tendon_invweight0),
    )
    for k, c, w in groups:
        if len(w):
            rate = max(rate, h * float(np.sqrt(k * w).max()), h * float((c * w).max()))
    return rate


def stiffest(mj: Any, model: Any, drives: Iterable[int], h: float) -> tuple[float, float]:
    """Bounds of |lambda| h over the modes of springs, dampers and drives, on joint-space inertia, over configurations:
    as they are, and undamped.

    Equation: a mode x of M q'' + C q' + K q = 0 has lambda^2 x'Mx + lambda x'Cx + x'Kx = 0, thus with c and k the largest
    eigenvalues of M^-1 C and M^-1 K, |lambda|^2 <= c |lambda| + k. Source: Tisseur, Meerbergen, SIAM Review 43 (2001).
    """
    stiffness, damping, _ = resisted(model, drives)
    stretched, slowed = _along_tendons(model, drives)
    if not (stiffness.any() or damping.any() or stretched.any() or slowed.any()):
        return 0.0, 0.0
    d, random = mj.MjData(model), np.random.default_rng(0)
    rigid = bool((model.jnt_type == flag(mj, "mjtJoint", "mjJNT_FREE")).all())
    worst, undamped = 0.0, 0.0
    for sample in range(1 if rigid else 1 + RATE_SAMPLES):
        if sample:
            _scatter(mj, model, d, random)
        mj.mj_fwdPosition(model, d)
        lines = np.zeros((model.ntendon, model.nv))
        if model.ntendon:
            if not hasattr(model, "ten_J_rownnz"):
                refuse(mj, "the Jacobian of tendons")
            mj.mju_sparse2dense(lines, d.ten_J, model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind)
        c = _largest(mj, model, d, damping, slowed, lines)
        k = _largest(mj, model, d, stiffness, stretched, lines)
        worst, undamped = max(worst, (c + math.sqrt(c * c + 4 * k)) / 2), max(undamped, math.sqrt(k))
    return worst * h, undamped * h


def resisted(model: Any, drives: Iterable[int]) -> tuple[Floats, Floats, Integers]:
    """Stiffness and damping (nv,) of coordinates by springs, dampers and drives; where each joint's coordinates begin."""
    stiffness, damping, dof = np.zeros(model.nv), np.array(model.dof_damping), np.array(model.jnt_dofadr)
    stiffness[dof] += model.jnt_stiffness
    for actuator in drives:
        adr = dof[model.actuator_trnid[actuator, 0]]
        stiffness[adr] -= model.actuator_biasprm[actuator, 1]
        damping[adr] -= model.actuator_biasprm[actuator, 2]
    return stiffness, damping, dof


def _along_tendons(model: Any, drives: Iterable[int]) -> tuple[Floats, Floats]:
    """Stiffness and damping of tendons, with those of the actuators that pull at them: all but the joints' drives."""
    stiffness, damping = np.array(model.tendon_stiffness), np.array(model.tendon_damping)
    for actuator in sorted(set(range(model.nu)) - set(drives)):
        tendon = model.actuator_trnid[actuator, 0]
        stiffness[tendon] -= model.actuator_biasprm[actuator, 1]
        damping[tendon] -= model.actuator_biasprm[actuator, 2]
    return stiffness, damping


def _largest(mj: Any, model: Any, d: Any, own: Floats, along: Floats, lines: Floats) -> float:
    """The largest eigenvalue of M^-1 (diag(own) + lines' diag(along) lines); of many rows a bound, the largest row sum."""
    rows = np.vstack((np.diag(np.sqrt(own))[own > 0], np.sqrt(along)[:, None] * lines))
    if not rows.any():
        return 0.0
    moved = np.empty_like(rows)
    mj.mj_solveM(model, d, moved, np.ascontiguousarray(rows))
    product = rows @ moved.T
    return float(np.linalg.eigvalsh(product)[-1] if len(rows) <= EXACT_ROWS else np.abs(product).sum(axis=1).max())


def _scatter(mj: Any, model: Any, d: Any, random: np.random.Generator) -> None:
    """Turn every hinge and ball by chance, within limits; what flies or slides freely stays."""
    kinds = mj.mjtJoint
    for joint in range(model.njnt):
        adr, kind = model.jnt_qposadr[joint], model.jnt_type[joint]
        limited = bool(model.jnt_limited[joint])
        if kind == int(kinds.mjJNT_BALL):
            q = random.normal(size=4)
            d.qpos[adr : adr + 4] = q / np.linalg.norm(q)
        elif kind == int(kinds.mjJNT_HINGE) or (kind == int(kinds.mjJNT_SLIDE) and limited):
            low, high = model.jnt_range[joint] if limited else (-math.pi, math.pi)
            start = float(model.qpos0[adr])
            d.qpos[adr] = random.uniform(max(low, start - 2 * math.pi), min(high, start + 2 * math.pi))
