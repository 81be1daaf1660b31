"""What MuJoCo's own compiler makes of a robot file: URDF or MJCF, read back from the compiled model at qpos = 0."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from adapters.mujoco.vendor import mujoco_module
from harness.adapter import Unsupported
from harness.scene.parity.facts import FIXED, JointFacts
from harness.scene.parity.loaded import Loaded, LoadedLink, gathered, matrix_gap

__all__ = ["load"]


def load(path: Path) -> Loaded:
    """The compiled model. A URDF's root is welded to the world, as the compiler does. Raises: Unsupported, Unavailable."""
    mj = mujoco_module()
    os.chdir(path.parent)
    notes: tuple[str, ...] = ()
    try:
        text = path.read_text(encoding="utf-8")
        model = mj.MjModel.from_xml_path(str(path))
    except ValueError as error:
        bare = _without_shapes(text)
        if bare is None:
            raise Unsupported("the file", f"MuJoCo's compiler refuses it: {error}") from None
        notes = (f"shapes were taken out, since MuJoCo's compiler refuses them: {error}",)
        try:
            model = mj.MjModel.from_xml_string(bare)
        except ValueError as again:
            raise Unsupported("the file", f"MuJoCo's compiler refuses it, also without shapes: {again}") from None
    data = mj.MjData(model)
    data.qpos[:] = 0.0
    for k in np.flatnonzero(np.isin(model.jnt_type, (mj.mjtJoint.mjJNT_FREE, mj.mjtJoint.mjJNT_BALL))):
        free = model.jnt_type[k] == mj.mjtJoint.mjJNT_FREE
        data.qpos[model.jnt_qposadr[k] + (3 if free else 0)] = 1.0
    mj.mj_kinematics(model, data)
    laws = tuple(
        ("mimic", model.joint(int(model.eq_obj1id[k])).name)
        for k in range(model.neq)
        if model.eq_type[k] == mj.mjtEq.mjEQ_JOINT
    )
    links = [_link(mj, model, data, k) for k in range(1, model.nbody)]
    facts = gathered(f"MuJoCo {mj.__version__}", links, laws, frozenset({"speed"}))

    def matrix(q: dict[str, float]) -> Any:
        for name, value in q.items():
            data.qpos[model.joint(name).qposadr[0]] = value
        mj.mj_forward(model, data)
        full = np.zeros((model.nv, model.nv))
        try:
            mj.mj_fullM(model, full, data.qM)
        except (TypeError, AttributeError):
            mj.mj_fullM(model, data, full)
        order = [int(model.joint(name).dofadr[0]) for name in q]
        return full[np.ix_(order, order)]

    return Loaded(facts=facts, matrix_gap=matrix_gap(facts, matrix), notes=notes)


def _without_shapes(text: str) -> str | None:
    """A URDF without visual and collision elements, where every link with shapes has an <inertial>; None otherwise."""
    from defusedxml.ElementTree import fromstring, tostring

    root = fromstring(text)
    if root.tag != "robot":
        return None
    for link in root.iter("link"):
        shapes = [child for child in link if child.tag in ("visual", "collision")]
        if shapes and link.find("inertial") is None and any(child.tag == "collision" for child in shapes):
            return None
        for child in shapes:
            link.remove(child)
    bare: str = tostring(root, encoding="unicode")
    return bare


def _link(mj: Any, model: Any, data: Any, k: int) -> LoadedLink:
    R = data.ximat[k].reshape(3, 3)
    first, parent = int(model.body_jntadr[k]), int(model.body_parentid[k])
    return LoadedLink(
        name=model.body(k).name or f"body_{k}",
        parent=None if parent == 0 else model.body(parent).name or f"body_{parent}",
        joints=tuple(_joint(mj, model, data, first + j) for j in range(int(model.body_jntnum[k]))),
        mass=float(model.body_mass[k]),
        centre=data.xipos[k].copy(),
        inertia=R @ np.diag(model.body_inertia[k]) @ R.T,
    )


def _joint(mj: Any, model: Any, data: Any, j: int) -> JointFacts:
    dof = int(model.jnt_dofadr[j])
    kinds = {mj.mjtJoint.mjJNT_FREE: "free", mj.mjtJoint.mjJNT_BALL: "ball", mj.mjtJoint.mjJNT_SLIDE: "prismatic"}
    limited = bool(model.jnt_limited[j])
    stiffness = float(np.max(model.jnt_stiffness[j]))
    return JointFacts(
        name=model.joint(j).name or f"joint_{j}",
        kind=kinds.get(mj.mjtJoint(int(model.jnt_type[j])), "revolute"),  # type: ignore[arg-type]
        parent=FIXED,
        axis=data.xaxis[j].copy(),
        anchor=data.xanchor[j].copy(),
        lower=float(model.jnt_range[j, 0]) if limited else None,
        upper=float(model.jnt_range[j, 1]) if limited else None,
        damping=float(model.dof_damping[dof]),
        stiffness=stiffness,
        rest=float(model.qpos_spring[model.jnt_qposadr[j]]) if stiffness > 0 else 0.0,
        armature=float(model.dof_armature[dof]),
        friction_loss=float(model.dof_frictionloss[dof]),
        effort=float(np.abs(model.jnt_actfrcrange[j]).max()) if model.jnt_actfrclimited[j] else None,
    )
