"""MJCF: the model that MuJoCo's own compiler makes of it, so that defaults, classes, angles and inertias are the vendor's.

What is compiled has joint coordinates that begin at `ref`, springs that act from `springref`, inertias from geoms where the
file asks for them, and contacts by bit masks; all of that is read as it stands there.
"""

from collections.abc import Container
from dataclasses import replace
from pathlib import Path

import numpy as np

from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted, readable
from plumbline.harness.scene.importers import mjcf_actuators, mjcf_sensors, mjcf_shapes, urdf
from plumbline.harness.scene.importers.companion import Cameras
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.files import text_of
from plumbline.harness.scene.importers.importer import Reading
from plumbline.harness.scene.importers.mjcf_model import Model, compile_apart
from plumbline.harness.scene.importers.mjcf_text import Prepared, prepared
from plumbline.harness.scene.importers.poses import Array, Pose, matrix, pose
from plumbline.harness.scene.importers.robot import Closure, Coordinate, Kind, Link, Need, Robot, Solid, Tie
from plumbline.harness.scene.importers.xml_text import elements

_KINDS: dict[str, Kind] = {"hinge": "revolute", "slide": "prismatic", "ball": "ball", "free": "free"}


def read(path: Path, reading: Reading) -> Robot:
    """The robot of an MJCF file, or of a URDF with its ending. Raises: RobotError."""
    where = named(path)
    root = elements(text_of(path, where), where)
    if root.tag == "robot":
        return urdf.read(path, reading)
    text = prepared(root, reading.folders)
    model = compile_apart(text, where)
    name = readable(root.attributes.get("model", ""), 100) or path.stem
    return robot_of(model, text, name, where, reading.companion.keyframe, reading.companion.cameras)


def robot_of(
    model: Model, text: Prepared, name: str, source: str, keyframe: str | None = None, cameras: Cameras | None = None
) -> Robot:
    """The robot of a compiled model. Raises: RobotError."""
    _check(model, source)
    start = _start(model, keyframe, source)
    names = [model.name("body", k) for k in range(len(model.body_parentid))]
    names[0] = "world"
    for k, own in enumerate(names[1:], 1):
        if own == "world":
            names[k] = f"body_{k}"
    shapes, contacts, rows = mjcf_shapes.contact_laws(model, names)
    servos, pulls, more, needs = mjcf_actuators.read(model, start.ctrl)
    rows += more
    solids = mjcf_shapes.geometries(model, shapes, rows, needs)
    drawn, looks = mjcf_shapes.drawn(model, shapes), mjcf_shapes.looks(model, shapes)
    links = tuple(
        Link(
            name=names[k],
            parent=None if k == 0 else names[int(model.body_parentid[k])],
            X_PL=pose(model.body_pos[k], model.body_quat[k]),
            coordinates=_coordinates(model, k, start, servos, needs, source),
            solid=_solid(model, k),
            geometries=tuple(solids.get(k, ())),
            drawn=tuple(drawn.get(k, ())),
            looks=tuple(looks.get(k, ())),
            where=f"{source}: <body> {quoted(names[k], 80)}",
        )
        for k in range(len(names))
    )
    closures = _closures(model, names, rows, needs)
    links = _tied(model, links, needs)
    springs = mjcf_actuators.springs(model, names, rows)
    closures += springs.values()
    cords = mjcf_actuators.fixed(model, pulls, rows)
    needs += _others(model, text, {*springs, *cords})
    sensors, more = mjcf_sensors.read(model, names)
    seen, looks_on = mjcf_sensors.cameras(model, names, cameras)
    rows += [*more, *looks_on, *_beside(model, text, cords)]
    free = any(c.kind == "free" for link in links for c in link.coordinates)
    gravity = (0.0, 0.0, 0.0) if model.flag("gravity") else tuple(float(g) for g in model.opt_gravity)
    return Robot(
        name=name,
        links=links,
        closures=tuple(closures),
        tendons=tuple(cords.values()),
        root="floating" if free else "fixed",
        gravity=(gravity[0], gravity[1], gravity[2]),
        contacts=contacts,
        filter_world=False,
        collide=model.flag("filterparent"),
        sensors=(*sensors, *seen),
        rows=tuple(rows),
        needs=tuple(needs),
        wordless=frozenset({"speed"}),
        source=source,
    )


class _Start:
    """Terms: qpos, qvel, ctrl of the start."""

    def __init__(self, qpos: Array, qvel: Array, ctrl: Array) -> None:
        self.qpos, self.qvel, self.ctrl = qpos, qvel, ctrl


def _start(model: Model, keyframe: str | None, source: str) -> _Start:
    if keyframe is None:
        return _Start(model.qpos0, np.zeros(len(model.dof_damping)), np.zeros(model.key_ctrl.shape[1]))
    known = model.names["key"]
    if keyframe not in known:
        raise RobotError(
            f"{source}: keyframe {quoted(keyframe, 80)} is not in the file, expected one of {listed(known, 8) or 'none'}"
            f"{did_you_mean(keyframe, known)}"
        )
    k = known.index(keyframe)
    return _Start(model.key_qpos[k], model.key_qvel[k], model.key_ctrl[k])


def _check(model: Model, source: str) -> None:
    """What MuJoCo's compiler takes and no robot has. Raises: RobotError."""
    for k, (low, high) in enumerate(model.jnt_range):
        if model.jnt_limited[k] and low > high:
            joint = quoted(model.name("joint", k), 80)
            raise RobotError(f"{source}: <joint> {joint}: range is {low:g} to {high:g}, expected lower <= upper")
    for array, element in (("jnt_stiffness", "joint"), ("geom_friction", "geom"), ("body_mass", "body")):
        bad = np.argwhere(getattr(model, array) < 0)
        if len(bad):
            label = quoted(model.name(element, int(bad[0][0])), 80)
            raise RobotError(f"{source}: <{element}> {label}: {array.partition('_')[2]} is negative, expected 0 or more")
    for array in ("dof_damping", "dof_armature", "dof_frictionloss"):
        for dof in np.flatnonzero(getattr(model, array) < 0):
            index = int(np.flatnonzero(model.jnt_dofadr <= dof)[-1])
            value = float(getattr(model, array)[dof])
            raise RobotError(
                f"{source}: <joint> {quoted(model.name('joint', index), 80)}: {array.partition('_')[2]} is {value:g}, "
                "expected 0 or more"
            )


def _solid(model: Model, k: int) -> Solid | None:
    mass = float(model.body_mass[k])
    if mass <= 0:
        return None
    R = matrix(model.body_iquat[k])
    return Solid(mass, np.array(model.body_ipos[k]), R @ np.diag(model.body_inertia[k]) @ R.T)


def _coordinates(
    model: Model, body: int, start: _Start, servos: "mjcf_actuators.Servos", needs: list[Need], source: str
) -> tuple[Coordinate, ...]:
    first = int(model.body_jntadr[body])
    return tuple(_coordinate(model, first + k, start, servos, needs, source) for k in range(int(model.body_jntnum[body])))


def _coordinate(
    model: Model, j: int, start: _Start, servos: "mjcf_actuators.Servos", needs: list[Need], source: str
) -> Coordinate:
    kind = _KINDS[model.word("Joint", int(model.jnt_type[j]))]
    name, dof, at = model.name("joint", j), int(model.jnt_dofadr[j]), int(model.jnt_qposadr[j])
    width = {"free": 6, "ball": 3}.get(kind, 1)
    here = slice(dof, dof + width)
    no_spring, no_damper, no_limit = model.flag("spring"), model.flag("damper"), model.flag("limit")
    damping = 0.0 if no_damper else float(model.dof_damping[here].max())
    stiffness = 0.0 if no_spring else float(np.max(model.jnt_stiffness[j]))
    limited = bool(model.jnt_limited[j]) and not no_limit
    armature = float(model.dof_armature[here].max())
    friction_loss = 0.0 if model.flag("frictionloss") else float(model.dof_frictionloss[here].max())
    if model.jnt_stiffnesspoly[j].any() or model.dof_dampingpoly[here].any() or model.jnt_springyield[j].any():
        needs += Need.of("nonlinear", "joint", (name,))
    where = f"{source}: <joint> {quoted(name, 80)}"
    if kind in ("free", "ball"):
        if damping > 0 or stiffness > 0 or limited:
            words = [w for w, is_so in (("damping", damping > 0), ("stiffness", stiffness > 0), ("range", limited)) if is_so]
            needs += Need.of("ball_spring", "joint", (name,), f"{' and '.join(words)} of a {kind} joint")
        return Coordinate(
            name=name,
            kind=kind,
            anchor=np.array(model.jnt_pos[j]),
            X_start=_displaced(model, j, kind, start.qpos[at : at + 7]),
            w_start=np.array(start.qvel[here][-3:], dtype=np.float64),
            v_start=np.array(start.qvel[here][:3], dtype=np.float64) if kind == "free" else None,
            where=where,
            armature=armature,
            friction_loss=friction_loss,
        )
    axis = np.array(model.jnt_axis[j], dtype=np.float64)
    if not np.linalg.norm(axis) > 0:
        raise RobotError(f"{where}: axis {axis.tolist()}, expected a direction")
    return Coordinate(
        name=name,
        kind=kind,
        axis=axis / np.linalg.norm(axis),
        anchor=np.array(model.jnt_pos[j]),
        reference=float(model.qpos0[at]),
        lower=float(model.jnt_range[j, 0]) if limited else None,
        upper=float(model.jnt_range[j, 1]) if limited else None,
        stiffness=stiffness,
        damping=damping,
        rest=float(model.qpos_spring[at]),
        position=float(start.qpos[at]),
        velocity=float(start.qvel[dof]),
        servo=servos.get(j),
        where=where,
        armature=armature,
        friction_loss=friction_loss,
        effort=float(np.abs(model.jnt_actfrcrange[j]).max()) if model.jnt_actfrclimited[j] else None,
    )


def _displaced(model: Model, j: int, kind: Kind, qpos: Array) -> Pose:
    """Where a ball or free joint starts, in the frame of its reference."""
    if kind == "ball":
        return pose((0.0, 0.0, 0.0), qpos[:4])
    body = int(np.flatnonzero(model.body_jntadr == j)[0])
    reference = pose(model.body_pos[body], model.body_quat[body])
    return reference.inverse() @ pose(qpos[:3], qpos[3:7])


def _closures(model: Model, names: list[str], rows: list[Fidelity], needs: list[Need]) -> list[Closure]:
    """Connections and welds as joints; the others are needs."""
    closures: list[Closure] = []
    if model.flag("equality"):
        return closures
    for k, raw in enumerate(model.eq_type):
        word, name = model.word("Eq", int(raw)), model.name("equality", k)
        if not model.eq_active0[k]:
            rows += Fidelity.left_out("equality", name, "the file starts without it")
            continue
        if word == "joint":
            continue
        if word not in ("connect", "weld"):
            needs += Need.of("equality", "equality", (name,), f"of kind {word}")
            continue
        a, b, data = int(model.eq_obj1id[k]), int(model.eq_obj2id[k]), model.eq_data[k]
        if model.word("Obj", int(model.eq_objtype[k])) == "site":
            p_A, p_B = model.site_pos[a], model.site_pos[b]
            a, b = int(model.site_bodyid[a]), int(model.site_bodyid[b])
            if word == "weld":
                needs += Need.of("equality", "equality", (name,), "a weld of two sites")
                continue
        else:
            p_A, p_B = (data[:3], data[3:6]) if word == "connect" else (data[3:6], data[:3])
        closures.append(
            Closure(
                name=name,
                kind="ball" if word == "connect" else "fixed",
                link_A=names[a],
                link_B=names[b],
                anchor_A=np.array(p_A, dtype=np.float64),
                anchor_B=np.array(p_B, dtype=np.float64),
                R_AB=matrix(data[6:10]) if word == "weld" else None,
            )
        )
    rows += Fidelity.told("equality", [closure.name for closure in closures])
    return closures


def _tied(model: Model, links: tuple[Link, ...], needs: list[Need]) -> tuple[Link, ...]:
    """The links with the ties of the linear equalities between two joints; other equalities of joints are needs.

    The file's x - x_0 = c_0 + c_1 (y - y_0) + ..., x_0 and y_0 being where the model is drawn.
    """
    if model.flag("equality"):
        return links
    single = {c.name for link in links for c in link.coordinates if c.kind in ("revolute", "prismatic")}
    ties: dict[str, Tie] = {}
    for k in np.flatnonzero(model.eq_active0):
        if model.word("Eq", int(model.eq_type[k])) != "joint":
            continue
        a, b, terms = int(model.eq_obj1id[k]), int(model.eq_obj2id[k]), [float(c) for c in model.eq_data[k][:5]]
        ends = {model.name("joint", j) for j in (a, b)} if b >= 0 else set()
        if len(ends) < 2 or not ends <= single or any(terms[2:]) or terms[1] == 0 or model.name("joint", a) in ties:
            needs += Need.of("equality", "equality", (model.name("equality", int(k)),), "of joints that is no line")
            continue
        x_0, y_0 = (float(model.qpos0[model.jnt_qposadr[j]]) for j in (a, b))
        ties[model.name("joint", a)] = Tie(
            joint=model.name("joint", b),
            ratio=terms[1],
            offset=x_0 + terms[0] - terms[1] * y_0,
            kinds=frozenset(("mimic", "equality")),
            soft=True,
        )
    return tuple(replace(link, coordinates=tuple(replace(c, tie=ties.get(c.name)) for c in link.coordinates)) for link in links)


def _others(model: Model, text: Prepared, springs: Container[int]) -> list[Need]:
    needs = [Need(kind=kind, element=kind, names=tuple(names)) for kind, names in text.strange.items()]
    active = [
        model.name("tendon", k)
        for k in range(len(model.tendon_limited))
        if k not in springs and (mjcf_actuators.pulls(model, k) or model.tendon_limited[k])
    ]
    needs += Need.of("tendon", "tendon", active)
    needs += Need.of("gravity_compensation", "body", (model.name("body", k) for k in np.flatnonzero(model.body_gravcomp)))
    if model.opt_density > 0 or model.opt_viscosity > 0:
        size = f"of density {float(model.opt_density):g} kg/m3 and viscosity {float(model.opt_viscosity):g} Pa s"
        needs += Need.of("fluid", "option", ("medium",), size)
    sticky = [*np.flatnonzero(model.geom_adhesion), *np.flatnonzero(model.geom_surfacevel.any(axis=1))]
    return needs + Need.of("adhesion", "geom", (model.name("geom", k) for k in sticky))


def _beside(model: Model, text: Prepared, cords: Container[int]) -> list[Fidelity]:
    """Rows for what stands beside the motion."""
    rows, why = list[Fidelity](), "how it looks; the motion does not depend on it"
    for tag, count in text.removed.items():
        rows += Fidelity.left_out(tag, "", why, count=count)
    rows += Fidelity.left_out("light", "", "it shows, and moves nothing", count=len(model.names["light"]))
    passive = [
        model.name("tendon", k)
        for k in range(len(model.tendon_limited))
        if k not in cords and not model.tendon_limited[k] and not mjcf_actuators.pulls(model, k)
    ]
    rows += Fidelity.left_out("tendon", passive, "it has no force of its own where it has no spring, damper, friction or limit")
    held = [model.name("body", k) for k in np.flatnonzero(model.body_mocapid >= 0)]
    rows += Fidelity.approximated("mocap body", held, "a static body", consequence="nothing moves it from outside")
    soft = [model.name("joint", k) for k in range(len(model.jnt_limited)) if model.jnt_limited[k]]
    if soft and not model.flag("limit"):
        rows += Fidelity.told("range", soft)
    rows += Fidelity.told("option", "", float(model.opt_timestep))
    return rows
