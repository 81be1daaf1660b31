"""A scene becomes a model of MuJoCo: everything in its order."""

from typing import Any

import numpy as np

from plumbline.adapters.mujoco.after_compile import settle
from plumbline.adapters.mujoco.bodies import add_body
from plumbline.adapters.mujoco.closures import close_loop, couple, keep_distance
from plumbline.adapters.mujoco.collisions import add_shapes
from plumbline.adapters.mujoco.drive_damping import damp_joints
from plumbline.adapters.mujoco.drives import add_drives
from plumbline.adapters.mujoco.flags import set_options
from plumbline.adapters.mujoco.inertial import add_inertial
from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.pressed_through import pressed_through
from plumbline.adapters.mujoco.resolved import resolved_settings
from plumbline.adapters.mujoco.simulation import MujocoSimulation
from plumbline.adapters.mujoco.sparse_factor import may_err, sparse
from plumbline.adapters.mujoco.start import check_start, start
from plumbline.adapters.mujoco.surfaces import Law, contact_laws
from plumbline.adapters.mujoco.tendons import add_tendon
from plumbline.adapters.mujoco.trees import Link
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.adapters.mujoco.vendor import flag
from plumbline.adapters.mujoco.world import Hung, Indices, World
from plumbline.harness.adapter import Notice, Settings, Unsupported
from plumbline.harness.adapter.between import chains
from plumbline.harness.scene import Distance, Effect, Fixed, Joint, Prismatic, Revolute, Scene


def build(mj: Any, scene: Scene, settings: Settings) -> MujocoSimulation:
    """Exactly this scene, compiled, in its initial state. Raises: Unsupported, SettingsError."""
    plan = Plan.of(scene, settings)
    draft = Draft(mj, mj.MjSpec())
    set_options(plan, draft)
    laws = _laws(plan, draft)
    for link in plan.links:
        add_body(plan, draft, link)
    add_shapes(plan, draft, laws)
    for joint in plan.loops:
        close_loop(plan, draft, joint)
    for joint in plan.joints:
        if isinstance(joint, Distance):
            keep_distance(plan, draft, joint)
        if isinstance(joint, Revolute | Prismatic) and joint.coupling is not None:
            couple(plan, draft, joint.name, joint.coupling)
    if Effect.DRIVES in plan.effects:
        add_drives(plan, draft)
    for tendon in (plan.scene.tendons or ()) if Effect.JOINTS in plan.effects else ():
        add_tendon(plan, draft, tendon)
    if Effect.SENSING in plan.effects:
        add_inertial(plan, draft)
    try:
        model = draft.spec.compile()
    except (ValueError, RuntimeError, mj.FatalError) as error:
        raise Unsupported("scene", f"MuJoCo's compiler refuses it: {str(error).strip()}") from error
    tolerance_scale = settle(plan, draft, model)
    world = World(mj, model, mj.MjData(model), scene, _indices(plan, draft, model))
    start(plan, draft, world)
    draft.damped_joints = damp_joints(draft, world, plan.h)
    resolved = resolved_settings(plan, draft, model, tolerance_scale)
    simulation = MujocoSimulation(world, resolved, _notices(plan, mj, model))
    check_start(plan, world, simulation)
    return simulation


def _laws(plan: Plan, draft: Draft) -> dict[frozenset[str], Law]:
    """The law of each pair of materials; friction with restitution takes the elliptic cone. Raises: Unsupported."""
    if plan.options.fast_steps is not None and Effect.CONTACT in plan.effects:
        draft.pressed = pressed_through(plan)
    laws = contact_laws(plan.scene, plan.effects, plan.options, plan.h, plan.settings.integrator, draft.pressed)
    draft.rebounds = any(law.solref[0] < 0 for law in laws.values())
    if any(law.solref_friction is not None for law in laws.values()):
        if plan.options.cone == "pyramidal":
            raise Unsupported("friction with restitution on a pyramidal cone", "MuJoCo's pyramid mixes the two directions")
        draft.spec.option.cone = flag(draft.mj, "mjtCone", "mjCONE_ELLIPTIC")
    return laws


def _indices(plan: Plan, draft: Draft, model: Any) -> Indices:
    """Where the scene's bodies, drives and sensors stand in a compiled model."""
    carriers = [plan.carrier[k] for k in range(len(plan.scene.bodies))]
    body = np.array([model.body(f"b{k}").id for k in carriers], dtype=np.int64)
    scene_body = np.full(model.nbody, -1, dtype=np.int64)
    scene_body[body] = carriers
    owner = scene_body[model.geom_bodyid]
    for name, k in draft.planted.items():
        owner[model.geom(name).id] = k
    q_BM = np.array(plan.q_BM)
    turned = bool((q_BM != (1.0, 0.0, 0.0, 0.0)).any())
    return Indices(
        body=body,
        owner=owner,
        q_MB=q_BM * (1.0, -1.0, -1.0, -1.0) if turned else None,
        single=all(link.above < 0 and (link.joint is None or isinstance(link.joint, Fixed)) for link in plan.links),
        drives=dict(draft.drives),
        hung={link.joint.name: _hung(plan, model, link, link.joint) for link in plan.links if link.joint is not None},
        inertial={
            name: (int(model.sensor(f"force:{name}").adr[0]), int(model.sensor(f"rate:{name}").adr[0]))
            for name in draft.inertial
        },
        chains=chains(plan.scene),
    )


def _hung(plan: Plan, model: Any, link: Link, joint: Joint) -> Hung:
    """Where a native joint or a weld stands."""
    child = plan.index[joint.child]
    anchor = getattr(joint, "anchor_W", plan.p[child])
    anchor_M = None if plan.scene.bodies[child].massless else plan.R_WM[child].T @ (np.array(anchor) - plan.p[child])
    native = -1 if isinstance(joint, Fixed) else int(model.joint(f"f{link.body}").id)
    return Hung(plan.carrier[link.body], native, link.turned, anchor_M)


def _notices(plan: Plan, mj: Any, model: Any) -> tuple[Notice, ...]:
    """Effects that could not be left out or in, and the faults of this version that the model may meet."""
    notices = []
    if Effect.GYROSCOPIC not in plan.effects and any(body.movable for body in plan.scene.bodies):
        notices.append(Notice("gyroscopic terms, which are part of the bias force", "surplus", Effect.GYROSCOPIC))
    if plan.passable:
        text = "continuous collision: speculative contacts are off unless asked for"
        notices.append(Notice(text, "missing", Effect.CONTINUOUS_COLLISION))
    if sparse(mj, model) and may_err(plan, mj, model):
        notices.append(Notice("mujoco 4.0.0: the sparse factor of the Newton solver is wrong where constraints couple hinges"))
    return tuple(notices)
