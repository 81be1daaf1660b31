"""What MuJoCo's own compiler makes of a robot file: URDF or MJCF, read back from the compiled model at qpos = 0."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.adapters.mujoco.vendor import mujoco_module
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import WORLD
from plumbline.harness.scene.importers.robot import Closure, Coordinate, Link, Need, Tie
from plumbline.harness.scene.parity.loaded import (
    Loaded,
    Own,
    Request,
    in_packages,
    matrix_gap,
    own_values,
    read_back,
    solid_of,
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
    ties, closures, needs = _equalities(mj, model, data)
    links = [Link(name=WORLD, parent=None), *(_link(mj, model, data, k, ties) for k in range(1, model.nbody))]
    robot = read_back(f"MuJoCo {mj.__version__}", links, closures, needs, wordless="speed")

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

    return Loaded(robot=robot, matrix_gap=matrix_gap(robot, matrix), notes=notes, own=_own(model))


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


def _equalities(mj: Any, model: Any, data: Any) -> tuple[dict[int, Tie], list[Closure], tuple[Need, ...]]:
    """Those that are active from the start: ties by joint, loops with their points in W, and others by name."""
    ties, closures, others = dict[int, Tie](), list[Closure](), list[str]()
    if model.opt.disableflags & mj.mjtDisableBit.mjDSBL_EQUALITY:
        return ties, closures, ()
    for k in np.flatnonzero(data.eq_active):
        kind, name = mj.mjtEq(int(model.eq_type[k])), model.equality(int(k)).name or f"equality_{k}"
        a, b, numbers = int(model.eq_obj1id[k]), int(model.eq_obj2id[k]), model.eq_data[k]
        if kind == mj.mjtEq.mjEQ_JOINT and b >= 0 and not numbers[2:5].any():
            start_a, start_b = (float(model.qpos0[model.jnt_qposadr[j]]) for j in (a, b))
            ratio, offset = float(numbers[1]), start_a + float(numbers[0]) - float(numbers[1]) * start_b
            ties[a] = Tie(joint=_joint_name(model, b), ratio=ratio, offset=offset)
        elif kind in (mj.mjtEq.mjEQ_CONNECT, mj.mjtEq.mjEQ_WELD):
            weld = kind == mj.mjtEq.mjEQ_WELD
            if model.eq_objtype[k] == mj.mjtObj.mjOBJ_SITE:
                points, bodies = [data.site_xpos[site].copy() for site in (a, b)], [int(model.site_bodyid[s]) for s in (a, b)]
            else:
                bodies, own = [a, b], (numbers[3:6], numbers[:3]) if weld else (numbers[:3], numbers[3:6])
                points = [data.xpos[body] + data.xmat[body].reshape(3, 3) @ p for body, p in zip(bodies, own, strict=True)]
            links = [_body_name(model, body) for body in bodies]
            closure = Closure(
                name=name, kind="fixed" if weld else "ball", link_A=links[0], link_B=links[1], anchor_A=points[0],
                anchor_B=points[1],
            )  # fmt: skip
            closures.append(closure)
        else:
            others.append(name)
    return ties, closures, (Need(kind="equality", element="equality", names=tuple(others)),) if others else ()


def _body_name(model: Any, k: int) -> str:
    name: str = model.body(k).name or f"body_{k}"
    return WORLD if k == 0 else name


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


def _link(mj: Any, model: Any, data: Any, k: int, ties: dict[int, Tie]) -> Link:
    R, first = data.ximat[k].reshape(3, 3), int(model.body_jntadr[k])
    return Link(
        name=_body_name(model, k),
        parent=_body_name(model, int(model.body_parentid[k])),
        coordinates=tuple(_joint(mj, model, data, first + j, ties) for j in range(int(model.body_jntnum[k]))),
        solid=solid_of(float(model.body_mass[k]), data.xipos[k].copy(), R @ np.diag(model.body_inertia[k]) @ R.T),
    )


def _joint(mj: Any, model: Any, data: Any, j: int, ties: dict[int, Tie]) -> Coordinate:
    dof = int(model.jnt_dofadr[j])
    kinds = {mj.mjtJoint.mjJNT_FREE: "free", mj.mjtJoint.mjJNT_BALL: "ball", mj.mjtJoint.mjJNT_SLIDE: "prismatic"}
    limited = bool(model.jnt_limited[j])
    stiffness = float(np.max(model.jnt_stiffness[j]))
    return Coordinate(
        name=_joint_name(model, j),
        kind=kinds.get(mj.mjtJoint(int(model.jnt_type[j])), "revolute"),  # type: ignore[arg-type]
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
        tie=ties.get(j),
    )
