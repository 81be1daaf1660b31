"""What MuJoCo's own compiler makes of a robot file: URDF or MJCF, read back from the compiled model at qpos = 0."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.adapters.mujoco.vendor import mujoco_module
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene.parity.facts import FIXED, JointFacts, Law
from plumbline.harness.scene.parity.loaded import (
    Loaded,
    LoadedLink,
    Own,
    Request,
    gathered,
    in_packages,
    matrix_gap,
    own_values,
)


def load(path: Path, request: Request) -> Loaded:
    """The compiled model.

    The compiler welds a URDF's root to the world; a floating one is given a free joint through `MjSpec`, as users do. Meshes of
    known packages are named by their paths. Raises: Unsupported, Unavailable.
    """
    mj = mujoco_module()
    if path.suffix.lower() not in (".urdf", ".xml", ".mjcf"):
        raise Unsupported("the file", "MuJoCo's compiler reads URDF and MJCF")
    os.chdir(path.parent)
    notes: tuple[str, ...] = ()
    try:
        text = path.read_text(encoding="utf-8")
        model = _compiled(mj.MjSpec.from_file(str(path)), request)
    except ValueError as error:
        bare = _without_shapes(text)
        if bare is None:
            raise Unsupported("the file", f"MuJoCo's compiler refuses it: {error}") from None
        notes = (f"shapes were taken out, since MuJoCo's compiler refuses them: {error}",)
        try:
            model = _compiled(mj.MjSpec.from_string(bare), request)
        except ValueError as again:
            raise Unsupported("the file", f"MuJoCo's compiler refuses it, also without shapes: {again}") from None
    data = mj.MjData(model)
    data.qpos[:] = 0.0
    for k in np.flatnonzero(np.isin(model.jnt_type, (mj.mjtJoint.mjJNT_FREE, mj.mjtJoint.mjJNT_BALL))):
        free = model.jnt_type[k] == mj.mjtJoint.mjJNT_FREE
        data.qpos[model.jnt_qposadr[k] + (3 if free else 0)] = 1.0
    mj.mj_kinematics(model, data)
    laws = tuple(_laws(mj, model, data))
    links = [_link(mj, model, data, k) for k in range(1, model.nbody)]
    facts = gathered(f"MuJoCo {mj.__version__}", links, laws, frozenset({"speed"}))

    number = {_joint_name(model, j): j for j in range(model.njnt)}

    def matrix(q: dict[str, float]) -> Any:
        for name, value in q.items():
            data.qpos[model.jnt_qposadr[number[name]]] = value
        mj.mj_forward(model, data)
        full = np.zeros((model.nv, model.nv))
        try:
            mj.mj_fullM(model, full, data.qM)
        except (TypeError, AttributeError):
            mj.mj_fullM(model, data, full)
        order = [int(model.jnt_dofadr[number[name]]) for name in q]
        return full[np.ix_(order, order)]

    return Loaded(facts=facts, matrix_gap=matrix_gap(facts, matrix), notes=notes, own=_own(model))


def _own(model: Any) -> tuple[Own, ...]:
    """What the shapes that touch are given."""
    touching = np.flatnonzero(model.geom_contype | model.geom_conaffinity)
    sliding, torsional, rolling = model.geom_friction[touching].T
    return (
        *own_values("friction", sliding, "1"),
        *own_values("torsional friction", torsional, "m"),
        *own_values("rolling friction", rolling, "m"),
        *own_values("contact margin", model.geom_margin[touching], "m"),
        *own_values("contact time constant", model.geom_solref[touching, 0], "s"),
    )


def _compiled(spec: Any, request: Request) -> Any:
    for mesh in spec.meshes:
        target = in_packages(mesh.file, request.packages)
        if target is not None:
            mesh.file = str(target)
            spec.strippath = False
    if request.root == "floating":
        spec.worldbody.first_body().add_freejoint()
    return spec.compile()


def _laws(mj: Any, model: Any, data: Any) -> Iterator[Law]:
    """Equalities that are active from the start, with their numbers in W."""
    if model.opt.disableflags & mj.mjtDisableBit.mjDSBL_EQUALITY:
        return
    for k in np.flatnonzero(data.eq_active):
        kind, name = mj.mjtEq(int(model.eq_type[k])), model.equality(int(k)).name or f"equality_{k}"
        a, b, numbers = int(model.eq_obj1id[k]), int(model.eq_obj2id[k]), model.eq_data[k]
        if kind == mj.mjtEq.mjEQ_JOINT and b >= 0 and not numbers[2:5].any():
            start_a, start_b = (float(model.qpos0[model.jnt_qposadr[j]]) for j in (a, b))
            ratio, offset = float(numbers[1]), start_a + float(numbers[0]) - float(numbers[1]) * start_b
            yield Law(kind="mimic", name=_joint_name(model, a), partners=(_joint_name(model, b),), ratio=ratio, offset=offset)
        elif kind in (mj.mjtEq.mjEQ_CONNECT, mj.mjtEq.mjEQ_WELD):
            weld = kind == mj.mjtEq.mjEQ_WELD
            if model.eq_objtype[k] == mj.mjtObj.mjOBJ_SITE:
                points, bodies = [data.site_xpos[site].copy() for site in (a, b)], [int(model.site_bodyid[s]) for s in (a, b)]
            else:
                bodies, own = [a, b], (numbers[3:6], numbers[:3]) if weld else (numbers[:3], numbers[3:6])
                points = [data.xpos[body] + data.xmat[body].reshape(3, 3) @ p for body, p in zip(bodies, own, strict=True)]
            p_A, p_B = (tuple(float(x) for x in p) for p in points)
            sides = tuple(_mover(model, body) for body in bodies)
            yield Law(kind="closure", name=name, partners=sides, points=(p_A, p_B), whole=weld)  # type: ignore[arg-type]
        else:
            yield Law(kind="equality", name=name)


_PLANAR = {"_TX": ".x", "_TY": ".y", "_RZ": ".angle"}
"""How the compiler calls the three joints that it makes of a URDF's planar one, and what they are called here."""


def _joint_name(model: Any, j: int) -> str:
    name: str = model.joint(j).name or f"joint_{j}"
    body = int(model.jnt_bodyid[j])
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    beside = [model.joint(first + k).name for k in range(count)]
    if count == len(_PLANAR) and beside == [f"{beside[0][:-3]}{ending}" for ending in _PLANAR]:
        return name[:-3] + _PLANAR[name[-3:]]
    return name


def _mover(model: Any, body: int) -> str:
    """The joint that moves a body; that of the world is FIXED."""
    while body > 0:
        if model.body_jntnum[body]:
            return _joint_name(model, int(model.body_jntadr[body] + model.body_jntnum[body] - 1))
        body = int(model.body_parentid[body])
    return FIXED


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
        name=_joint_name(model, j),
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
